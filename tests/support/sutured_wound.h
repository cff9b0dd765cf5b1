// SPDX-License-Identifier: MIT
//
// Two slabs of tissue, side by side, and stitches across the gap between them.
#pragma once

#include <phymul/phymul.h>

#include <algorithm>
#include <cmath>

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

}  // namespace phymul::test
