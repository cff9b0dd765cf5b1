// SPDX-License-Identifier: MIT
#pragma once

#include "context.h"

namespace phymul::gl {

/// GlContext::current: the context that is current when this is made, EGL's or GLX's, and must be at every call.
class CurrentContext : public Context {
 public:
  explicit CurrentContext(GlBackend backend);

 private:
  void call(Task task, void* argument) override;

  void* handle_ = nullptr;  ///< which context
  bool inside_ = false;     ///< a call is running
};

}  // namespace phymul::gl
