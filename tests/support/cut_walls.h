// SPDX-License-Identifier: MIT
//
// Walls that tests cut.
#pragma once

#include <phymul/phymul.h>

#include <string>

#include "bodies.h"
#include "removable_body.h"
#include "wall_cases.h"

namespace phymul::test {

inline constexpr double sheet_side = 0.1;  // m
inline const Material film{.young = 20e3, .poisson = 0.4, .density = 1000.0, .thickness = 2e-3};

inline Surface square(int n, double jitter) {
  return grid_surface(n, n, jitter, [](double u, double v) { return Vec3(sheet_side * u, sheet_side * v, 0.0); });
}

inline Model sheet(int n = 8, double jitter = 0.2) {
  Model model = make_wall(square(n, jitter), {.material = film});
  model.add_group("x0", model.particles_in([](const Vec3& x) { return x.x() < 1e-9; }));
  return model;
}

inline Model slab_in_capsule() {
  Model model = with_material(slab(), {5e3, 0.4, 1000.0});
  add_capsule(model, {.young = 100e3, .poisson = 0.4, .density = 1100.0, .thickness = 0.5e-3},
              [](const Vec3& x) { return x.z() > 0.005; });
  return model;
}

inline Model sphere() {
  return wall_of(sphere_surface(0.05, 5), 20e3, 0.4, 2e-3);
}

inline SimulationOptions without_material(const std::string& backend) {
  SimulationOptions options = options_for(backend);
  options.material = {};
  return options;
}

}  // namespace phymul::test
