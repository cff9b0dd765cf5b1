// SPDX-License-Identifier: MIT
//
// The one place that includes GL and EGL headers. GLEW is the loader; see gl_functions.h for what it does not load.
#pragma once

#include <string>

#ifdef __EMSCRIPTEN__
#include "gl/web/web_api.h"
#else
#include <GL/glew.h>

// Without it the EGL headers bring Xlib's macros (None, Status, Bool) along.
#define EGL_NO_X11
#include <EGL/egl.h>
#include <EGL/eglext.h>

namespace phymul::gl {
inline constexpr GLenum renderer_name = GL_RENDERER;
inline constexpr bool in_browser = false;
}  // namespace phymul::gl
#endif

namespace phymul::gl {

/// glGetIntegerv of what is one number, in the current context.
inline GLint integer_of(GLenum name) {
  GLint value = 0;
  glGetIntegerv(name, &value);
  return value;
}

/// glGetString; empty where the context gives none, as a lost one.
inline std::string gl_text(GLenum name) {
  const GLubyte* const text = glGetString(name);
  return text ? reinterpret_cast<const char*>(text) : "";
}

/// What was wrong before must not be taken for the answer to what comes next. A lost context may never stop reporting
/// errors.
inline void forget_errors() {
  for (int k = 0; k < 16 && glGetError() != GL_NO_ERROR; ++k) {
  }
}

/// Of glGetError after an allocation.
inline std::string memory_error(GLenum error) {
  return error == GL_OUT_OF_MEMORY ? "out of memory" : "GL error " + std::to_string(error);
}

}  // namespace phymul::gl
