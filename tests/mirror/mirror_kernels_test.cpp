// SPDX-License-Identifier: MIT
//
// The mirror's forces in float (mirror_forces.h) against those in double: within the rounding bound, and nothing at all
// at rest. The vector kernels of the backend "cpu" are tested in tests/cpu.
#include <gtest/gtest.h>

#include <iostream>

#include "mirror_forces.h"
#include "support/bodies.h"
#include "support/bounded_forces.h"
#include "support/sanitized.h"

namespace phymul::test {
namespace {

using cpu::Float3;

bool can_carry(const Variant& variant, const Body& body) {
  return !(variant.options.volume_stiffness > 0.0 && body.model.cells.empty());
}

struct Case {
  std::string name;
  Model model;
  TopologyTextures topology;
};

/// One body with every variant it can carry.
template <class Visit>
void for_each_variant(const Body& body, const Visit& visit) {
  for (const Variant& variant : all_variants()) {
    if (!can_carry(variant, body)) continue;
    const Model model = prepared(variant, body);
    visit(Case{body.name + ", " + variant.name, model, build_topology(model, variant.options)});
  }
}

/// Every body with every variant it can carry.
template <class Visit>
void for_each_case(const Visit& visit) {
  for (const Body& body : bodies()) for_each_variant(body, visit);
}

/// Displacements of random positions, rounded to float.
std::vector<Float3> random_displacements(const Model& model, double amount, std::uint32_t seed) {
  const VecList x = random_positions(model, amount, seed);
  std::vector<Float3> u;
  for (std::size_t i = 0; i < x.size(); ++i) {
    const Vec3 d = x[i] - model.rest[i];
    u.push_back({static_cast<float>(d.x()), static_cast<float>(d.y()), static_cast<float>(d.z())});
  }
  return u;
}

VecList widened(const std::vector<Float3>& list) {
  VecList wide;
  for (const Float3& v : list) wide.emplace_back(v.x, v.y, v.z);
  return wide;
}

/// Largest error over bound of the forces at u; a failure where it is above 1.
double worst_force_ratio(const Case& body, const cpu::MirrorForces& forces, const std::vector<Float3>& u) {
  std::vector<Float3> force(u.size());
  forces.evaluate(u, force);
  const VecList wide = widened(u), found = widened(force);
  const VecList exact = forces_at(body.topology, sum_of(body.topology.rest, wide));
  const BoundedForces bounded(body.topology, wide);
  double worst = 0.0;
  for (Index i = 0; i < body.topology.particle_count; ++i) {
    const Bounded3 bound = bounded.force(i);
    const std::array<Bounded, 3> axes{bound.x, bound.y, bound.z};
    for (int axis = 0; axis < 3; ++axis) {
      const Bounded& b = axes[static_cast<std::size_t>(axis)];
      const double error = std::abs(found[i][axis] - exact[i][axis]);
      EXPECT_LE(error, b.error) << body.name << ", particle " << i << ", axis " << axis << ", force " << exact[i][axis];
      // The formulas themselves, apart from their rounding: the literals are rounded, and exact itself to 2^-53.
      EXPECT_LE(std::abs(b.value - exact[i][axis]), 0.1 * b.error);
      EXPECT_TRUE(std::isfinite(b.error)) << body.name << ", particle " << i;
      if (b.error > 0.0) worst = std::max(worst, error / b.error);
    }
  }
  return worst;
}

TEST(MirrorKernels, NoForceAtRest) {
  for_each_case([](const Case& body) {
    const cpu::MirrorForces forces(pack_floats(body.topology));
    const std::vector<Float3> u(body.model.rest.size());
    std::vector<Float3> force(u.size(), Float3{1, 1, 1});
    forces.evaluate(u, force);
    for (const Float3& f : force) EXPECT_EQ(f, Float3{}) << body.name;
  });
}

TEST(MirrorKernels, NoForceAfterATranslation) {
  for_each_case([](const Case& body) {
    const cpu::MirrorForces forces(pack_floats(body.topology));
    std::vector<Float3> u(body.model.rest.size(), Float3{1.5f, -0.3f, body.model.dimension == 2 ? 0.0f : 7.7f});
    std::vector<Float3> force(u.size(), Float3{1, 1, 1});
    forces.evaluate(u, force);
    for (const Float3& f : force) EXPECT_EQ(f, Float3{}) << body.name;
  });
}

constexpr std::uint32_t random_states = sanitized ? 5 : 100;

class MirrorKernelsOf : public testing::TestWithParam<std::size_t> {};

TEST_P(MirrorKernelsOf, ForcesAreWithinTheRoundingBound) {
  double worst = 0.0;
  for_each_variant(bodies()[GetParam()], [&](const Case& body) {
    const cpu::MirrorForces forces(pack_floats(body.topology));
    for (std::uint32_t state = 0; state < random_states; ++state) {
      const double amount = 0.05 + 0.25 * state / random_states;
      worst = std::max(worst, worst_force_ratio(body, forces, random_displacements(body.model, amount, state + 1)));
    }
  });
  // A bound that nothing comes near would hide mistakes.
  EXPECT_GT(worst, 0.01);
  std::cout << "worst error over bound " << worst << "\n";
}

INSTANTIATE_TEST_SUITE_P(Bodies, MirrorKernelsOf, testing::Range(std::size_t{0}, bodies().size()),
                         [](const auto& body) { return bodies()[body.param].name; });

TEST(MirrorKernels, SmallStrainsKeepTheirDigits) {
  double worst = 0.0;
  for_each_case([&](const Case& body) {
    const cpu::MirrorForces forces(pack_floats(body.topology));
    const std::vector<Float3> u = random_displacements(body.model, 1e-6, 3);
    worst = std::max(worst, worst_force_ratio(body, forces, u));
    const BoundedForces bounded(body.topology, widened(u));
    double largest = 0.0, error = 0.0;
    for (Index i = 0; i < body.topology.particle_count; ++i) {
      largest = std::max(largest, std::abs(bounded.force(i).x.value));
      error = std::max(error, bounded.force(i).x.error);
    }
    EXPECT_LE(error, 2e-3 * largest) << body.name;
  });
  std::cout << "worst error over bound " << worst << "\n";
}

TEST(MirrorKernels, EnumeratedBasesGiveTheForcesOfTheTable) {
  for (const Body& body : bodies()) {
    for (const Variant& variant : all_variants()) {
      const bool enumerable = variant.name.find(" all") != std::string::npos &&
                              variant.options.reaction != Reaction::conservative && body.model.dimension == 3;
      if (!enumerable) continue;
      const Case it{body.name + ", " + variant.name, body.model, build_topology(body.model, variant.options)};
      const cpu::MirrorForces forces(pack_floats(it.topology, FloatLayout::enumerated));
      std::vector<Float3> force(body.model.rest.size());
      forces.evaluate(std::vector<Float3>(force.size()), force);
      for (const Float3& f : force) EXPECT_EQ(f, Float3{}) << it.name;
      for (std::uint32_t state = 0; state < 10; ++state) {
        worst_force_ratio(it, forces, random_displacements(body.model, 0.05 + 0.025 * state, state + 1));
      }
    }
  }
}

}  // namespace
}  // namespace phymul::test
