// SPDX-License-Identifier: MIT
#pragma once

#include "context.h"
#include "egl_context.h"

namespace phymul::gl {

/// GlContext::own and shared: current on the caller's thread, for the time of a call.
class OwnContext : public Context {
 public:
  OwnContext(const GlOptions& options, GlBackend backend);
  void throw_debug_errors() override { egl_->debug_log().throw_errors(); }

 private:
  void call(Task task, void* argument) override;

  std::unique_ptr<EglContext> egl_;
};

}  // namespace phymul::gl
