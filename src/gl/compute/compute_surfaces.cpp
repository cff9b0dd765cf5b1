// SPDX-License-Identifier: MIT
#include "compute_surfaces.h"

#include <utility>

namespace phymul::gl {

ComputeSurfaces::ComputeSurfaces(FloatSurfaces surfaces, const ComputeTables& tables, StorageRows& rows)
    : SurfaceTools(std::move(surfaces.law_of)), patches_(surfaces.patches()) {
  rows.add("patch_corners_place", tables.placed(std::move(surfaces.corners), 3));
  rows.add("patch_laws_place", std::move(surfaces.laws));
  rows.add("patch_points_place", std::move(surfaces.points));
  rows.add("patch_ranges_place", tables.by_place(surfaces.ranges));
  rows.add("patch_around_place", std::move(surfaces.around));
  for (const char* name : {"first_end_place", "first_way_place", "corner_end_place", "corner_way_place",
                           "corner_given_place", "corner_shift_place"}) {
    rows.take(name, tables.places());
  }
  rows.take("patch_load_place", patches_);
  rows.take("patch_push_place", std::int64_t{2} * 4 * patches_);
  rows.note("patch_count", patches_);
}

}  // namespace phymul::gl
