// SPDX-License-Identifier: MIT
#include "context.h"

namespace phymul::gl {

bool Context::lost() noexcept {
  if (lost_) return true;
  try {
    lost_ = run([this] { return was_reset(info_); });
  } catch (...) {  // a context that cannot be made current is not therefore lost; call() has noted it if it is
  }
  return lost_;
}

}  // namespace phymul::gl
