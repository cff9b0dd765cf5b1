// SPDX-License-Identifier: MIT
#include "context_own.h"

#include "guard_egl.h"

namespace phymul::gl {

OwnContext::OwnContext(const GlOptions& options, GlBackend backend) : egl_(EglContext::open(options, backend)) {
  info_ = egl_->info();
}

void OwnContext::call(Task task, void* argument) {
  if (egl_->is_current()) return task(argument);
  const EglGuard guard;
  try {
    egl_->make_current();
  } catch (...) {
    lost_ = lost_ || egl_->lost();
    throw;
  }
  task(argument);
}

}  // namespace phymul::gl
