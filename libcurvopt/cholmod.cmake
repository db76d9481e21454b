# SPDX-License-Identifier: GPL-3.0-or-later
# Target curvopt_cholmod carries CHOLMOD, its BLAS and what these need; link it last.
#
# With CURVOPT_BUNDLE_CHOLMOD they are static archives inside our own library: an add-on cannot ask its users for them.
# Without, they are shared libraries of the system: what a distribution's package wants.
add_library(curvopt_cholmod INTERFACE)

if(NOT CURVOPT_BUNDLE_CHOLMOD)
  find_path(CURVOPT_CHOLMOD_INCLUDE suitesparse/cholmod.h REQUIRED)
  find_library(CURVOPT_CHOLMOD_SHARED cholmod REQUIRED)
  find_package(BLAS REQUIRED)
  target_include_directories(curvopt_objects PRIVATE ${CURVOPT_CHOLMOD_INCLUDE})
  target_link_libraries(curvopt_cholmod INTERFACE ${CURVOPT_CHOLMOD_SHARED} ${BLAS_LIBRARIES} m)
  return()
endif()

function(curvopt_find_archive result name)
  find_library(CURVOPT_${name} NAMES lib${name}.a PATH_SUFFIXES ${ARGN})
  if(NOT CURVOPT_${name})
    message(FATAL_ERROR "lib${name}.a was not found (Debian: libsuitesparse-dev, libopenblas-serial-dev); "
                        "with CURVOPT_BUNDLE_CHOLMOD=OFF shared libraries are used")
  endif()
  set(${result} ${CURVOPT_${name}} PARENT_SCOPE)
endfunction()

set(archives)
if(CURVOPT_OWN_BLAS) # archives of libcurvopt/toolchains/archives.sh: without OpenMP, Fortran and METIS
  foreach(name cholmod amd colamd suitesparseconfig)
    curvopt_find_archive(path ${name})
    list(APPEND archives ${path})
  endforeach()
  find_path(CURVOPT_CHOLMOD_INCLUDE suitesparse/cholmod.h REQUIRED)
  target_include_directories(curvopt_objects PRIVATE ${CURVOPT_CHOLMOD_INCLUDE})
  add_library(curvopt_own_blas STATIC src/linalg/own_blas.c)
  target_include_directories(curvopt_own_blas PRIVATE include src)
  target_compile_options(curvopt_own_blas PRIVATE -O3 -ffp-contract=fast -Wno-psabi)
  if(CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64")
    target_compile_definitions(curvopt_own_blas PRIVATE CO_HAVE_X86_KERNELS)
  endif()
  if(APPLE) # whose linker goes round by itself
    target_link_libraries(curvopt_cholmod INTERFACE ${archives} curvopt_own_blas m)
  else()
    target_link_libraries(curvopt_cholmod INTERFACE -Wl,--start-group ${archives} curvopt_own_blas -Wl,--end-group m)
  endif()
  return()
endif()
foreach(name cholmod amd camd colamd ccolamd suitesparseconfig)
  curvopt_find_archive(path ${name})
  list(APPEND archives ${path})
endforeach()
# The serial BLAS: small dense blocks do not pay for threads, and the threaded ones need a newer C library to load.
curvopt_find_archive(blas openblas openblas-serial)

# CHOLMOD's parallel loops are answered by sparse_cholesky.c, which gives them to one thread: copies of the archives call
# its functions where the originals call GCC's run time of threads, libgomp, which therefore is not needed. Archives
# without parallel loops have none of these names; those of a function that is missing here do not link.
if(NOT CMAKE_OBJCOPY)
  message(FATAL_ERROR "objcopy was not found (Debian: binutils)")
endif()
foreach(name cholmod suitesparseconfig)
  set(serial ${CMAKE_CURRENT_BINARY_DIR}/lib${name}_serial.a)
  execute_process(COMMAND ${CMAKE_OBJCOPY}
                          --redefine-sym GOMP_parallel=co_sparse_cholesky_parallel
                          --redefine-sym omp_get_num_threads=co_sparse_cholesky_n_threads
                          --redefine-sym omp_get_max_threads=co_sparse_cholesky_most_threads
                          --redefine-sym omp_get_thread_num=co_sparse_cholesky_thread
                          --redefine-sym omp_get_wtime=co_clock_seconds
                          ${CURVOPT_${name}} ${serial} COMMAND_ERROR_IS_FATAL ANY)
  list(TRANSFORM archives REPLACE "^${CURVOPT_${name}}$" ${serial})
endforeach()

# OpenBLAS has LAPACK in it, and that Fortran's run time. It lies in a folder of GCC's; clang knows that folder, too.
foreach(name gfortran quadmath)
  find_library(CURVOPT_${name} NAMES lib${name}.a)
  if(NOT CURVOPT_${name})
    execute_process(COMMAND ${CMAKE_C_COMPILER} -print-file-name=lib${name}.a OUTPUT_VARIABLE path
                    OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
    if(IS_ABSOLUTE "${path}")
      set(CURVOPT_${name} ${path} CACHE FILEPATH "" FORCE)
    elseif(name STREQUAL "gfortran") # quadmath is not on every processor
      message(FATAL_ERROR "libgfortran.a was not found by ${CMAKE_C_COMPILER} (Debian: gfortran); "
                          "set CURVOPT_gfortran")
    endif()
  endif()
  if(CURVOPT_${name})
    list(APPEND fortran ${CURVOPT_${name}})
  endif()
endforeach()

target_link_libraries(curvopt_cholmod INTERFACE -Wl,--start-group ${archives} -Wl,--end-group ${blas} ${fortran} m)
# Debian has no static METIS. CHOLMOD only calls it for orderings that we do not ask for (sparse_cholesky.c asks for AMD).
target_link_options(curvopt_cholmod INTERFACE -Wl,--defsym=METIS_NodeND=0 -Wl,--defsym=METIS_ComputeVertexSeparator=0)
