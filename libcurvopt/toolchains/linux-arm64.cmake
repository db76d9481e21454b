# SPDX-License-Identifier: GPL-3.0-or-later
# Linux on 64-bit ARM by Debian's cross compiler (gcc-aarch64-linux-gnu).
set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_SYSTEM_PROCESSOR aarch64)
set(CURVOPT_TRIPLE aarch64-linux-gnu)
set(CMAKE_C_COMPILER ${CURVOPT_TRIPLE}-gcc)
set(CMAKE_CXX_COMPILER ${CURVOPT_TRIPLE}-g++)
set(CMAKE_CROSSCOMPILING_EMULATOR qemu-aarch64 -L /usr/${CURVOPT_TRIPLE})
include(${CMAKE_CURRENT_LIST_DIR}/archives.cmake)
