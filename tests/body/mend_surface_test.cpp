// SPDX-License-Identifier: MIT
//
// Surfaces: what is mended and said, and what is refused with its place.
#include <phymul/body.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "body_shapes.h"
#include "model/closed_surface.h"
#include "support/message_of.h"

namespace phymul::test {
namespace {

Surface mended(Surface surface) {
  mend_surface(surface);
  return surface;
}

std::string refusal(const Surface& surface) {
  return message_of([&] { mended(surface); });
}

Surface box() {
  return box_surface({0, 0, 0}, {0.03, 0.02, 0.01});
}

TEST(MendSurface, LeavesASoundOneAlone) {
  const Surface surface = mended(box());
  EXPECT_EQ(surface.vertices.size(), 8u);  // of 24
  EXPECT_EQ(surface.triangles.size(), 12u);
  EXPECT_TRUE(surface.notes.empty()) << surface.notes.front();
  const Surface again = mended(surface);
  EXPECT_EQ(again.triangles, surface.triangles);
  EXPECT_EQ(again.vertices, surface.vertices);
}

TEST(MendSurface, TurnsWhatIsWoundTheWrongWay) {
  const Surface out = mended(inside_out(box()));
  EXPECT_NEAR(enclosed_volume(out.triangles, out.vertices), 6e-6, 1e-18);
  ASSERT_EQ(out.notes.size(), 1u);
  EXPECT_EQ(out.notes[0], "surface: it was inside out; all triangles were turned");
  Surface some = box();
  for (const int row : {0, 5, 6}) std::swap(some.triangles[row][0], some.triangles[row][1]);
  some = mended(some);
  EXPECT_NEAR(enclosed_volume(some.triangles, some.vertices), 6e-6, 1e-18);
  ASSERT_EQ(some.notes.size(), 1u);
  EXPECT_TRUE(says(some.notes[0], "3 of 12 triangles were clockwise"));
  // A ball in a cavity of a ball.
  const Surface nested = mended(both(both(ball_surface(0.05, 8), ball_surface(0.04, 8)), ball_surface(0.01, 8)));
  EXPECT_TRUE(says(nested.notes.at(0), "768 of 2304"));
}

/// The line that says whether one shell lies in the other meets an edge of the outer one, and its ends do not.
TEST(MendSurface, FindsACavityBehindAnEdge) {
  const double unit = 1.0 / 128.0;
  Surface outer = box_surface(Vec3::Zero(), Vec3::Constant(9 * unit)),
          inner = box_surface(Vec3::Constant(3 * unit), Vec3::Constant(6 * unit));
  const auto at = [&](Surface& surface, double x, double y, double z) {
    for (std::size_t i = 0; i < surface.vertices.size(); ++i) {
      if (surface.vertices[i] == unit * Vec3(x, y, z)) return static_cast<Index>(i);
    }
    throw Error("no such vertex");
  };
  // Triangles 4 and 5 are the side of largest x.
  const Index a = at(outer, 9, 0, 0), b = at(outer, 9, 9, 0), c = at(outer, 9, 9, 9), d = at(outer, 9, 0, 9);
  outer.triangles[4] = {a, b, d};
  outer.triangles[5] = {b, c, d};
  const Index e = at(inner, 6, 3, 3), f = at(inner, 6, 6, 3), g = at(inner, 6, 6, 6), h = at(inner, 6, 3, 6);
  inner.triangles[4] = inner.triangles[0];
  inner.triangles[5] = inner.triangles[1];
  inner.triangles[0] = {e, f, g};
  inner.triangles[1] = {e, g, h};
  const Surface hollow = mended(both(outer, inner));
  const double volume = enclosed_volume(hollow.triangles, hollow.vertices);
  EXPECT_NEAR(volume, (729 - 27) * unit * unit * unit, 1e-12);
}

TEST(MendSurface, DropsTrianglesWithTwoCornersInOnePlace) {
  Surface surface = box();
  surface.vertices.push_back(surface.vertices[0] + Vec3(1e-9, 0, 0));
  surface.triangles.push_back({0, 24, 1});
  surface = mended(surface);
  EXPECT_EQ(surface.triangles.size(), 12u);
  EXPECT_TRUE(says(surface.notes.at(0), "1 of 13 triangles had two corners in one place"));
}

TEST(MendSurface, DropsTrianglesThatRepeatOthers) {
  const Surface twice = mended(both(box(), box()));
  EXPECT_EQ(twice.triangles, mended(box()).triangles);
  EXPECT_TRUE(says(twice.notes.at(0), "12 of 24 triangles repeated another"));
  // Two boxes with a common side become one, whichever way they are turned.
  for (const double angle : {0.0, 0.3, 0.7, 1.9, 2.6}) {
    Surface two = both(box(), box_surface({0.03, 0, 0}, {0.05, 0.02, 0.01}));
    const Eigen::AngleAxisd turn(angle, Vec3(1, 2, 3).normalized());
    for (Vec3& x : two.vertices) x = turn * x;
    two = mended(two);
    EXPECT_EQ(two.triangles.size(), 20u);
    EXPECT_NEAR(enclosed_volume(two.triangles, two.vertices), 1e-5, 1e-15);
    EXPECT_TRUE(says(two.notes.at(0), "4 of 24"));
  }
  EXPECT_TRUE(says(refusal(both(box(), inside_out(box()))), "back to back"));
}

/// Two sheets with the same border and different diagonals. Their volume is what rounding makes of 0.
TEST(MendSurface, LeavesAShellThatEnclosesNothingAsItIs) {
  for (const double angle : {0.0, 0.3, 0.7, 1.9, 2.6}) {
    for (const bool inverted : {false, true}) {
      Surface sheets;
      sheets.vertices = {{0.1, 0, 0}, {0.11, 0, 0.003}, {0.11, 0.01, 0.003}, {0.1, 0.01, 0}};
      sheets.triangles = {{0, 1, 2}, {0, 2, 3}, {0, 3, 1}, {1, 3, 2}};
      if (inverted) sheets = inside_out(sheets);
      Surface given = both(box(), sheets);
      const Eigen::AngleAxisd turn(angle, Vec3(1, 2, 3).normalized());
      for (Vec3& x : given.vertices) x = turn * x;
      const Surface once = mended(given);
      ASSERT_EQ(once.notes.size(), 1u);
      EXPECT_TRUE(says(once.notes[0], "4 triangles, the first at")) << once.notes[0];
      const Surface again = mended(once);
      EXPECT_EQ(again.triangles, once.triangles);
      EXPECT_EQ(again.notes, once.notes);
      EXPECT_NEAR(enclosed_volume(once.triangles, once.vertices), 6e-6, 1e-17);
    }
  }
}

TEST(MendSurface, SaysWhereItIsOpen) {
  Surface open = box();
  open.triangles.pop_back();
  const std::string message = refusal(open);
  EXPECT_TRUE(says(message, "expected a closed surface, got 3 open edges, the first from (0, 0, 0"));
  // Nothing was changed.
  EXPECT_EQ(open.vertices.size(), 24u);
}

TEST(MendSurface, SaysWhereItCrossesItself) {
  const Surface other = box_surface({0.012, 0.005, 0.002}, {0.018, 0.03, 0.008});
  for (const Surface& two : {both(box(), other), both(other, box())}) {
    EXPECT_TRUE(says(refusal(two), "cross each other at (0.01"));
  }
  // Touching along a face is no crossing.
  EXPECT_EQ(refusal(both(box(), box_surface({0.004, 0.02, 0.002}, {0.018, 0.03, 0.008}))), "(no error)");
}

/// The first triangle of the smaller box lies on the other one.
TEST(MendSurface, LeavesShellsThatTouchAsTheyAre) {
  Surface small = box_surface({-0.04, 0.03, 0.03}, {0, 0.07, 0.07});
  std::rotate(small.triangles.begin(), small.triangles.begin() + 4, small.triangles.end());
  for (int k = 0; k < 40; ++k) {
    Surface two = both(box_surface({0, 0, 0}, {0.1, 0.1, 0.1}), small);
    const Eigen::AngleAxisd turn(0.3 * k, Vec3(1, 2, 3).normalized());
    for (Vec3& x : two.vertices) x = turn * x;
    two = mended(two);
    EXPECT_TRUE(two.notes.empty()) << two.notes.front();
    EXPECT_NEAR(enclosed_volume(two.triangles, two.vertices), 1e-3 + 6.4e-5, 1e-15);
  }
}

TEST(MendSurface, RefusesWhatBoundsNothing) {
  EXPECT_TRUE(says(refusal({}), "expected triangles, got none"));
  Surface nan = box();
  nan.vertices[7].y() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(says(refusal(nan), "at vertex 7"));
  Surface beyond = box();
  beyond.triangles[3][1] = 99;
  EXPECT_TRUE(says(refusal(beyond), "triangle 3 has vertex 99 of 24"));
  // The projective plane of six vertices: closed, and with one side.
  Surface plane;
  std::mt19937 bits(1);
  for (int k = 0; k < 6; ++k) plane.vertices.push_back(0.1 * random_vector(bits, 3));
  plane.triangles = {{0, 1, 2}, {0, 2, 3}, {0, 3, 4}, {0, 4, 5}, {0, 5, 1},
                     {1, 2, 4}, {2, 3, 5}, {3, 4, 1}, {4, 5, 2}, {5, 1, 3}};
  EXPECT_TRUE(says(refusal(plane), "on its other side"));
  // A wall inside, from edge to edge and of two layers.
  Surface walled = mended(box_surface(Vec3::Zero(), Vec3::Constant(0.125)));
  const auto at = [&](double x, double y, double z) {
    return static_cast<Index>(std::ranges::find(walled.vertices, 0.125 * Vec3(x, y, z)) - walled.vertices.begin());
  };
  const Index p = at(0, 0, 0), q = at(1, 1, 0), r = at(1, 1, 1), s = at(0, 0, 1);
  walled.triangles.insert(walled.triangles.end(), {{p, q, r}, {p, r, s}, {q, r, s}, {q, s, p}});
  EXPECT_TRUE(says(refusal(walled), "triangles meet at the edge from"));
  // Two rooms: 3 triangles at each edge of the wall between them.
  Surface rooms = both(box_surface({0, 0, 0}, {0.05, 0.05, 0.05}), box_surface({0.05, 0, 0}, {0.1, 0.05, 0.05}));
  rooms.triangles.erase(rooms.triangles.begin() + 4, rooms.triangles.begin() + 6);
  EXPECT_TRUE(says(refusal(rooms), "3 triangles meet at the edge from", "remove inner walls"));
}

TEST(MendSurface, SaysASizeThatIsNoOrgans) {
  const auto note = [](double scale) { return mended(box_surface(Vec3::Zero(), scale * Vec3(1, 1, 1))).notes.at(0); };
  EXPECT_TRUE(says(note(120.0), "120 m, and no organ's is; if the file is in millimetres, read it with 0.001"));
  EXPECT_TRUE(says(note(1e-4), "check the metres per unit"));
  const Surface twice = mended(mended(box_surface(Vec3::Zero(), {120, 1, 1})));
  EXPECT_EQ(twice.notes.size(), 1u);
  EXPECT_TRUE(mended(box_surface(Vec3::Zero(), {0.9, 0.1, 0.1})).notes.empty());
}

}  // namespace
}  // namespace phymul::test
