// SPDX-License-Identifier: MIT
//
// A module of another phymul.
#include "solver/gl_module.h"

extern "C" const phymul::GlModule* phymul_gl_module() {
  static const phymul::GlModule module{.stamp = {.version = "99.1.2"}};
  return &module;
}
