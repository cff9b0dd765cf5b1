# SPDX-License-Identifier: MIT
#
# Tests that need GL.

# Loaded, not linked.
add_dependencies(phymul_test phymul_gl)
add_dependencies(phymul_stability_test phymul_gl)

# The inside of src/gl, apart from phymul_test, which runs on machines without GL.
file(GLOB gl_test_sources CONFIGURE_DEPENDS gl/*_test.cpp)
list(FILTER gl_test_sources EXCLUDE REGEX "gl_(glx|module)_test")
phymul_test_program(phymul_gl_test ${gl_test_sources} support/host_state.cpp)
target_compile_definitions(phymul_gl_test PRIVATE PHYMUL_GLSL_SOURCES="${PROJECT_SOURCE_DIR}/glsl")
target_link_libraries(phymul_gl_test PRIVATE phymul_gl_objects phymul_mirror)
add_dependencies(phymul_gl_test phymul_gl)  # displays come from the module
phymul_test_suites(phymul_gl_test)

# The door to the module, which must not open where it should not: each in a process of its own, because a module that
# has been found stays.
phymul_test_program(phymul_gl_module_test gl/gl_module_test.cpp)
target_link_libraries(phymul_gl_module_test PRIVATE phymul_inside)
add_dependencies(phymul_gl_module_test phymul_gl)
add_test(NAME gl.module COMMAND phymul_gl_module_test --gtest_filter=GlModule.* --gtest_brief=1)

# Modules that are none, and their reasons.
add_library(phymul_absent SHARED faulty_modules/absent.cpp)  # nowhere to be found, as GLEW is on a machine without GL
function(faulty_module name reason)
  add_library(phymul_${name} MODULE faulty_modules/${name}.cpp)
  target_link_libraries(phymul_${name} PRIVATE phymul_inside ${ARGN} phymul_warnings phymul_sanitizers)
  target_include_directories(phymul_${name} PRIVATE ${PROJECT_SOURCE_DIR}/src)
  set_target_properties(phymul_${name} PROPERTIES SKIP_BUILD_RPATH ON)
  add_dependencies(phymul_gl_module_test phymul_${name})
  faulty_module_test(${name} $<TARGET_FILE:phymul_${name}> "${reason}")
endfunction()
function(faulty_module_test name module reason)
  add_test(NAME gl.module_${name} COMMAND phymul_gl_module_test --gtest_filter=GlModuleFaulty.* --gtest_brief=1)
  set_tests_properties(gl.module_${name} PROPERTIES ENVIRONMENT "PHYMUL_GL_MODULE=${module};PHYMUL_TEST_REASON=${reason}")
endfunction()
faulty_module_test(nowhere /nonexistent/libphymul_gl.so
                   "/nonexistent/libphymul_gl.so: cannot open shared object file: No such file or directory")
faulty_module(needs_absent "libphymul_absent.so: cannot open shared object file" phymul_absent)
faulty_module(no_entry "is no GL module of phymul: it has no function phymul_gl_module")
faulty_module(other_version "belongs to phymul 99.1.2, this program to ${PROJECT_VERSION};")
faulty_module(other_flags "and was built with other headers or flags")

# What "auto" makes of a GPU.
add_library(phymul_instant_gpu MODULE gl/instant_gpu_module.cpp)
target_link_libraries(phymul_instant_gpu PRIVATE phymul_inside phymul_warnings phymul_sanitizers)
target_include_directories(phymul_instant_gpu PRIVATE ${PROJECT_SOURCE_DIR}/src ${CMAKE_CURRENT_SOURCE_DIR})
add_dependencies(phymul_gl_module_test phymul_instant_gpu)
add_test(NAME gl.auto COMMAND phymul_gl_module_test --gtest_filter=GlModuleInstant.* --gtest_brief=1)
set_tests_properties(gl.auto PROPERTIES ENVIRONMENT
                     "PHYMUL_GL_MODULE=$<TARGET_FILE:phymul_instant_gpu>;PHYMUL_TEST_INSTANT_GPU=1")

# The same on other GLs: what the tests of both programs are called that look at GL decides, so a new one is among them.
# Arguments behind the name: tests to leave out, and the environment.
function(gl_tests_under name without)
  set(backend_tests "*/gl:*/gl_compute*:*Gl*")  # the backend's instances of what every backend runs, and its own tests
  add_test(NAME gl.${name}.phymul_test COMMAND phymul_test "--gtest_filter=${backend_tests}-${without}" --gtest_brief=1)
  add_test(NAME gl.${name}.phymul_gl_test COMMAND phymul_gl_test "--gtest_filter=*-${without}" --gtest_brief=1)
  set_tests_properties(gl.${name}.phymul_test gl.${name}.phymul_gl_test PROPERTIES ENVIRONMENT "${ARGN}" TIMEOUT 1500 LABELS full)
endfunction()

# Compute shaders are asked for where a driver has them: not in OpenGL ES 3.0 nor on softpipe. Where the desktop GL is
# too old for them they run under OpenGL ES.
set(computing "*/gl_compute*:GlComputeDevice.*:GlContactMotion.*:GlComputeContacts.*:*HostsContextIsLeftAsItWasByComputing*")

# A minute each, of all bodies and variants: under desktop GL both backends show their bits, under the
# oldest of each dialect single steps of the fragment backend, and 2,000 damped ones under the oldest OpenGL ES.
# Compute shaders under OpenGL ES: a body of each kind (GlCompute*).
set(damped "*GlEquivalence.DampedBodies*:*AHundred*:*GlAveraged.BodiesGo*")
set(long "*GlEquivalence.SingleSteps*:${damped}")
set(long_in_33 "*GlEquivalence.SingleSteps*/gl_compute*:${damped}")

# The oldest desktop GL, the other dialect, and its oldest version. LP_NUM_THREADS=0: no threads of the renderer's own,
# which small bodies only wait for. (Where desktop GL is 3.3 compute shaders run under OpenGL ES, as in the next.)
set(gl_33 MESA_GL_VERSION_OVERRIDE=3.3 MESA_GLSL_VERSION_OVERRIDE=330 LP_NUM_THREADS=0)
set(compute_in_es "*GlTool*/gl_compute*:*GlVolume*/gl_compute*:*GlHostStep*/gl_compute*:*NeedleIn.*/gl_compute")
set(compute_in_es "${compute_in_es}:*Gl*Contact*/gl_compute:GlContactMotion.*:GlComputeContacts.*")
gl_tests_under(33 "${long_in_33}:${compute_in_es}" ${gl_33})
set(long_in_es "${long}:*GlVolume.Keeps*:*GlVolume.Batches*:*GlVolume.ManyFacets*")
set(long_in_es "${long_in_es}:*GlContactMotion*:*GlBodyContact.Momentum*")
set(long_needles "*NeedleIn.BendsUnder*/gl*:*NeedleIn.IsTheStiff*/gl*:*NeedleIn.GoesOn*/gl*")
gl_tests_under(es "${long_in_es}:${long_needles}" PHYMUL_GL_DIALECT=es LP_NUM_THREADS=0)
gl_tests_under(es30 "*AHundred*:${computing}" PHYMUL_GL_DIALECT=es MESA_GLES_VERSION_OVERRIDE=3.0 LP_NUM_THREADS=0)
# The oldest OpenGL ES that computes. It has no `precise`, so that a compiler may order sums as it likes: what every
# backend must do is asked of it, not the mirror's bits.
add_test(NAME gl.es31.phymul_test COMMAND phymul_test "--gtest_filter=*/gl_compute-${long_needles}" --gtest_brief=1)
set(es31 PHYMUL_GL_DIALECT=es MESA_GLES_VERSION_OVERRIDE=3.1 LP_NUM_THREADS=0)
set_tests_properties(gl.es31.phymul_test PROPERTIES ENVIRONMENT "${es31}" TIMEOUT 1500 LABELS full)
# A desktop GL that does not.
add_test(NAME gl.33.no_compute COMMAND phymul_gl_module_test --gtest_filter=GlModuleOld.* --gtest_brief=1)
set(old_gl MESA_GL_VERSION_OVERRIDE=3.3 MESA_GLSL_VERSION_OVERRIDE=330 PHYMUL_GL_DIALECT=desktop PHYMUL_TEST_OLD_GL=1)
set_tests_properties(gl.33.no_compute PROPERTIES ENVIRONMENT "${old_gl}")
# Another renderer, which interprets shaders: 200 steps of every model variant would take it minutes. Its arithmetic has
# not the bits of the float mirror, but is within the rounding bound. It does what takes it seconds: a cylinder pulled and
# let go takes it three minutes, tools that agree with the reference as on llvmpipe (GlTool.Agrees*) more than one.
set(minutes "*RestStaysAtRest*:*PulledCylinder*:*EnumeratedBasesMove*:*AHundred*:*GlAveraged.BodiesGo*")
set(long_with_tools "*GlTool.Every*:*GlTool.Agrees*:*GlTool.Batches*:*MovingTool.GoesBack*:*MovingTool.Holds*")
set(long_with_tools "${long_with_tools}:*GlHostStep*:*NeedleIn*:*NeedleOn*:*ToolSurfaceOn.F*:*ToolSurfaceOn.Takes*")
set(long_with_tools "${long_with_tools}:*Contact.Block*:*Contact.Compliance*:*Contact.TenThousand*:*GridTool*")
set(long_with_volumes "*GlVolume.IsKept*:*GlVolume.Several*:*GlVolume.Keeps*:*GlVolume.Batches*:*GlVolume.ManyFacets*")
set(with_contacts "*GlBodyContact.*:*GlContactRuns.*")
set(with_joints "*GlJoint.*Contacts*:*JointOfBodiesIn.GlueHolds*:*JointIn.AChain*:*JointIn.AStiff*")
set(refused "*RefusedScene.Sh*:*RefusedScene.W*")
gl_tests_under(softpipe "${refused}:${minutes}:${with_contacts}:${with_joints}:${long_with_tools}:${long_with_volumes}:${computing}" GALLIUM_DRIVER=softpipe)

# Mesa's GL over Vulkan, on its software renderer. There Mesa 22.3 compiles uniforms into shaders, and runs a stale one
# where a uniform keeps its value (docs/measurements/systems.md).
find_file(PHYMUL_LAVAPIPE lvp_icd.x86_64.json PATHS /usr/share/vulkan/icd.d NO_DEFAULT_PATH
          DOC "Description of Mesa's software Vulkan")
if(PHYMUL_LAVAPIPE)
  # It allocates on the host, and its timers tell a thousandth of the time.
  set(not_of_zink "*MovingTool.Posing*/gl*:*ProfileTest.TimesAddUp*/gl*")
  gl_tests_under(zink "*AHundred*:${not_of_zink}" ZINK_INLINE_UNIFORMS=0 LIBGL_ALWAYS_SOFTWARE=1 GALLIUM_DRIVER=zink
                 VK_ICD_FILENAMES=${PHYMUL_LAVAPIPE} LP_NUM_THREADS=0)
else()
  message(STATUS "phymul: nothing is tested on zink, because CMake did not find lavapipe; on Debian: apt-get install mesa-vulkan-drivers")
endif()

# A host that uses GLX, on an X server of its own.
find_package(X11 QUIET)
find_program(PHYMUL_XVFB Xvfb DOC "The X server of the tests that need one")
if(TARGET X11::X11 AND TARGET OpenGL::GLX)
  add_executable(phymul_glx_test gl/gl_glx_test.cpp support/host_state.cpp)
  target_include_directories(phymul_glx_test PRIVATE ${CMAKE_CURRENT_SOURCE_DIR})
  target_link_libraries(phymul_glx_test PRIVATE phymul_gl_objects OpenGL::GLX X11::X11 GTest::gtest_main
                                                phymul_warnings phymul_sanitizers)
  set(x_server "")
  if(PHYMUL_XVFB)
    set(x_server sh ${CMAKE_CURRENT_SOURCE_DIR}/support/on_x_server.sh ${PHYMUL_XVFB} 64x64x24)
  endif()
  add_test(NAME gl.glx_host
           COMMAND ${x_server} $<TARGET_FILE:phymul_glx_test> --gtest_brief=1 --gtest_filter=-GlGlxBelow33.*)
  add_test(NAME gl.glx_host_below_33
           COMMAND ${x_server} $<TARGET_FILE:phymul_glx_test> --gtest_brief=1 --gtest_filter=GlGlxBelow33.*)
  set(below_33 MESA_GL_VERSION_OVERRIDE=3.1COMPAT)
  if(PHYMUL_SANITIZE MATCHES address)
    # GLX unloads the driver with its display, and the driver's caches would then count as leaks.
    list(APPEND below_33 ASAN_OPTIONS=detect_leaks=0)
  endif()
  set_tests_properties(gl.glx_host_below_33 PROPERTIES ENVIRONMENT "${below_33}")
else()
  message(STATUS "phymul: beside GLX nothing is tested, because CMake did not find X11 and GLX; on Debian or Ubuntu: "
                 "apt-get install libx11-dev libgl-dev xvfb")
endif()

# What a machine without GL must be able to load needs no library of it; the check itself finds that the module does.
set(loadable $<TARGET_FILE:phymul_test>)
get_target_property(type phymul TYPE)
if(type STREQUAL "SHARED_LIBRARY")
  list(APPEND loadable $<TARGET_FILE:phymul>)
endif()
function(add_no_gl_check name)
  add_test(NAME check.${name} COMMAND ${CMAKE_COMMAND} -DREADELF=${CMAKE_READELF} ${ARGN}
                                      -P ${CMAKE_CURRENT_SOURCE_DIR}/checks/no_gl_needed.cmake)
endfunction()
add_no_gl_check(no_gl_needed "-DFILES=${loadable}")
add_no_gl_check(no_gl_needed.finds_faults -DFILES=$<TARGET_FILE:phymul_gl>)
set_tests_properties(check.no_gl_needed.finds_faults PROPERTIES WILL_FAIL ON)
# A copy of the core in the module stays its own.
add_no_gl_check(gl_module_shows_one_function -DFILES=$<TARGET_FILE:phymul_gl> -DONLY_SYMBOL=phymul_gl_module)
