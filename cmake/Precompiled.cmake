# SPDX-License-Identifier: MIT
#
# Precompiled headers: nearly every file pays a second for Eigen without them. They save time and nothing else: every
# file still includes what it uses (-DCMAKE_DISABLE_PRECOMPILE_HEADERS=ON shows it), and users of the library get none.

# For parts of the library: what changes with no work on phymul.
function(phymul_precompile_library target)
  target_precompile_headers(${target} PRIVATE <Eigen/Core> <Eigen/Geometry> <algorithm> <array> <cmath> <cstdint>
                            <functional> <limits> <map> <memory> <optional> <span> <string> <string_view> <vector>)
endfunction()

# For programs that use the library. All of one kind ("program", "test") share one file, which is made with the flags of
# the first: they must be compiled alike.
function(phymul_precompile_users kind target)
  if(NOT TARGET phymul_${kind}_headers)
    file(WRITE ${PROJECT_BINARY_DIR}/headers/${kind}.cpp "// Carries the precompiled headers of one kind of program.\n")
    add_library(phymul_${kind}_headers OBJECT ${PROJECT_BINARY_DIR}/headers/${kind}.cpp)
    target_link_libraries(phymul_${kind}_headers PRIVATE phymul phymul_warnings phymul_sanitizers)
    set(headers <phymul/phymul.h>)
    if(kind STREQUAL "test")
      list(PREPEND headers <gtest/gtest.h>)
      target_link_libraries(phymul_${kind}_headers PRIVATE GTest::gtest)
      phymul_optimise_test(phymul_${kind}_headers)
    endif()
    target_precompile_headers(phymul_${kind}_headers PRIVATE ${headers})
  endif()
  target_precompile_headers(${target} REUSE_FROM phymul_${kind}_headers)
endfunction()

# Tests are compiled once and run once: less optimised they build in half the time, and the library they call is fast.
function(phymul_optimise_test target)
  if(CMAKE_BUILD_TYPE STREQUAL "Release")
    target_compile_options(${target} PRIVATE -O1)
  endif()
endfunction()
