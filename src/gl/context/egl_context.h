// SPDX-License-Identifier: MIT
//
// A context of one's own, made through EGL without a window.
#pragma once

#include <phymul/gl.h>

#include <memory>
#include <string>

#include "context_debug.h"
#include "context_info.h"
#include "gl_api.h"

namespace phymul::gl {

class EglContext {
 public:
  /// A context that has passed its self-test, on the first display that gives one. It is current on no thread when this
  /// returns, and what was current still is. Throws Error that lists what was tried, each with its reason.
  static std::unique_ptr<EglContext> open(const GlOptions& options, GlBackend backend);

  ~EglContext();
  EglContext(const EglContext&) = delete;
  EglContext& operator=(const EglContext&) = delete;

  void make_current();                 ///< on this thread; throws Error
  bool is_current() const;             ///< on this thread
  bool lost() const { return lost_; }  ///< EGL said so when it was to be made current
  const ContextInfo& info() const { return info_; }
  DebugLog& debug_log() { return log_; }

 private:
  friend class EglContextMaker;
  EglContext() = default;

  EGLDisplay display_ = EGL_NO_DISPLAY;
  EGLContext context_ = EGL_NO_CONTEXT;
  EGLSurface surface_ = EGL_NO_SURFACE;  ///< a pbuffer of one pixel where EGL wants a surface
  EGLenum api_ = EGL_OPENGL_API;
  bool lost_ = false;
  ContextInfo info_;
  DebugLog log_;
};

}  // namespace phymul::gl
