# SPDX-License-Identifier: MIT
#
# The vector kernels of src/cpu/simd, compiled once per instruction set and chosen at run time. Their text says where
# a * b + c becomes one rounding (src/cpu/simd/pack.h): the compiler must not.
set(kernel_options -ffp-contract=off -fno-math-errno -fno-trapping-math)
if(PHYMUL_SANITIZE)
  # Checks of every pointer in unrolled code take the compiler many minutes; the address sanitizer's stay.
  list(APPEND kernel_options -fno-sanitize=undefined)
  # Guards around local variables take GCC thirteen times as long: 170 s instead of 13 s for AVX-512. What is lost are
  # overruns of a kernel's local variables, which are packs with fixed indices; the heap and globals stay checked.
  if(PHYMUL_SANITIZE MATCHES "address" AND CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    list(APPEND kernel_options --param=asan-stack=0)
  endif()
else()
  # Where a kernel of thousands of instructions begins within a line of 64 bytes decides by up to a third how fast a
  # processor decodes it (measured: attractors of six neighbours, Zen 5); without this, other code of a program decides.
  list(APPEND kernel_options -O3 -falign-functions=64)
endif()
# GCC 12 takes the "undefined" operands of its own intrinsics for uninitialised variables.
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  list(APPEND kernel_options -Wno-maybe-uninitialized -Wno-uninitialized)
endif()
# GCC does not align the stack of Windows for vectors of 32 and 64 bytes (GCC bug 54412) but moves them as if it had.
if(MINGW)
  list(APPEND kernel_options -Wa,-muse-unaligned-vector-move)
endif()
# Marks the kernels of one instruction set, which need these options besides.
function(phymul_kernels name)
  set(sources src/cpu/simd/kernels_${name}.cpp)
  target_sources(phymul PRIVATE ${sources})
  set_source_files_properties(${sources} PROPERTIES COMPILE_OPTIONS "${kernel_options};${ARGN}"
                              COMPILE_DEFINITIONS PHYMUL_KERNELS_OF_ONE_INSTRUCTION_SET
                              SKIP_PRECOMPILE_HEADERS ON)  # whose flags are others
endfunction()

foreach(set IN LISTS PHYMUL_X86_KERNELS)
  if(NOT set MATCHES "^avx(2|512)$")
    message(FATAL_ERROR "PHYMUL_X86_KERNELS: expected a list of avx2 and avx512, got \"${set}\"")
  endif()
endforeach()
phymul_kernels(portable)
if(CMAKE_SYSTEM_PROCESSOR MATCHES "^(x86_64|AMD64|amd64)$")
  set(options_avx2 -mavx2 -mfma)
  set(options_avx512 ${options_avx2} -mavx512f -mavx512dq -mavx512vl -mavx512bw)
  foreach(set IN LISTS PHYMUL_X86_KERNELS)
    phymul_kernels(${set} ${options_${set}})
    string(TOUPPER ${set} name)
    target_compile_definitions(phymul PRIVATE PHYMUL_${name}_KERNELS)
  endforeach()
elseif(CMAKE_SYSTEM_PROCESSOR MATCHES "^(aarch64|arm64|ARM64)$")
  phymul_kernels(neon)
  target_compile_definitions(phymul PRIVATE PHYMUL_NEON_KERNELS)
endif()
