// SPDX-License-Identifier: MIT
//
// What the elastic terms must do whatever the body: nothing at rest or under rigid motion, forces that are the slope of
// the energy, and the momenta each reaction promises.
#include <gtest/gtest.h>

#include <cstdio>

#include "support/bodies.h"

namespace phymul::test {
namespace {

/// The force a body of this stiffness shows when moved by one spacing: what "zero" is measured against.
double force_scale(const TopologyTextures& topology, const Model& model) {
  return largest_norm(forces_at(topology, random_positions(model, 0.3, 1)));
}

/// Runs `check` on every body with every variant that applies to it; sparse particles get springs.
template <class Check>
void for_each_case(const std::vector<Variant>& variants, Check&& check) {
  for (const Body& body : bodies()) {
    for (Variant variant : variants) {
      SCOPED_TRACE(body.name + ", " + variant.name);
      variant.options.on_sparse = SparseParticle::springs;
      const Model model = prepared(variant, body);
      check(model, build_topology(model, variant.options));
    }
  }
}

TEST(Elasticity, RestIsAFixedPoint) {
  double worst = 0.0;
  for_each_case(all_variants(), [&](const Model& model, const TopologyTextures& topology) {
    VecList force(model.rest.size()), attractor(model.rest.size());
    elastic_forces(topology, model.rest, force);
    EXPECT_LE(largest_norm(force), 1e-11 * force_scale(topology, model));
    attractors(topology, model.rest, attractor);
    for (Index i = 0; i < model.particle_count(); ++i) {
      const double off = (attractor[i] - model.rest[i]).norm() / body_size(model);
      EXPECT_LE(off, 1e-12) << "particle " << i;
      worst = std::max(worst, off);
    }
    EXPECT_LE(elastic_energy(topology, model.rest), 1e-20 * force_scale(topology, model) * mean_spacing(model));
  });
  std::printf("attractors off the rest shape by at most %.2g of the body size\n", worst);
}

TEST(Elasticity, RigidMotionLeavesNoForce) {
  double worst = 0.0;
  for_each_case(all_variants(), [&](const Model& model, const TopologyTextures& topology) {
    VecList force(model.rest.size());
    for (std::uint32_t seed = 1; seed <= 3; ++seed) {
      elastic_forces(topology, rigidly_moved(model, seed), force);
      const double left = largest_norm(force) / force_scale(topology, model);
      EXPECT_LE(left, 1e-10);
      worst = std::max(worst, left);
    }
  });
  std::printf("force left by rigid motion at most %.2g of that of a random state\n", worst);
}

TEST(Elasticity, ForcesAreTheSlopeOfTheEnergy) {
  double worst = 0.0;
  for_each_case(conservative_variants(), [&](const Model& model, const TopologyTextures& topology) {
    VecList force(model.rest.size());
    for (std::uint32_t seed = 11; seed <= 13; ++seed) {
      VecList x = random_positions(model, 0.2, seed);
      elastic_forces(topology, x, force);
      // Along random directions, so that every coordinate of every term takes part.
      std::mt19937 bits(seed);
      const double step = 1e-5 * mean_spacing(model);
      for (int direction = 0; direction < 3; ++direction) {
        VecList plus = x, minus = x;
        double expected = 0.0, scale = 0.0;
        for (std::size_t i = 0; i < x.size(); ++i) {
          const Vec3 d = random_vector(bits, model.dimension);
          plus[i] += step * d;
          minus[i] -= step * d;
          expected -= force[i].dot(d);
          scale += std::abs(force[i].dot(d));
        }
        const double found = (elastic_energy(topology, plus) - elastic_energy(topology, minus)) / (2.0 * step);
        EXPECT_NEAR(found, expected, 1e-6 * scale);
        worst = std::max(worst, std::abs(found - expected) / scale);
      }
    }
  });
  std::printf("forces and central differences of the energy apart by at most %.2g\n", worst);
}

TEST(Elasticity, MomentumIsKeptWhereItIsPromised) {
  struct Promise {
    Reaction reaction;
    const char* name;
    bool force, torque;
  };
  const Promise promises[] = {{Reaction::full, "full", false, false},
                              {Reaction::shared, "shared", true, false},
                              {Reaction::barycentric, "barycentric", true, false},
                              {Reaction::averaged, "averaged", true, true},
                              {Reaction::conservative, "conservative", true, true}};
  const Model model = cylinder_275();
  const VecList x = random_positions(model, 0.1, 3);
  VecList force(x.size());
  std::printf("cylinder, 275 particles, random state    net force / sum |F|   net torque / sum |F| R\n");
  for (const Promise& promise : promises) {
    elastic_forces(build_topology(model, {.reaction = promise.reaction}), x, force);
    double total = 0.0;
    for (const Vec3& f : force) total += f.norm();
    const double net = sum(force).norm() / total;
    const double turn = torque(x, force).norm() / (total * body_size(model));
    std::printf("  %-36s %18.3e %18.3e\n", promise.name, net, turn);
    if (promise.force) {
      EXPECT_LE(net, 1e-14) << promise.name;
    } else {
      EXPECT_GE(net, 1e-3) << promise.name;
    }
    if (promise.torque) {
      EXPECT_LE(turn, 1e-14) << promise.name;
    } else {
      EXPECT_GE(turn, 1e-5) << promise.name;
    }
  }
}

TEST(Elasticity, FurtherTermsKeepBothMomenta) {
  for_each_case(conservative_variants(), [](const Model& model, const TopologyTextures& topology) {
    const VecList x = random_positions(model, 0.2, 5);
    const VecList force = forces_at(topology, x);
    double total = 0.0;
    for (const Vec3& f : force) total += f.norm();
    EXPECT_LE(sum(force).norm(), 1e-13 * total);
    EXPECT_LE(torque(x, force).norm(), 1e-13 * total * body_size(model));
  });
}

TEST(Elasticity, WrongSizesAreRefused) {
  const Model model = make_tetrahedron(0.01);
  const TopologyTextures topology = build_topology(model);
  VecList short_of_one(3, Vec3::Zero()), room(4, Vec3::Zero());
  EXPECT_THROW(attractors(topology, model.rest, short_of_one), Error);
  EXPECT_THROW(elastic_forces(topology, short_of_one, room), Error);
  EXPECT_THROW(elastic_energy(topology, short_of_one), Error);
  EXPECT_THROW(estimate_spectrum(topology, short_of_one), Error);
  const std::vector<std::uint8_t> marks(5, 0);
  EXPECT_THROW(estimate_spectrum(topology, model.rest, marks), Error);
}

TEST(Elasticity, CollapsedBodiesStayFinite) {
  for_each_case(all_variants(), [](const Model& model, const TopologyTextures& topology) {
    VecList force(model.rest.size());
    for (int collapse = 0; collapse < 3; ++collapse) {  // to a plane, a line, a point
      VecList x = model.rest;
      for (Vec3& p : x) {
        for (int axis = 2 - collapse; axis < 3; ++axis) p[axis] = 0.0;
      }
      elastic_forces(topology, x, force);
      for (const Vec3& f : force) EXPECT_TRUE(f.allFinite());
      EXPECT_TRUE(std::isfinite(elastic_energy(topology, x)));
    }
  });
}

}  // namespace
}  // namespace phymul::test
