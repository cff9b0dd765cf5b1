// SPDX-License-Identifier: MIT
#include "context.h"

#include "context_current.h"
#include "context_own.h"

namespace phymul::gl {

std::shared_ptr<Context> Context::open(const GlOptions& options, GlBackend backend) {
  if (options.context == GlContext::current) return std::make_shared<CurrentContext>(backend);
  return OwnContext::open(options, backend);
}

bool Context::lost() noexcept {
  if (lost_) return true;
  try {
    lost_ = run([this] { return was_reset(info_); });
  } catch (...) {  // a context that cannot be made current is not therefore lost; call() has noted it if it is
  }
  return lost_;
}

}  // namespace phymul::gl
