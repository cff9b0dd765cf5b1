// SPDX-License-Identifier: MIT
#pragma once

#include <phymul/gl.h>

#include "float_tables.h"

namespace phymul::gl {

/// What is left at its default is taken from PHYMUL_GL_PASSES and PHYMUL_GLSL. Throws Error for values that are none.
GlOptions with_environment(GlOptions options);

/// Enumerated where it is allowed, and asked for or smaller. Throws Error where it is asked for and not allowed.
FloatLayout choose_layout(BaseLayout wish, const TopologyTextures& topology);

}  // namespace phymul::gl
