# SPDX-License-Identifier: GPL-3.0-or-later
# Windows on x86-64 by Debian's mingw-w64 (gcc-mingw-w64-x86-64-posix). Everything is linked statically: what is built
# needs DLLs of the system alone.
set(CMAKE_SYSTEM_NAME Windows)
set(CMAKE_SYSTEM_PROCESSOR x86_64)
set(CURVOPT_TRIPLE x86_64-w64-mingw32)
set(CMAKE_C_COMPILER ${CURVOPT_TRIPLE}-gcc-posix)
set(CMAKE_CXX_COMPILER ${CURVOPT_TRIPLE}-g++-posix)
set(CMAKE_RC_COMPILER ${CURVOPT_TRIPLE}-windres)
# No time of the link in what is built: the same sources give the same bytes. The library asks for no console.
set(CMAKE_EXE_LINKER_FLAGS_INIT "-static -Wl,--no-insert-timestamp")
set(CMAKE_SHARED_LINKER_FLAGS_INIT "-static -Wl,--no-insert-timestamp -Wl,--subsystem,windows")
# GCC aligns the stack to 16 bytes there and believes in 32 (GCC bug 54412); the assembler makes such accesses unaligned
# ones. libcurvopt/notes/97-vectors-on-windows.md
set(CMAKE_C_FLAGS_INIT -Wa,-muse-unaligned-vector-move)
# C99's printf formats (%zu, %lld) instead of those of Microsoft's C library.
add_compile_definitions(__USE_MINGW_ANSI_STDIO=1)
# Wine, for the tests: Debian's wine64 puts it where no path leads. Its drives and registry lie in the build's folder. It
# is silent but for what makes it end a program by itself, whose exit code is 1, too.
find_program(CURVOPT_WINE NAMES wine64 wine PATHS /usr/lib/wine)
if(CURVOPT_WINE)
  set(CMAKE_CROSSCOMPILING_EMULATOR env WINEPREFIX=${CMAKE_BINARY_DIR}/wine WINEDEBUG=-all,err+seh,err+virtual,err+module,err+process WINEDLLOVERRIDES=mscoree,mshtml=
      ${CURVOPT_WINE})
endif()
include(${CMAKE_CURRENT_LIST_DIR}/archives.cmake)
