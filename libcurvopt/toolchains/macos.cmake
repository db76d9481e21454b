# SPDX-License-Identifier: GPL-3.0-or-later
# macOS by Debian's clang and lld, without Apple's SDK: archives.sh makes what stands in for it. Nothing here can run what
# is built. libcurvopt/notes/99-macos-without-apples-sdk.md
set(CMAKE_SYSTEM_NAME Darwin)
set(CURVOPT_TRIPLE ${CMAKE_SYSTEM_PROCESSOR}-apple-macos11)
include(${CMAKE_CURRENT_LIST_DIR}/archives.cmake)
set(CMAKE_OSX_SYSROOT ${CURVOPT_ARCHIVES}/sysroot)
set(CMAKE_OSX_DEPLOYMENT_TARGET 11.0)
set(CMAKE_OSX_ARCHITECTURES ${CMAKE_SYSTEM_PROCESSOR})
set(CMAKE_C_COMPILER clang-14)
set(CMAKE_C_COMPILER_TARGET ${CURVOPT_TRIPLE})
set(CMAKE_AR llvm-ar-14)
set(CMAKE_RANLIB llvm-ranlib-14)
set(CMAKE_INSTALL_NAME_TOOL llvm-install-name-tool-14)
foreach(kind IN ITEMS EXE SHARED)
  set(CMAKE_${kind}_LINKER_FLAGS_INIT -fuse-ld=lld)
endforeach()
