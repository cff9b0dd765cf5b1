// SPDX-License-Identifier: MIT
#include "guard_egl.h"

namespace phymul::gl {

EglGuard::EglGuard() : api_(eglQueryAPI()) {
  // The current context is asked for per API; OpenGL and OpenGL ES share one answer, OpenVG has another.
  eglBindAPI(EGL_OPENGL_ES_API);
  context_ = eglGetCurrentContext();
  display_ = eglGetCurrentDisplay();
  draw_ = eglGetCurrentSurface(EGL_DRAW);
  read_ = eglGetCurrentSurface(EGL_READ);
}

EglGuard::~EglGuard() {
  eglBindAPI(EGL_OPENGL_ES_API);
  if (eglGetCurrentContext() != context_) {
    if (context_ != EGL_NO_CONTEXT) {
      eglMakeCurrent(display_, draw_, read_, context_);
    } else {
      eglMakeCurrent(eglGetCurrentDisplay(), EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    }
  }
  eglBindAPI(api_);
}

}  // namespace phymul::gl
