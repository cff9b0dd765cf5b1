# SPDX-License-Identifier: MIT
#
# What of the tests runs for WebAssembly. The whole of phymul_test would take an hour to build.

# In node: whether results are those of other systems.
phymul_test_program(phymul_trajectories solver/trajectories_test.cpp browser/main.cpp)
target_include_directories(phymul_trajectories PRIVATE ${PROJECT_SOURCE_DIR}/src ${PROJECT_SOURCE_DIR}/glsl)
target_link_libraries(phymul_trajectories PRIVATE phymul)
target_link_options(phymul_trajectories PRIVATE -O1)  # without wasm-opt, which takes a minute
add_test(NAME wasm.trajectories COMMAND phymul_trajectories)
# Node may end with 0 without having run a test.
set_tests_properties(wasm.trajectories PROPERTIES PASS_REGULAR_EXPRESSION "\\[  PASSED  \\] [1-9][0-9]* test"
                                                  FAIL_REGULAR_EXPRESSION "\\[  FAILED  \\]")

# In a browser: the suites of `gl` that need no EGL, no threads and no files.
set(suites equivalence fragment dissipation volume tool host_step)
list(TRANSFORM suites REPLACE "(.+)" "gl/gl_\\1_test.cpp")
phymul_test_program(phymul_browser_gl_test ${suites} browser/main.cpp)
target_link_libraries(phymul_browser_gl_test PRIVATE phymul_mirror)
target_link_options(phymul_browser_gl_test PRIVATE -O1 -sMODULARIZE=1 -sEXPORT_NAME=createTests -sENVIRONMENT=web
                                                   -sEXPORTED_RUNTIME_METHODS=ENV)
find_program(PHYMUL_CHROMIUM NAMES chromium chromium-browser google-chrome DOC "The browser of tests")
# Left out, with the reasons in docs/guide/browser.md: what waits for a copy in a loop or needs threads, compute shaders or
# names of framebuffers that a host may not know there; and comparisons with the mirror that only its bits pass.
set(not_there "*CopiesAndLostDevices*:*FourSolversInFourThreads*:*PaddingOfEveryTarget*")
set(not_there "${not_there}:*TellsOfItsStepsWhatTheMirrorTells*:*LoadsOfAllKindsHaveTheMirrorsBits*")
set(not_there "${not_there}:*EveryShapeHasTheMirrorsBits*")
add_test(NAME wasm.gl
         COMMAND ${CMAKE_CROSSCOMPILING_EMULATOR} ${CMAKE_CURRENT_SOURCE_DIR}/browser/gl_test.mjs ${PHYMUL_CHROMIUM}
                 ${CMAKE_CURRENT_BINARY_DIR} "--gtest_filter=*/gl:GlFragment*-${not_there}")
set_tests_properties(wasm.gl PROPERTIES TIMEOUT 3000)
