// SPDX-License-Identifier: MIT
//
// The points at which tools touch surfaces among the rows of a scene's loads, and what the passes of surface_passes.h
// write of one tool at a time.
#pragma once

#include "compute_tables.h"
#include "device/float_surfaces.h"

namespace phymul::gl {

class ComputeSurfaces : public SurfaceTools {
 public:
  ComputeSurfaces(FloatSurfaces surfaces, const ComputeTables& tables, StorageRows& rows);

  int patches() const { return patches_; }

 private:
  int patches_;
};

}  // namespace phymul::gl
