// SPDX-License-Identifier: MIT
#pragma once

#include <gtest/gtest.h>
#include <phymul/body.h>
#include <phymul/surface.h>

#include <type_traits>

#include "model/enclosed_volume.h"

namespace phymul::test {

/// No cell inverted, angles bounded, faces that fit to each other.
inline void expect_sound(const Model& model, const BodyReport& report) {
  EXPECT_GT(report.smallest_angle, 10.0);
  EXPECT_LT(report.largest_angle, 165.0);
  EXPECT_EQ(report.particles, model.particle_count());
  EXPECT_EQ(report.cells, static_cast<Index>(model.cells.size()));
  double volume = 0.0;
  for (const Cell& cell : model.cells) {
    ASSERT_GT(cell_volume(model, cell), 0.0);
    volume += cell_volume(model, cell);
  }
  EXPECT_NEAR(volume, report.volume, 1e-12 * volume);
  // A face between two cells that do not fit would leave four triangles there that no other closes.
  Surface skin{model.rest, surface_triangles(model), {}};
  const double enclosed = enclosed_volume(skin.triangles, skin.vertices);
  EXPECT_NEAR(enclosed, volume, 1e-9 * volume);
  EXPECT_NO_THROW(mend_surface(skin));
  EXPECT_TRUE(skin.notes.empty()) << skin.notes.front();
}

struct SoundBody {
  Model model;
  BodyReport report;
};

/// What make_body() makes of a solid, a surface or a labelled image, held to the above.
template <class Shape,
          class Options = std::conditional_t<std::is_same_v<Shape, LabelImage>, LabelBodyOptions, BodyOptions>>
SoundBody sound_body(const Shape& shape, const std::type_identity_t<Options>& options) {
  SoundBody made;
  made.model = make_body(shape, options, &made.report);
  expect_sound(made.model, made.report);
  return made;
}

}  // namespace phymul::test
