// SPDX-License-Identifier: MIT
#pragma once

#include <phymul/display.h>

namespace phymul::gl {

/// Both as phymul::make_display; `solver` null: the positions are given by show().
std::unique_ptr<Display> make_display(const Model& model, const Solver* solver, const GlOptions& options);

}  // namespace phymul::gl
