// SPDX-License-Identifier: MIT
//
// Bodies of one region: what is asked of their shapes.
#include <phymul/body.h>
#include <phymul/error.h>
#include <phymul/surface.h>
#include <phymul/surface_patch.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/bounding_box.h"
#include "base/place_text.h"
#include "filling.h"
#include "interior.h"
#include "model/enclosed_volume.h"
#include "surface_interior.h"

namespace phymul {

SpacingField fine_near(const Vec3& place, double radius, double fine, double coarse, double growth) {
  const auto refuse = [](const std::string& what) { throw Error("fine_near: expected " + what); };
  if (!place.allFinite()) refuse("a finite place, got " + place_text(place));
  for (const auto& [name, value] : {std::pair{"radius", radius}, {"growth", growth}}) {
    if (value > 0.0 && std::isfinite(value)) continue;
    refuse(std::string("a ") + name + " above 0, got " + length_text(value));
  }
  if (!(fine > 0.0 && fine <= coarse && std::isfinite(coarse))) {
    refuse("0 < fine <= coarse, both in m, got " + length_text(fine) + " and " + length_text(coarse));
  }
  return [=](const Vec3& x) { return std::min(coarse, fine + growth * std::max(0.0, (x - place).norm() - radius)); };
}

Model make_body(const Surface& surface, const BodyOptions& options, BodyReport* report) {
  Surface mended = surface;
  mend_surface(mended);
  const Eigen::AlignedBox3d box = bounding_box(mended.vertices);
  const CentredLattice lattice = lattice_over(box.min(), box.max(), options);
  const double volume = enclosed_volume(mended.triangles, mended.vertices);
  BodyReport own;
  Model model = filled_body(
      SurfaceInterior(mended, lattice), lattice, [&](bool) { return volume; }, options, own);
  const Surface skin{model.rest, surface_triangles(model), {}};
  const auto sample = [&](const Contains& see) { sample_surface(mended, 0.5 * options.spacing, see); };
  const std::string lost = lost_parts(sample, skin, options), fused = fused_note(mended, skin);
  require_volume(own, options, [&] { return lost.empty() ? fused : lost; });
  if (report) *report = own;
  const auto note = [&](const std::string& what) {
    model.notes.push_back("make_body: " + what + "; take a smaller spacing than " + length_text(options.spacing) +
                          " m, or a finer one there (BodyOptions::spacing_at, fine_near)");
  };
  if (!lost.empty()) note("the body lacks parts of the surface, farther than a spacing from it: " + lost);
  if (!fused.empty()) note(fused);
  model.notes.insert(model.notes.begin(), mended.notes.begin(), mended.notes.end());
  return model;
}

Model make_body(const Solid& solid, const BodyOptions& options, BodyReport* report) {
  if (!solid.distance) refuse_body("the solid has no distance function");
  if (!solid.low.allFinite() || !solid.high.allFinite() || !(solid.low.array() < solid.high.array()).all()) {
    refuse_body("expected a finite box with low below high, got " + place_text(solid.low) + " to " +
                place_text(solid.high));
  }
  const CentredLattice lattice = lattice_over(solid.low, solid.high, options);
  const SolidInterior interior(solid);
  BodyReport own;
  Model model = filled_body(
      interior, lattice, [&](bool is_graded) { return interior.volume(lattice, is_graded); }, options, own);
  require_volume(own, options, {});
  if (report) *report = own;
  return model;
}

}  // namespace phymul
