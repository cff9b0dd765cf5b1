// SPDX-License-Identifier: MIT
//
// The one place that includes GL and EGL headers. GLEW is the loader; see gl_functions.h for what it does not load.
#pragma once

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

}  // namespace phymul::gl
