// SPDX-License-Identifier: MIT
#pragma once

#include <phymul/surface.h>

#include "outer_faces.h"

namespace phymul {

/// tissue_surface() of a valid model in 3-D, or of some of its cells, and its outer faces: nothing is checked.
TissueSurface tissue_surface_of(const Model& model, const OuterFaces& outer);

/// Whether a cut crosses a cell that is there.
bool has_cuts(const Model& model);

}  // namespace phymul
