# SPDX-License-Identifier: MIT
#
# Tests that need GL.

add_dependencies(phymul_test phymul_gl)  # loaded, not linked

# The inside of src/gl, apart from phymul_test, which runs on machines without GL.
add_executable(phymul_gl_test
  gl_context_test.cpp
  gl_hosts_test.cpp
  host_state.cpp)
target_include_directories(phymul_gl_test PRIVATE ${CMAKE_CURRENT_SOURCE_DIR})
target_link_libraries(phymul_gl_test PRIVATE phymul_gl_objects GTest::gtest_main phymul_warnings phymul_sanitizers)
gtest_discover_tests(phymul_gl_test DISCOVERY_TIMEOUT 60)

# The same on other GLs: what the tests of both programs are called that look at GL decides, so a new one is among them.
function(gl_tests_under name)
  foreach(program IN ITEMS phymul_test phymul_gl_test)
    set(filter "*")
    if(program STREQUAL "phymul_test")
      set(filter "*/gl:*Gl*")  # the backend's instances of what every backend runs, and its own tests
    endif()
    add_test(NAME gl.${name}.${program} COMMAND ${program} --gtest_filter=${filter} --gtest_brief=1)
    set_tests_properties(gl.${name}.${program} PROPERTIES ENVIRONMENT "${ARGN}" TIMEOUT 1500)
  endforeach()
endfunction()

# The oldest desktop GL, another renderer, the other dialect, and its oldest version. LP_NUM_THREADS=0: no threads of
# the renderer's own, which small bodies only wait for.
gl_tests_under(33 MESA_GL_VERSION_OVERRIDE=3.3 MESA_GLSL_VERSION_OVERRIDE=330 LP_NUM_THREADS=0)
gl_tests_under(softpipe GALLIUM_DRIVER=softpipe)
gl_tests_under(es PHYMUL_GL_DIALECT=es LP_NUM_THREADS=0)
gl_tests_under(es30 PHYMUL_GL_DIALECT=es MESA_GLES_VERSION_OVERRIDE=3.0 LP_NUM_THREADS=0)

# A host that uses GLX, on an X server of its own.
find_package(X11 QUIET)
find_program(PHYMUL_XVFB_RUN xvfb-run DOC "Runs the tests that need an X server")
if(TARGET X11::X11 AND TARGET OpenGL::GLX)
  add_executable(phymul_glx_test gl_glx_test.cpp host_state.cpp)
  target_include_directories(phymul_glx_test PRIVATE ${CMAKE_CURRENT_SOURCE_DIR})
  target_link_libraries(phymul_glx_test PRIVATE phymul_gl_objects OpenGL::GLX X11::X11 GTest::gtest_main
                                                phymul_warnings phymul_sanitizers)
  set(x_server "")
  if(PHYMUL_XVFB_RUN)
    set(x_server ${PHYMUL_XVFB_RUN} --auto-servernum "--server-args=-screen 0 64x64x24")
  endif()
  add_test(NAME gl.glx_host
           COMMAND ${x_server} $<TARGET_FILE:phymul_glx_test> --gtest_brief=1 --gtest_filter=-GlGlxBelow33.*)
  add_test(NAME gl.glx_host_below_33
           COMMAND ${x_server} $<TARGET_FILE:phymul_glx_test> --gtest_brief=1 --gtest_filter=GlGlxBelow33.*)
  set_tests_properties(gl.glx_host_below_33 PROPERTIES ENVIRONMENT MESA_GL_VERSION_OVERRIDE=3.1COMPAT)
else()
  message(STATUS "phymul: beside GLX nothing is tested, because CMake did not find X11 and GLX; on Debian or Ubuntu: "
                 "apt-get install libx11-dev libgl-dev xvfb xauth")
endif()
