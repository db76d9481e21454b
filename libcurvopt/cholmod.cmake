# SPDX-License-Identifier: GPL-3.0-or-later
# Target curvopt_cholmod carries CHOLMOD, its BLAS and what these need; link it last.
#
# With CURVOPT_BUNDLE_CHOLMOD they are static archives inside our own library: an add-on cannot ask its users for them.
# Without, they are shared libraries of the system: what a distribution's package wants.
add_library(curvopt_cholmod INTERFACE)

if(NOT CURVOPT_BUNDLE_CHOLMOD)
  find_path(CURVOPT_CHOLMOD_INCLUDE suitesparse/cholmod.h REQUIRED)
  find_library(CURVOPT_CHOLMOD_SHARED cholmod REQUIRED)
  find_package(LAPACK REQUIRED) # and its BLAS
  target_include_directories(curvopt_objects PRIVATE ${CURVOPT_CHOLMOD_INCLUDE})
  target_link_libraries(curvopt_cholmod INTERFACE ${CURVOPT_CHOLMOD_SHARED} ${LAPACK_LIBRARIES} ${BLAS_LIBRARIES} m)
  return()
endif()

# Our own BLAS: the same bits on every processor, and a library of a fourteenth of the size that it has with OpenBLAS
# (notes/96-blas-of-our-own.md).
add_library(curvopt_own_blas STATIC src/linalg/own_blas.c src/base/instruction_set.c)
target_include_directories(curvopt_own_blas PRIVATE include src)
if(CURVOPT_SANITIZE_MEMORY) # which does not see what CHOLMOD writes to the stack, such as arguments of the BLAS
  set(CURVOPT_BLAS_OPTIONS -fno-sanitize=memory)
endif()
target_compile_options(curvopt_own_blas PRIVATE ${CURVOPT_BLAS_OPTIONS})
curvopt_add_vectors(curvopt_own_blas src/linalg/blas_routines.c ${CURVOPT_BLAS_OPTIONS})

set(archives)
foreach(name cholmod amd camd colamd ccolamd suitesparseconfig)
  find_library(CURVOPT_${name} NAMES lib${name}.a)
  if(CURVOPT_${name})
    list(APPEND archives ${CURVOPT_${name}})
  elseif(NOT name MATCHES "camd|ccolamd") # archives of libcurvopt/toolchains/archives.sh do without these
    message(FATAL_ERROR "lib${name}.a was not found (Debian: libsuitesparse-dev); "
                        "with CURVOPT_BUNDLE_CHOLMOD=OFF shared libraries are used")
  endif()
endforeach()
find_path(CURVOPT_CHOLMOD_INCLUDE suitesparse/cholmod.h REQUIRED)
target_include_directories(curvopt_objects PRIVATE ${CURVOPT_CHOLMOD_INCLUDE})

if(CMAKE_CROSSCOMPILING) # archives without parallel loops and METIS
  if(APPLE) # whose linker goes round by itself
    target_link_libraries(curvopt_cholmod INTERFACE ${archives} curvopt_own_blas m)
  else()
    target_link_libraries(curvopt_cholmod INTERFACE -Wl,--start-group ${archives} curvopt_own_blas -Wl,--end-group m)
  endif()
  return()
endif()

# What we use of SuiteSparse has no parallel loops, but its later versions ask for the number of threads and the time by
# functions of GCC's run time of threads, libgomp: copies of the archives call ours instead, and libgomp is not needed.
if(NOT CMAKE_OBJCOPY)
  message(FATAL_ERROR "objcopy was not found (Debian: binutils)")
endif()
foreach(name cholmod suitesparseconfig)
  set(serial ${CMAKE_CURRENT_BINARY_DIR}/lib${name}_serial.a)
  execute_process(COMMAND ${CMAKE_OBJCOPY} --enable-deterministic-archives
                          --redefine-sym omp_get_max_threads=co_sparse_cholesky_most_threads
                          --redefine-sym omp_get_wtime=co_clock_seconds
                          ${CURVOPT_${name}} ${serial}.new
                  COMMAND_ERROR_IS_FATAL ANY)
  # Only if it differs: a new archive would have all programs linked anew.
  execute_process(COMMAND ${CMAKE_COMMAND} -E copy_if_different ${serial}.new ${serial}
                  COMMAND_ERROR_IS_FATAL ANY)
  list(TRANSFORM archives REPLACE "^${CURVOPT_${name}}$" ${serial})
endforeach()

target_link_libraries(curvopt_cholmod INTERFACE -Wl,--start-group ${archives} curvopt_own_blas -Wl,--end-group m)
# Debian has no static METIS. CHOLMOD only calls it for orderings that we do not ask for (sparse_cholesky.c asks for AMD).
target_link_options(curvopt_cholmod INTERFACE -Wl,--defsym=METIS_NodeND=0 -Wl,--defsym=METIS_ComputeVertexSeparator=0)
