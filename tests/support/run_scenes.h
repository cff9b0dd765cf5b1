// SPDX-License-Identifier: MIT
//
// Runs that tests of saved states and recordings share.
#pragma once

#include <phymul/phymul.h>

#include "bodies.h"

namespace phymul::test {

/// A calibrated block, 1,000 particles and so more than one cluster, wherever it is asked to stand.
inline Model block_at(const Vec3& origin) {
  Model model = make_block({0.06, 0.03, 0.03}, 15, 8, 8);
  for (Vec3& x : model.rest) x += origin;
  set_material(model, soft_tissue());
  return model;
}

inline Load pull(const Model& model, const char* group, const Vec3& direction, std::vector<ValueEvent> events,
                 LoadType type = LoadType::translation) {
  Load load;
  load.type = type;
  load.particles = model.group(group);
  load.events = std::move(events);
  load.direction = direction;
  load.applied_to = group;
  return load;
}

struct BackendCase {
  const char* name;
  int threads;
};
inline constexpr BackendCase cpu_backends[] = {{"reference", 0}, {"cpu", 1}, {"cpu", 2}};

inline SolverOptions options_for(const BackendCase& backend, double damping = 5.0) {
  SolverOptions options;
  options.threads = backend.threads;
  options.damping.rate = damping;
  return options;
}

}  // namespace phymul::test
