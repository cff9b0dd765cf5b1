// SPDX-License-Identifier: MIT
//
// Pointers to GL functions, and what the current context can do.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace phymul::gl {

/// Loads GL functions through GLEW, once in a process; needs a current context. Afterwards every function that phymul
/// calls is there, as far as the driver has it. A pointer that is not null says nothing about the context: ask for its
/// version and its extensions. Throws Error.
void load_functions();

/// Extensions of the current context, sorted.
std::vector<std::string> gl_extensions();
bool contains(const std::vector<std::string>& sorted, std::string_view name);

/// "EGL_BAD_MATCH (0x3009)".
std::string egl_error_name(int error);

}  // namespace phymul::gl
