// SPDX-License-Identifier: MIT
//
// Particles without any stiffness of their own, for joints alone to move.
#pragma once

#include <phymul/phymul.h>

namespace phymul::test {

inline Model loose_particles(VecList rest, double mass) {
  Model model;
  model.mass.assign(rest.size(), mass);
  model.stiffness.assign(rest.size(), 0.0);
  for (std::size_t i = 0; i < rest.size(); ++i) model.neighbours.push_row<const Index*>(nullptr, nullptr);
  model.rest = std::move(rest);
  return model;
}

/// Of loose particles.
inline std::unique_ptr<Solver> loose_solver(const std::string& backend, const Model& model, const Scene& scene,
                                            const SolverOptions& options = {}) {
  return make_solver(backend, model, scene, {.law = Law::springs}, options);
}

}  // namespace phymul::test
