// SPDX-License-Identifier: MIT
#pragma once

#include "gl_api.h"

namespace phymul::gl {

/// What EGL has bound to this thread, to be bound again: context, display, both surfaces and the API. Costs some
/// microseconds.
class EglGuard {
 public:
  EglGuard();
  ~EglGuard();
  EglGuard(const EglGuard&) = delete;
  EglGuard& operator=(const EglGuard&) = delete;

  EGLContext context() const { return context_; }  ///< of the host; EGL_NO_CONTEXT: none

 private:
  EGLenum api_;
  EGLContext context_;
  EGLDisplay display_;
  EGLSurface draw_, read_;
};

}  // namespace phymul::gl
