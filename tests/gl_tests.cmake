# SPDX-License-Identifier: MIT
#
# Tests that need GL.

add_dependencies(phymul_test phymul_gl)  # loaded, not linked

# The inside of src/gl, apart from phymul_test, which runs on machines without GL.
add_executable(phymul_gl_test
  gl_context_test.cpp
  gl_display_test.cpp)
target_include_directories(phymul_gl_test PRIVATE ${CMAKE_CURRENT_SOURCE_DIR})
target_link_libraries(phymul_gl_test PRIVATE phymul_gl_objects GTest::gtest_main phymul_warnings phymul_sanitizers)
gtest_discover_tests(phymul_gl_test DISCOVERY_TIMEOUT 60)
