// SPDX-License-Identifier: MIT
//
// A module whose library is missing where it is loaded.
int phymul_absent();

extern "C" const void* phymul_gl_module() {
  static const int number = phymul_absent();
  return &number;
}
