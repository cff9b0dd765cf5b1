// SPDX-License-Identifier: MIT
//
// Runs the tests of a WebAssembly program: Emscripten 3.1.6 calls "main", and Clang 16 gives main() another name.
#include <gtest/gtest.h>

extern "C" {
int run_tests(int argc, char** argv) __asm__("main");

/// Of Mesa's driver (tests/support/gl_fixture.h). Emscripten's own ends the program.
void* dlopen(const char*, int) {
  return nullptr;
}
}

int run_tests(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  return RUN_ALL_TESTS();
}
