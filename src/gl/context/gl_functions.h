// SPDX-License-Identifier: MIT
//
// Pointers to GL functions.
#pragma once

#include <string>

namespace phymul::gl {

/// Loads GL functions through GLEW, once in a process; needs a current context. Afterwards every function that phymul
/// calls is there, as far as the driver has it. A pointer that is not null says nothing about the context: ask for its
/// version and its extensions. Throws Error.
void load_functions();

/// "EGL_BAD_MATCH (0x3009)".
std::string egl_error_name(int error);

}  // namespace phymul::gl
