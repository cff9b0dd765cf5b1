// SPDX-License-Identifier: MIT
//
// Renderers that end a shader's loops before they are done, without a word.
#pragma once

#include "device/float_tables.h"
#include "gl/context/context_info.h"

namespace phymul::gl {

/// Throws Error where a particle would take more turns than ContextInfo::loop_turns: forces would be missing.
void require_turns(const ContextInfo& info, LoopTurns turns);

}  // namespace phymul::gl
