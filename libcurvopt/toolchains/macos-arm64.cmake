# SPDX-License-Identifier: GPL-3.0-or-later
# macOS 11 and later on Apple's processors.
set(CMAKE_SYSTEM_PROCESSOR arm64)
include(${CMAKE_CURRENT_LIST_DIR}/macos.cmake)
