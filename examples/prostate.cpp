// SPDX-License-Identifier: MIT
#include "prostate.h"

#include "scene_picture.h"

Prostate::Prostate(bool quick) {
  shape.semi_axes = phymul::Vec3(0.025, 0.015, 0.020);  // m
  shape.shell = 0.015;
  shape.shell_shift = {0.0, 0.003, 0.0};  // 12 mm of tissue behind the gland, 18 mm in front of it
  shape.core = quick ? 4 : 6;
  shape.organ_layers = quick ? 1 : 2;
  shape.shell_layers = quick ? 2 : 3;
  model = make_ellipsoid(shape);
  model.name = "prostate";
  set_materials(model, shape, {.young = 30e3, .poisson = 0.45, .density = 1000.0},
                {.young = 4e3, .poisson = 0.45, .density = 1000.0});
  // Skin and the wall of the rectum.
  phymul::set_material(model, {.young = 20e3, .poisson = 0.45, .density = 1000.0}, "rind");
  for (const phymul::Index i : model.group("skin")) {
    const phymul::Vec3& x = model.rest[i];
    const phymul::Vec3 from_middle = x - shape.shell_shift;
    if (from_middle.y() > 0.4 * (shape.semi_axes.y() + shape.shell) ||
        from_middle.z() < -0.75 * (shape.semi_axes.z() + shape.shell)) {
      held.push_back(i);
    }
  }
}

std::vector<char> Prostate::half(const phymul::Vec3& normal) const {
  EllipsoidShape straight = shape;
  straight.shell_shift.setZero();
  return cells_beyond(make_ellipsoid(straight), phymul::Vec3::Zero(), normal);
}

phymul::Simulation Prostate::simulation() const {
  phymul::Simulation sim(model, {.backend = "cpu",
                                 .damping = {.rate = 60.0},  // 1/s: the gland swings out within a tenth of a second
                                 .solver = {.threads = 1}});
  sim.scene().fix(held);
  return sim;
}
