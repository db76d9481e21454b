# SPDX-License-Identifier: GPL-3.0-or-later
# Sources with vectors are compiled once for each instruction set; which one runs is chosen when the library is used
# (src/base/instruction_set.h).
option(CURVOPT_PORTABLE "Compile for the processor's least instruction set alone" OFF)
set(CURVOPT_INSTRUCTION_SETS portable)
set(CURVOPT_LANES_portable 2)
if(CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64" AND NOT CURVOPT_PORTABLE)
  list(APPEND CURVOPT_INSTRUCTION_SETS avx2 avx512)
  set(CURVOPT_LANES_avx2 4)
  set(CURVOPT_FLAGS_avx2 -mavx2)
  set(CURVOPT_LANES_avx512 8)
  # GCC 12 fuses a*b+c beside d*e-f where it makes vectors of scalars, whatever -ffp-contract says.
  set(CURVOPT_FLAGS_avx512 -mavx512f -mavx512dq -mavx512vl -mprefer-vector-width=512 -fno-tree-slp-vectorize)
endif()

# Objects of a source for each instruction set, into a target. No fast-math: only errno is given up. Further flags follow.
function(curvopt_add_vectors target source)
  get_filename_component(name ${source} NAME_WE)
  foreach(set IN LISTS CURVOPT_INSTRUCTION_SETS)
    set(objects curvopt_${name}_${set})
    add_library(${objects} OBJECT ${source})
    target_include_directories(${objects} PRIVATE ${PROJECT_SOURCE_DIR}/libcurvopt/include ${PROJECT_SOURCE_DIR}/libcurvopt/src)
    target_compile_definitions(${objects} PRIVATE CO_LANES=${CURVOPT_LANES_${set}} CO_INSTRUCTION_SET=${set})
    target_compile_options(${objects} PRIVATE -O3 -fno-math-errno -Wno-psabi ${CURVOPT_FLAGS_${set}} ${ARGN})
    if(CURVOPT_SANITIZE) # marks of scopes keep local arrays out of registers; bad pointers are the address sanitizer's to see
      target_compile_options(${objects} PRIVATE -fno-sanitize-address-use-after-scope
                             -fno-sanitize=null,object-size,alignment,pointer-overflow -Wno-maybe-uninitialized)
    endif()
    if(CURVOPT_FUZZ) # hardly any branches, and clang takes minutes to count them
      target_compile_options(${objects} PRIVATE -fno-sanitize-coverage=inline-8bit-counters,pc-table)
      if(CURVOPT_SANITIZE) # two thirds of the time would be theirs; the preset asan looks at them
        target_compile_options(${objects} PRIVATE -fno-sanitize=address,undefined)
      endif()
    endif()
    target_sources(${target} PUBLIC $<TARGET_OBJECTS:${objects}>)
  endforeach()
  if(avx2 IN_LIST CURVOPT_INSTRUCTION_SETS)
    target_compile_definitions(${target} PRIVATE CO_HAVE_AVX)
  endif()
endfunction()
