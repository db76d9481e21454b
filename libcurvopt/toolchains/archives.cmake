# SPDX-License-Identifier: GPL-3.0-or-later
# Where the static archives of a cross build lie (archives.sh), and that nothing of the building machine is found instead.
get_filename_component(CURVOPT_ARCHIVES ${CMAKE_CURRENT_LIST_DIR}/../../build/cross/${CURVOPT_TRIPLE} ABSOLUTE)
set(CMAKE_FIND_ROOT_PATH ${CURVOPT_ARCHIVES})
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
set(CMAKE_FIND_ROOT_PATH_MODE_LIBRARY ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_INCLUDE ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_PACKAGE ONLY)
