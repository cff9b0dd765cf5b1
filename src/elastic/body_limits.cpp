// SPDX-License-Identifier: MIT
#include <phymul/bodies.h>
#include <phymul/elasticity.h>

#include <algorithm>
#include <cstdio>

namespace phymul {

std::vector<BodyLimit> body_limits(const Model& model, const TopologyTextures& topology, double damping_factor) {
  std::vector<BodyLimit> limits;
  for (const ConnectedBody& body : connected_bodies(model)) {
    std::vector<std::uint8_t> fixed(model.rest.size(), 7);
    for (const Index i : body.particles) fixed[i] = 0;
    const Spectrum spectrum = estimate_spectrum(topology, topology.rest, fixed);
    limits.push_back({body.name, body.particles.front(), stable_step(topology, spectrum, damping_factor)});
  }
  return limits;
}

std::string describe(std::span<const BodyLimit> limits) {
  const auto least = std::min_element(limits.begin(), limits.end(), [](const BodyLimit& a, const BodyLimit& b) {
    return a.stable_step < b.stable_step;
  });
  if (least == limits.end()) return "there is no body";
  const auto named = [](const BodyLimit& limit) {
    return limit.name.empty() ? "the body of particle " + std::to_string(limit.first) : '"' + limit.name + '"';
  };
  char step[32];
  const auto seconds = [&](const BodyLimit& limit) {
    std::snprintf(step, sizeof step, "%.3g s", limit.stable_step);
    return std::string(step);
  };
  std::string text = named(*least) + " sets the stable step of " + seconds(*least);
  for (const BodyLimit& limit : limits) {
    if (&limit != &*least) text += ", " + named(limit) + " by itself allows " + seconds(limit);
  }
  return text;
}

}  // namespace phymul
