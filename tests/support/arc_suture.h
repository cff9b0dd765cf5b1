// SPDX-License-Identifier: MIT
//
// A needle that is a half circle and goes through both edges of a wound.
#pragma once

#include <phymul/phymul.h>

#include <cmath>
#include <numbers>

#include "bodies.h"

namespace phymul::test {

inline constexpr double arc = 0.008, slab_top = 0.01, slab_middle = 0.006;  // m: radius of the needle; z; y

inline Needle half_circle() {
  return {.length = std::numbers::pi * arc,
          .radius = 0.3e-3,
          .puncture = 0.04,
          .cutting = 0.015,
          .static_friction = 2.0,
          .kinetic_friction = 1.5,
          .spread = 0.003,
          .arc_radius = arc,
          .leaving = 0.03};
}

/// Two slabs with faces at x = -gap / 2 and gap / 2, of cells of `spacing`, m; and the needle over the left one, 7 mm
/// from the middle, whose circle crosses both.
struct ArcSuture {
  explicit ArcSuture(double spacing = 0.002, double gap = 0.006, double young = 20e3)
      : model(slabs(spacing, gap, young)), scene(model) {
    scene.fix("left/x0").fix("right/x1");
    scene.add_tool("needle", {.shape = half_circle(), .pose = pose(-0.1), .friction = 0.3});
  }
  static Model slabs(double spacing, double gap, double young) {
    const auto slab = [&](double x) {
      const auto cells = [&](double length) { return static_cast<int>(std::lround(length / spacing)); };
      Model model = make_block({0.016, 0.012, slab_top}, cells(0.016), cells(0.012), cells(slab_top));
      set_material(model, {.young = young, .poisson = 0.45, .density = 1000});
      return moved(std::move(model), {x, 0, 0});
    };
    const Model left = slab(-0.016 - 0.5 * gap), right = slab(0.5 * gap);
    const std::array<NamedBody, 2> both{{{"left", &left}, {"right", &right}}};
    return merge_models(both);
  }
  /// So far round, rad, from where the tip touches the skin.
  static ToolPose pose(double angle) {
    const double above = std::sqrt(arc * arc - 0.007 * 0.007), first = std::asin(above / arc), at = first + angle;
    const Vec3 centre(0, slab_middle, slab_top + above);
    return {.position = centre - arc * Vec3(std::cos(at), 0, std::sin(at)),
            .orientation = Quaternion(Eigen::AngleAxisd(-at, Vec3::UnitY()))};
  }
  /// N along the circle, against going in.
  static double resistance(const ToolForce& force, const ToolPose& at) {
    const Vec3 to_centre = arc * (at.orientation * Vec3::UnitX());
    const Vec3 torque = force.mean_torque - to_centre.cross(force.mean_force);
    return torque.dot(at.orientation * Vec3::UnitY()) / arc;
  }

  Model model;
  Scene scene;
};

}  // namespace phymul::test
