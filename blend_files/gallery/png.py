# SPDX-License-Identifier: GPL-3.0-or-later
"""PNG files from pixels, small ones: what the eye does not see is rounded away. No bpy.

Blender's own writer would pass the pixels through a scene's colour management and compresses less."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterator

import numpy as np

_STEP = 2  # of 256 shades: not seen, and what is written a quarter smaller
_STEPS = (1, 2, 3, 4, 5, 6, 8, 10, 16)


def write_png(pixels: np.ndarray, step: int = _STEP) -> bytes:
    """The file of pixels (height, width, 3) uint8, top row first, each rounded to a multiple of `step`; white stays."""
    height, width, _ = pixels.shape
    rounded = np.minimum((pixels.astype(np.int32) + step // 2) // step * step, 255).astype(np.uint8)
    rounded[pixels == 255] = 255
    packed = min((zlib.compress(lines, 9) for lines in _filtered(rounded)), key=len)
    chunks = (
        (b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)),
        (b"IDAT", packed),
        (b"IEND", b""),
    )
    return b"\x89PNG\r\n\x1a\n" + b"".join(
        struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data)) for kind, data in chunks
    )


def write_below(pixels: np.ndarray, limit: int) -> bytes:
    """The finest file of at most `limit` bytes; the coarsest that there is if none is so small."""
    for step in _STEPS:
        content = write_png(pixels, step)
        if len(content) <= limit:
            break
    return content


def _filtered(pixels: np.ndarray) -> Iterator[bytes]:
    """Rows as PNG filters them (PNG specification 1.2, section 9): none, all by their left neighbours, and each by the
    filter that leaves least, which is best where there is grain."""
    height = len(pixels)
    rows = pixels.reshape(height, -1)
    left = np.zeros_like(rows)
    left[:, 3:] = rows[:, :-3]
    above = np.zeros_like(rows)
    above[1:] = rows[:-1]
    choices = np.stack([rows, rows - left, rows - above])  # None, Sub, Up; uint8 wraps round as it should
    sums = np.minimum(choices, 256 - choices.astype(np.int32)).sum(2)
    for best in (np.zeros(height, np.int64), np.ones(height, np.int64), sums.argmin(0)):
        yield np.concatenate([best[:, None].astype(np.uint8), choices[best, np.arange(height)]], 1).tobytes()


def halved(pixels: np.ndarray) -> np.ndarray:
    """Pixels (height, width, 3) uint8 at half the size, each the mean of four; an odd last row or column goes."""
    height, width = (n // 2 * 2 for n in pixels.shape[:2])
    blocks = pixels[:height, :width].reshape(height // 2, 2, width // 2, 2, 3).astype(np.float64)
    return np.round(blocks.mean((1, 3))).astype(np.uint8)
