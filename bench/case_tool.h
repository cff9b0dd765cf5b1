// SPDX-License-Identifier: MIT
//
// The tools that a case file presses into its body.
#pragma once

#include <phymul/tool.h>

#include <string>
#include <vector>

#include "reference_case.h"

namespace phymul::bench {

/// The words of a line: tool NAME SHAPE sizes x y z ux uy uz [ax ay az]. Throws Error that says what the shape needs.
ReferenceCase::PlacedTool read_tool(const std::vector<std::string>& words);

/// Frictionless, and without compliance: no particle is in it after a step, so that no stiffness of the contact is
/// measured. It is where its displacement has taken it. Throws Error.
Tool make_tool(const ReferenceCase::PlacedTool& it, const Variables& variables);

}  // namespace phymul::bench
