// SPDX-License-Identifier: MIT
//
// Solids and surfaces to fill, with volumes in closed form where there is one. Labelled images of shapes in closed
// form.
#pragma once

#include <gtest/gtest.h>
#include <phymul/labels.h>
#include <phymul/phymul.h>

#include <Eigen/Geometry>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>
#include <string>
#include <type_traits>

#include "model/closed_surface.h"
#include "support/bodies.h"

namespace phymul::test {

struct FilledShape {
  std::string name;
  Solid solid;
  double spacing;     // m, for some 2,000 to 3,000 particles
  double volume = 0;  // m^3; 0: only what the report says
};

inline double ball_volume(double radius) {
  return 4.0 / 3.0 * std::numbers::pi * radius * radius * radius;
}

inline Solid torus(double large, double small) {
  const Vec3 half(large + small, large + small, small);
  return {[=](const Vec3& x) { return std::hypot(std::hypot(x.x(), x.y()) - large, x.z()) - small; }, -half, half};
}

/// An ellipsoid bent along its length, so that one side is hollow.
inline Solid bean() {
  return {[](const Vec3& x) {
            const Vec3 straight(x.x(), x.y() - 8.0 * x.x() * x.x(), x.z());
            return 0.03 * (straight.cwiseQuotient(Vec3(0.06, 0.035, 0.03)).norm() - 1.0);
          },
          {-0.06, -0.035, -0.03},
          {0.06, 0.07, 0.03}};
}

inline Solid tube() {
  const Solid around = solid_capsule({-0.1, 0, 0}, {0.1, 0, 0}, 0.02),
              bore = solid_capsule({-0.1, 0, 0}, {0.1, 0, 0}, 0.01);
  return solid_intersection({solid_difference(around, bore), solid_box({-0.04, -0.03, -0.03}, {0.04, 0.03, 0.03})});
}

inline std::vector<FilledShape> filled_shapes() {
  const double pi = std::numbers::pi, r = 0.05;
  return {{"ball", solid_ball({0.001, 0.002, 0.003}, r), 0.0075, ball_volume(r)},
          {"ellipsoid", solid_ellipsoid({0, 0, 0}, {0.06, 0.04, 0.03}), 0.0063, ball_volume(1) * 0.06 * 0.04 * 0.03},
          {"thin_lobe", solid_ellipsoid({0, 0, 0}, {0.06, 0.04, 0.008}), 0.0044, ball_volume(1) * 0.06 * 0.04 * 0.008},
          {"tube", tube(), 0.0047},
          {"torus", torus(0.04, 0.012), 0.0049, 2.0 * pi * pi * 0.04 * 0.012 * 0.012},
          {"box", solid_box({0, 0, 0}, {0.07, 0.05, 0.031}), 0.0052, 1.085e-4},
          {"touching_balls", solid_union({solid_ball({-0.03, 0, 0}, 0.03), solid_ball({0.03, 0, 0}, 0.03)}), 0.006,
           2.0 * ball_volume(0.03)},
          {"capsule", solid_capsule({-0.02, 0.01, 0}, {0.03, 0.02, 0.04}, 0.02), 0.0045,
           ball_volume(0.02) + pi * 4e-4 * Vec3(0.05, 0.01, 0.04).norm()},
          {"bean", bean(), 0.0062, ball_volume(1) * 0.06 * 0.035 * 0.03},
          {"shell", solid_difference(solid_ball({0, 0, 0}, 0.04), solid_ball({0, 0, 0}, 0.03)), 0.0056,
           ball_volume(0.04) - ball_volume(0.03)}};
}

/// A ball of 5 cm whose radius goes up and down by up to a quarter, in waves of random direction and length.
inline Solid random_solid(std::uint32_t seed) {
  std::mt19937 bits(seed);
  struct Wave {
    Vec3 along;
    double phase;
  };
  std::vector<Wave> waves;
  for (int k = 0; k < 8; ++k) {
    const Vec3 along = 3.0 * random_vector(bits, 3);
    waves.push_back({along, std::numbers::pi * uniform(bits)});
  }
  const auto distance = [waves](const Vec3& x) {
    double sum = 0.0;
    for (const Wave& wave : waves) sum += std::sin(wave.along.dot(x.normalized()) + wave.phase);
    return x.norm() - 0.05 * (1.0 + sum / 32.0);
  };
  return {distance, Vec3::Constant(-0.063), Vec3::Constant(0.063)};
}

/// A cube of 2 n^2 triangles a side, each vertex where `place` puts that of the cube from -1 to 1. Sides share no
/// vertices, as in an STL.
template <class Place>
Surface cube_surface(int n, Place place) {
  Surface surface;
  const auto add_side = [&](const Vec3& out, const Vec3& u, const Vec3& v) {
    const auto first = static_cast<Index>(surface.vertices.size());
    for (int j = 0; j <= n; ++j) {
      for (int i = 0; i <= n; ++i) {
        surface.vertices.push_back(place(Vec3(out + u * (2.0 * i / n - 1.0) + v * (2.0 * j / n - 1.0))));
      }
    }
    for (int j = 0; j < n; ++j) {
      for (int i = 0; i < n; ++i) {
        const Index a = first + j * (n + 1) + i;
        surface.triangles.push_back({a, a + 1, a + n + 2});
        surface.triangles.push_back({a, a + n + 2, a + n + 1});
      }
    }
  };
  const Vec3 x = Vec3::UnitX(), y = Vec3::UnitY(), z = Vec3::UnitZ();
  add_side(z, x, y);
  add_side(-z, y, x);
  add_side(x, y, z);
  add_side(-x, z, y);
  add_side(y, z, x);
  add_side(-y, x, z);
  return surface;
}

inline Surface ball_surface(double radius, int n, const Vec3& centre = {0, 0, 0}) {
  return cube_surface(n, [=](const Vec3& x) { return Vec3(centre + radius * x.normalized()); });
}

inline Surface box_surface(const Vec3& low, const Vec3& high) {
  return cube_surface(1, [=](const Vec3& x) { return Vec3(0.5 * (low + high) + 0.5 * x.cwiseProduct(high - low)); });
}

inline Surface inside_out(Surface surface) {
  for (auto& t : surface.triangles) std::swap(t[1], t[2]);
  return surface;
}

/// Both, whether they touch or not.
inline Surface both(Surface a, const Surface& b) {
  const auto first = static_cast<Index>(a.vertices.size());
  a.vertices.insert(a.vertices.end(), b.vertices.begin(), b.vertices.end());
  for (const auto& [i, j, k] : b.triangles) a.triangles.push_back({first + i, first + j, first + k});
  return a;
}

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

/// A cube of `count` voxels along each side of 0.12 m around the origin; label_at gives that of a place.
template <class LabelAt>
LabelImage painted(Index count, const LabelAt& label_at) {
  const double side = 0.12, voxel = side / count;
  LabelImage image;
  image.size = {count, count, count};
  image.origin = Vec3::Constant(0.5 * (voxel - side));
  for (int axis = 0; axis < 3; ++axis) image.step[axis] = voxel * Vec3::Unit(axis);
  for (Index k = 0; k < count; ++k) {
    for (Index j = 0; j < count; ++j) {
      for (Index i = 0; i < count; ++i) {
        image.label.push_back(static_cast<std::uint16_t>(label_at(Vec3(image.origin + voxel * Vec3(i, j, k)))));
      }
    }
  }
  return image;
}

/// Of radius 0.05, label 1, with one of `radius`, label 2, in its middle.
inline LabelImage ball_in_ball(Index count, double radius) {
  return painted(count, [=](const Vec3& x) { return x.norm() > 0.05 ? 0 : x.norm() > radius ? 1 : 2; });
}

/// A random solid; each place in it belongs to the nearest of 2 to 6 centres.
inline LabelImage random_labels(std::uint32_t seed) {
  const Solid solid = random_solid(seed);
  std::mt19937 bits(seed);
  VecList centres(2 + seed % 5);
  for (Vec3& centre : centres) centre = 0.05 * random_vector(bits, 3);
  return painted(48, [&](const Vec3& x) {
    if (solid.distance(x) > 0.0) return 0;
    int nearest = 0;
    for (int k = 1; k < static_cast<int>(centres.size()); ++k) {
      if ((x - centres[k]).norm() < (x - centres[nearest]).norm()) nearest = k;
    }
    return nearest + 1;
  });
}

}  // namespace phymul::test
