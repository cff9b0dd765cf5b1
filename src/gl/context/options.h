// SPDX-License-Identifier: MIT
#pragma once

#include <phymul/gl.h>

namespace phymul::gl {

/// What is left at its default is taken from PHYMUL_GL_PASSES and PHYMUL_GLSL. Throws Error for values that are none.
GlOptions with_environment(GlOptions options);

}  // namespace phymul::gl
