// SPDX-License-Identifier: MIT
#include <phymul/state.h>

#include <algorithm>
#include <cmath>

namespace phymul {

State rest_state(const Model& model) {
  return {0.0, model.rest, VecList(model.rest.size(), Vec3::Zero())};
}

bool is_finite(const State& state) {
  const auto finite = [](const Vec3& v) { return v.allFinite(); };
  return std::isfinite(state.time) && std::all_of(state.position.begin(), state.position.end(), finite) &&
         std::all_of(state.velocity.begin(), state.velocity.end(), finite);
}

}  // namespace phymul
