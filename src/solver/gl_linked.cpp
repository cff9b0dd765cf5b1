// SPDX-License-Identifier: MIT
//
// The GL part where it is no module but linked: in a browser's page.
#include "gl_module.h"

extern "C" const phymul::GlModule* phymul_gl_module();

namespace phymul {

const GlModule& load_gl_module() {
  return *phymul_gl_module();
}

}  // namespace phymul
