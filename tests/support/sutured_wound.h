// SPDX-License-Identifier: MIT
//
// Two slabs of tissue, side by side, and stitches across the gap between them. A needle that is a half circle and goes
// through both edges of a wound.
#pragma once

#include <phymul/phymul.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "bodies.h"

namespace phymul::test {

/// Slabs of a size, m, below z = size.z, with faces at x = -gap / 2 and gap / 2.
struct Wound {
  Wound(const Vec3& of_size, double gap) : model(slabs(of_size, gap)), scene(model), size(of_size), first_gap(gap) {}

  static Model slab(const Vec3& own, double x) {
    const auto cells = [](double length) { return std::max(2, static_cast<int>(std::lround(length / 0.005))); };
    Model model = make_block(own, cells(own.x()), cells(own.y()), cells(own.z()));
    set_material(model, {.young = 5e3, .poisson = 0.3, .density = 1000});
    model.add_group("all", every_particle(model));
    return moved(std::move(model), {x, 0, 0});
  }
  static Model slabs(const Vec3& each, double gap) {
    const Model left = slab(each, -each.x() - 0.5 * gap), right = slab(each, 0.5 * gap);
    const std::array<NamedBody, 2> both{{{"left", &left}, {"right", &right}}};
    return merge_models(both);
  }

  /// Down on the left, under the gap and up on the right, 4 mm from the edges.
  ThreadHandle stitch(double y, const Thread& thread) {
    const double out = 0.5 * first_gap + 0.004, in = 0.5 * first_gap + 0.001, top = size.z(), deep = 0.4 * size.z();
    return scene.sew("stitch " + std::to_string(++stitches), thread,
                     VecList{Vec3(-out, y, top), Vec3(-in, y, deep), Vec3(in, y, deep), Vec3(out, y, top)});
  }
  /// Pulls the tips across the wound, with so many N.
  void tighten(int row, double force) {
    const ThreadHandle thread = scene.thread("stitch " + std::to_string(row + 1));
    thread.pull(ThreadTip::first, {force, 0, 0});
    thread.pull(ThreadTip::last, {-force, 0, 0});
  }
  void tie_all(int throws = 4) {
    for (int k = 1; k <= stitches; ++k) {
      const ThreadHandle thread = scene.thread("stitch " + std::to_string(k));
      thread.tie(0, 3, throws);
      for (const ThreadTip tip : {ThreadTip::first, ThreadTip::last}) thread.pull(tip, Vec3::Zero());
    }
  }
  /// m, between the means of both faces.
  double gap_of(const State& state) const {
    const auto mean_x = [&](const std::vector<Index>& face) {
      double sum = 0.0;
      for (const Index i : face) sum += state.position[i].x() / static_cast<double>(face.size());
      return sum;
    };
    return mean_x(model.group("right/x0")) - mean_x(model.group("left/x1"));
  }

  Model model;
  Scene scene;
  Vec3 size;
  double first_gap;
  int stitches = 0;
};

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
