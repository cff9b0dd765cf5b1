# SPDX-License-Identifier: MIT
#
# phymul_sanitizers: linked PRIVATE to our own targets; empty unless PHYMUL_SANITIZE says otherwise. See docs/guide/testing.md.
add_library(phymul_sanitizers INTERFACE)
if(PHYMUL_SANITIZE)
  if(PHYMUL_SANITIZE MATCHES "thread" AND PHYMUL_SANITIZE MATCHES "address")
    message(FATAL_ERROR "PHYMUL_SANITIZE=${PHYMUL_SANITIZE}: address and thread cannot be in one build")
  endif()
  # -O1: Eigen's layers of small functions are unbearably slow with instrumentation and without inlining. -g1: lines for
  # the stack traces of a finding, without the variables, which are most of the build's time and size.
  target_compile_options(phymul_sanitizers INTERFACE -fsanitize=${PHYMUL_SANITIZE} -fno-sanitize-recover=all
                                                     -fno-omit-frame-pointer -g1 -O1)
  if(PHYMUL_SANITIZE MATCHES "undefined")
    # Checked at every access through Eigen, these are two thirds of the program. Of them the address sanitizer sees
    # null pointers and accesses beyond an object; a wrong alignment ends a vector kernel by itself.
    target_compile_options(phymul_sanitizers INTERFACE -fno-sanitize=null,object-size,vptr,alignment)
  endif()
  if(PHYMUL_FUZZ)
    if(NOT CMAKE_CXX_COMPILER_ID MATCHES "Clang")
      message(FATAL_ERROR "PHYMUL_FUZZ needs clang, got ${CMAKE_CXX_COMPILER_ID}; use the preset fuzz")
    endif()
    target_compile_options(phymul_sanitizers INTERFACE -fsanitize=fuzzer-no-link)  # which branches are taken
  endif()
  target_compile_definitions(phymul_sanitizers INTERFACE _GLIBCXX_ASSERTIONS)
  target_link_options(phymul_sanitizers INTERFACE -fsanitize=${PHYMUL_SANITIZE})
endif()
