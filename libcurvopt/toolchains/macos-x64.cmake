# SPDX-License-Identifier: GPL-3.0-or-later
# macOS 11 and later on Intel's processors.
set(CMAKE_SYSTEM_PROCESSOR x86_64)
include(${CMAKE_CURRENT_LIST_DIR}/macos.cmake)
