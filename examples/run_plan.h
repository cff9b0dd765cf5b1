// SPDX-License-Identifier: MIT
//
// phymul-run --plan: which spacing keeps an error and a rate.
#pragma once

#include <phymul/plan.h>

#include <string>
#include <vector>

#include "run_options.h"

/// Prints the report of the plan and the command that runs what it chose: the program's own `words` with other options.
/// Returns the exit code: 0, or 3 if the wishes are not kept. Throws phymul::Error as plan() does, and for a body that
/// no spacing makes.
int print_plan(const RunOptions& options, const std::vector<std::string>& words, phymul::SceneBuilder builder);
