# SPDX-License-Identifier: GPL-3.0-or-later
"""What batch runs that were killed have left beside their outputs. No bpy."""

from __future__ import annotations

import contextlib
import ctypes
import os
import re
import sys
from pathlib import Path

_MAY_ASK = 0x1000  # PROCESS_QUERY_LIMITED_INFORMATION
_NO_SUCH_PROCESS = 87  # ERROR_INVALID_PARAMETER


def remove(path: Path) -> None:
    """Remove temporary files of this output, .STEM.PROCESS.SUFFIX and what Blender writes before it renames that, whose
    process is gone or has the number of this one. Runs of other machines on a folder that is shared are not seen."""
    pattern = re.compile(rf"\.{re.escape(path.stem)}\.(\d{{1,10}}){re.escape(path.suffix)}@?")
    try:
        names = os.listdir(path.parent)
    except OSError:
        return  # the output cannot be made there either, which is said later
    for name in names:
        found = pattern.fullmatch(name)
        if found and (int(found.group(1)) == os.getpid() or is_gone(int(found.group(1)))):
            with contextlib.suppress(OSError):  # a folder, or not ours to remove
                (path.parent / name).unlink()


def is_gone(process: int) -> bool:
    """Whether no process has this number."""
    if sys.platform == "win32":  # there os.kill() would end it
        kernel = ctypes.WinDLL("kernel32", use_last_error=True)
        kernel.OpenProcess.restype = ctypes.c_void_p
        handle = kernel.OpenProcess(_MAY_ASK, False, process)
        if handle:
            kernel.CloseHandle(ctypes.c_void_p(handle))
        return not handle and ctypes.get_last_error() == _NO_SUCH_PROCESS
    try:
        os.kill(process, 0)
    except (ProcessLookupError, OverflowError):
        return True
    except PermissionError:
        return False
    return False
