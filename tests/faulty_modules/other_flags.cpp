// SPDX-License-Identifier: MIT
//
// A module of this version that was built with flags which change the size of a struct.
#include "solver/gl_module.h"

extern "C" const phymul::GlModule* phymul_gl_module() {
  static const phymul::GlModule module = [] {
    phymul::GlModule other;
    other.stamp.sizes[2] += 8;
    return other;
  }();
  return &module;
}
