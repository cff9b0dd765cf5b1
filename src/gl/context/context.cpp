// SPDX-License-Identifier: MIT
#include "context.h"

#include <phymul/error.h>

#include "context_current.h"
#include "context_own.h"
#include "context_worker.h"

namespace phymul::gl {

std::shared_ptr<Context> Context::open(const GlOptions& options, GlBackend backend) {
  switch (options.context) {
    case GlContext::own:
    case GlContext::shared:
      return std::make_shared<OwnContext>(options, backend);
    case GlContext::worker:
      return std::make_shared<WorkerContext>(options, backend);
    case GlContext::current:
      return std::make_shared<CurrentContext>(backend);
  }
  throw Error("GlOptions::context: expected own, shared, worker or current, got " +
              std::to_string(static_cast<int>(options.context)));
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
