// SPDX-License-Identifier: MIT
#pragma once

#include <phymul/display.h>

#include "view/visible_skin.h"

namespace phymul::gl {

/// As phymul::make_display. `solver` null: the positions are given by show(). `skin` null: the body itself is shown.
std::unique_ptr<Display> make_display(const Model& model, const Solver* solver, std::shared_ptr<const VisibleSkin> skin,
                                      const GlOptions& options);

}  // namespace phymul::gl
