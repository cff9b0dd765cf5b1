// SPDX-License-Identifier: MIT
#include "loop_turns.h"

#include <phymul/error.h>

#include <string>

namespace phymul::gl {

void require_turns(const ContextInfo& info, LoopTurns turns) {
  const std::int64_t all = turns.own + turns.gathered;
  if (all <= info.loop_turns) return;
  throw Error(ErrorCode::not_supported, "expected at most " + std::to_string(info.loop_turns) +
                                            " turns of the loops of a shader, which is where " + info.renderer +
                                            " breaks off, got up to " + std::to_string(all) +
                                            " for a particle of this body; use fewer bases or another backend");
}

}  // namespace phymul::gl
