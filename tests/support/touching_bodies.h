// SPDX-License-Identifier: MIT
//
// Bodies that touch each other, one that touches itself, and which particles and triangles may touch.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <utility>
#include <vector>

#include "bodies.h"
#include "interaction/contact_candidates.h"
#include "model/closed_surface.h"

namespace phymul::test {

inline constexpr double touching_spacing = 0.005;  // m

inline Model tissue(const Vec3& at, const std::array<int, 3>& cells) {
  Model model =
      with_material(make_block(touching_spacing * Vec3(cells[0], cells[1], cells[2]), cells[0], cells[1], cells[2]),
                    {5e3, 0.3, 1000.0});
  return moved(std::move(model), at);
}

inline Model joined_bodies(const Model& low, const Model& high) {
  return merged({{"low", &low}, {"high", &high}});
}

/// A cube of 1 cm over the middle of a slab of 2.5 cm, a gap above it and off its lattice.
inline Model stacked(double gap, const Vec3& at = {0, 0, 0}) {
  return joined_bodies(tissue(at, {5, 5, 2}), tissue(at + Vec3(0.0072, 0.0081, 0.01 + gap), {2, 2, 2}));
}

inline double lowest(const State& state, const std::vector<Index>& particles) {
  double z = 1e9;
  for (const Index i : particles) z = std::min(z, state.position[i].z());
  return z;
}

inline Vec3 mean_place(const State& state, const std::vector<Index>& particles) {
  Vec3 centre = Vec3::Zero();
  for (const Index i : particles) centre += state.position[i] / static_cast<double>(particles.size());
  return centre;
}

/// A strip of 9 cm, 5 mm thick.
inline Model long_strip() {
  return with_material(make_block({0.09, 0.01, 0.005}, 18, 2, 1), {5e3, 0.3, 1000.0});
}

/// The ends of a strip along x are pressed up and together above its middle, which is held.
struct PressedStrip {
  PressedStrip(const Model& model, double end) {
    const double length = body_size(model);
    first_end = model.particles_in([=](const Vec3& X) { return X.x() < end; });
    last_end = model.particles_in([=](const Vec3& X) { return X.x() > length - end; });
    middle = model.particles_in([=](const Vec3& X) { return std::abs(X.x() - 0.5 * length) < 0.001; });
  }
  void press(Scene& scene) const {
    scene.fix(middle);
    for (const bool last : {false, true}) {
      scene.add({.particles = last ? last_end : first_end,
                 .events = {{0, 0}, {0.1, 0.002}},
                 .direction = {last ? -1.0 : 1.0, 0, 0.25}});
    }
  }
  std::vector<Index> first_end, last_end, middle;
};

/// Rows of a particle of a surface and of a triangle.
using Pairs = std::set<std::pair<std::size_t, Index>>;

/// Those that a step with this margin may ask for, of all there are: of a particle and a body what may rank first.
inline Pairs pairs_that_count(const ContactSurface& surface, const VecList& place, const ContactOptions& options,
                              double margin) {
  Pairs pairs;
  for (std::size_t k = 0; k < place.size(); ++k) {
    const ContactSurface::Particle& own = surface.particles[k];
    std::vector<std::pair<double, Index>> reached;  // m, triangle
    std::vector<double> nearest(static_cast<std::size_t>(surface.bodies), HUGE_VAL);
    for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
      const ContactSurface::Triangle& triangle = surface.triangles[t];
      if (own.body == triangle.body && !options.self) continue;
      const Vec3 &a = place[triangle.corner[0]], &b = place[triangle.corner[1]], &c = place[triangle.corner[2]];
      const Vec3 share = closest_point(place[k], a, b, c);
      const double skins =
          options.margin > 0.0 ? 2.0 * options.margin : ContactSurface::usual_skin * (triangle.edge + own.edge);
      const double deep = ContactSurface::depth_factor * std::max(triangle.edge, own.edge);
      const double off = (place[k] - (share[0] * a + share[1] * b + share[2] * c)).norm();
      if (!(off <= std::max(margin + skins, deep)) || surface.is_own_skin(own, k, triangle)) continue;
      reached.emplace_back(off, static_cast<Index>(t));
      double& least = nearest[triangle.body];
      if (off < deep) least = std::min(least, off);
    }
    for (const auto& [off, t] : reached) {
      const double facing = ContactSurface::facing_share * surface.longest_edge;
      if (off <= nearest[surface.triangles[t].body] + facing) pairs.insert({k, t});
    }
  }
  return pairs;
}

inline Pairs pairs_listed(ContactCandidates& candidates, const VecList& place, double margin) {
  Pairs pairs;
  candidates.each(place, margin, HUGE_VAL, [&](const ContactCandidates::List& list) {
    for (const auto& near : list.triangles) EXPECT_TRUE(pairs.insert({list.particle, near.triangle}).second);
    return 0.0;
  });
  return pairs;
}

}  // namespace phymul::test
