// SPDX-License-Identifier: MIT
#pragma once

#include <mutex>
#include <string>

#include "context.h"
#include "gl_api.h"

namespace phymul::gl {

/// Errors of GL's debug output.
class DebugLog {
 public:
  DebugLog() = default;
  DebugLog(const DebugLog&) = delete;  // GL holds its address
  DebugLog& operator=(const DebugLog&) = delete;

  /// From now on the current context's errors come here, at the call that makes them. Nothing where the context has no
  /// debug output.
  void listen(const ContextInfo& info);

  void add(const std::string& message);
  /// Throws Error with the messages since the last call, if there were any.
  void throw_errors();

 private:
  std::mutex mutex_;  // a driver may report from a thread of its own
  std::string messages_;
  int count_ = 0;
};

/// GlContext::own: made through EGL without a window, current on the caller's thread for the time of a call.
class OwnContext : public Context {
 public:
  /// On the first display that gives one. What was current still is when this returns. Throws Error that lists what was
  /// tried, each with its reason.
  static std::shared_ptr<OwnContext> open(const GlOptions& options, GlBackend backend);

  ~OwnContext() override;
  void throw_debug_errors() override { log_.throw_errors(); }

 private:
  friend class OwnContextMaker;
  OwnContext() = default;
  void call(Task task, void* argument) override;
  bool is_current() const;
  void make_current();  ///< on this thread; throws Error

  EGLDisplay display_ = EGL_NO_DISPLAY;
  EGLContext context_ = EGL_NO_CONTEXT;
  EGLSurface surface_ = EGL_NO_SURFACE;  ///< a pbuffer of one pixel where EGL wants a surface
  EGLenum api_ = EGL_OPENGL_API;
  DebugLog log_;
};

}  // namespace phymul::gl
