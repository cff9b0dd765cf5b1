# SPDX-License-Identifier: MIT
#
# phymul_warnings: linked PRIVATE to our own targets, so that no flag reaches a project that uses phymul.
add_library(phymul_warnings INTERFACE)
target_compile_options(phymul_warnings INTERFACE -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wno-sign-conversion
                                                 $<$<BOOL:${PHYMUL_WARNINGS_AS_ERRORS}>:-Werror>)
# GCC 12 sees overlaps that are none in every short std::string assignment it inlines (GCC bug 105651).
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 13)
  target_compile_options(phymul_warnings INTERFACE -Wno-restrict)
endif()
# GCC 14 follows ranges into what it inlines of Eigen and the standard library, and reports strings and vectors of
# impossible lengths there. GCC 12 and clang watch over our own.
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CMAKE_CXX_COMPILER_VERSION VERSION_GREATER_EQUAL 13)
  target_compile_options(phymul_warnings INTERFACE -Wno-aggressive-loop-optimizations -Wno-array-bounds
                                                   -Wno-stringop-overflow)
endif()
