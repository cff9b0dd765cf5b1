// SPDX-License-Identifier: MIT
//
// What a body lacks of the shape that it was filled from, and which of its shells are one, is said.
#include <phymul/phymul.h>

#include <gtest/gtest.h>

#include <cmath>

#include "label_images.h"
#include "support/message_of.h"

namespace phymul::test {
namespace {

/// A ball of 5 cm with a horn of 3 cm on top, less than 3 mm wide.
Surface horned_ball() {
  return cube_surface(60, [](const Vec3& x) {
    const Vec3 way = x.normalized();
    const double angle = std::acos(std::min(1.0, way.z())) / 0.02;
    return Vec3(way * (0.05 + 0.03 * std::exp(-angle * angle)));
  });
}

TEST(LostParts, AThinHornIsNamedWithPlaceAndLength) {
  // Of the 30 mm, without a spacing beside the ball. Where it is fine, only the tip is lost.
  const auto field = fine_near({0, 0, 0.07}, 0.02, 0.001, 0.008);
  const Model coarse = make_body(horned_ball(), {.spacing = 0.008}),
              fine = make_body(horned_ball(), {.spacing = 0.008, .spacing_at = field});
  EXPECT_TRUE(says(coarse.notes.at(0), "it: 0.018", " m around (0, 0, 0.0685", "than 0.008 m", "spacing_at"));
  EXPECT_TRUE(says(fine.notes.at(0), "it: 0.003", " m around (0, 0, 0.0757"));
  BodyReport report;
  for (const double spacing : {0.005, 0.008, 0.015}) {
    EXPECT_TRUE(make_body(ball_surface(0.05, 20), {.spacing = spacing}, &report).notes.empty());
    const double added = 4.0 * std::numbers::pi * 0.05 * 0.05 * report.moved;
    EXPECT_NEAR(report.volume - report.unmoved_volume, added, 0.1 * std::abs(added));
    EXPECT_TRUE(make_body(box_surface({0, 0, 0}, {0.1, 0.06, 0.08}), {.spacing = spacing}).notes.empty());
  }
}

TEST(LostParts, ARefusalNamesTheCause) {
  const auto filling = [](const auto& shape, double spacing) {
    return message_of([&] { make_body(shape, {.spacing = spacing}); });
  };
  const LabelImage cube = painted(60, [](const Vec3& x) { return x.cwiseAbs().maxCoeff() < 0.028; });
  EXPECT_TRUE(
      says(filling(cube, 0.018), "12.", "(18.", " % less before its surface was moved)", "m edges and corners"));
  const LabelImage far = painted(60, [](const Vec3& x) { return x.norm() < 0.03 || x.x() > 0.056; });
  EXPECT_TRUE(says(filling(far, 0.018), "parts thinner than the spacing are lost: 0.16", "m around (0.057"));
  EXPECT_TRUE(says(filling(box_surface({0, 0, 0}, {0.03, 0.03, 0.03}), 0.01), "m edges and corners"));
  EXPECT_TRUE(says(filling(solid_box({0, 0, 0}, {0.03, 0.03, 0.03}), 0.01), "are lost, or edges and corners"));
}

/// A bag with walls of 2 mm.
TEST(LostParts, ShellsThatAreFusedAreNoted) {
  const Surface bag = both(ball_surface(0.02, 40), inside_out(ball_surface(0.018, 40)));
  EXPECT_TRUE(make_body(bag, {.spacing = 0.0008}).notes.empty());
  EXPECT_TRUE(says(make_body(bag, {.spacing = 0.0015}).notes.at(1), "fused",
                   "body's surface has shells: 1, Euler number: -74, edges of more than two faces: 78;",
                   "it fills has shells: 2, Euler number: 4, edges of more than two faces: 0"));
  EXPECT_TRUE(refuses([&] { make_body(bag, {.spacing = 0.0018}); }, "are lost: walls, gaps or holes"));
}

}  // namespace
}  // namespace phymul::test
