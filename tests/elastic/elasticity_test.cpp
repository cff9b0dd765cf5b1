// SPDX-License-Identifier: MIT
//
// What the elastic terms must do whatever the body: nothing at rest or under rigid motion, forces that are the slope of
// the energy, and the momenta each reaction promises. The energy of a material as a function of the deformation
// gradient alone: which law it is where, and what it leads to.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <cstdio>
#include <functional>
#include <random>

#include "elastic/energy_density.h"
#include "support/bodies.h"
#include "support/message_of.h"
#include "support/sanitized.h"

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

constexpr double shear = 3e3;

double bulk_of(double poisson) {
  return 2.0 * shear * (1.0 + poisson) / (3.0 * (1.0 - 2.0 * poisson));
}

double energy_of(const Mat3& F, double bulk, Mat3* gradient = nullptr, const Stiffening& of = {}) {
  if (of == Stiffening{}) return energy_density<double>({}, {shear, bulk}, F, gradient);
  return energy_density<double>({.strain_energy = StrainEnergy::stiffening},
                                {shear, bulk, of.exponential, of.exponent, of.second, of.second_fades}, F, gradient);
}

/// None, like cortex, and the laws of Mooney and Rivlin, Demiray, and Veronda and Westmann.
constexpr Stiffening laws[] = {{},
                               like_cortex,
                               {.second = 0.5},
                               {.exponential = 1.0, .exponent = 20.0},
                               {.exponential = 2.0, .exponent = 5.0, .second = -1.0}};

Mat3 random_turn(std::mt19937& bits) {
  std::normal_distribution<double> any;
  return Eigen::Quaterniond(any(bits), any(bits), any(bits), any(bits)).normalized().toRotationMatrix();
}

TEST(EnergyDensity, IsNeoHookeanForStretchesOfSixToSeventeenTenths) {
  std::mt19937 bits(1);
  std::uniform_real_distribution<double> stretch(0.6, 1.7);
  const double bulk = bulk_of(0.45);
  for (int k = 0; k < 2000; ++k) {
    Vec3 s(stretch(bits), stretch(bits), stretch(bits));
    if (k < 8) s = Vec3(k & 1 ? 0.6 : 1.7, k & 2 ? 0.6 : 1.7, k & 4 ? 0.6 : 1.7);
    const Mat3 F = random_turn(bits) * s.asDiagonal() * random_turn(bits);
    const double J = s.prod();
    const double shape = 0.5 * shear * (std::pow(J, -2.0 / 3.0) * s.squaredNorm() - 3.0);
    const double volume =
        bulk * (std::abs(J - 1.0) < 0.5 ? 0.5 * (J - 1.0) * (J - 1.0) : 0.5 * std::abs(J - 1.0) - 0.125);
    EXPECT_NEAR(energy_of(F, bulk), shape + volume, 1e-9 * (shape + volume)) << s.transpose();
  }
}

TEST(EnergyDensity, ItsGradientIsTheSlopeOfTheEnergyEverywhere) {
  std::mt19937 bits(2);
  std::normal_distribution<double> any;
  const double bulk = bulk_of(0.45), h = 1e-6;
  for (int k = 0; k < 2000; ++k) {
    Mat3 F, way, gradient;
    for (double& f : F.reshaped()) f = any(bits) * std::pow(10.0, 0.3 * any(bits));
    for (double& f : way.reshaped()) f = any(bits);
    if (k % 2 == 1) F = Mat3::Identity() + 0.1 * F;
    const Stiffening& law = laws[k % std::size(laws)];
    energy_of(F, bulk, &gradient, law);
    const double slope = gradient.cwiseProduct(way).sum();
    const double found =
        (energy_of(F + h * way, bulk, nullptr, law) - energy_of(F - h * way, bulk, nullptr, law)) / (2 * h);
    EXPECT_NEAR(found, slope, 1e-4 * gradient.norm() * way.norm() + 1e-3) << F;
  }
}

/// Down along the energy from any start, inverted ones too, a deformation ends in a rotation.
TEST(EnergyDensity, HasNoMinimaButRotations) {
  std::mt19937 bits(3);
  std::normal_distribution<double> any;
  for (const double poisson : {-0.3, 0.3, 0.45}) {
    const double bulk = bulk_of(poisson);
    for (int k = 0; k < (sanitized ? 20 : 200); ++k) {
      const Stiffening& law = laws[k < 100 ? 0 : k % std::size(laws)];
      Mat3 F, gradient;
      for (double& f : F.reshaped()) f = any(bits) * std::exp(0.7 * any(bits));
      if (k % 4 == 0) F.row(2) *= 1e-3;
      if (k % 4 == 1) F *= 1e-2;
      for (int step = 0; step < 20000; ++step) {
        energy_of(F, bulk, &gradient, law);
        F -= (k < 100 ? 0.02 : 0.005) / (shear + bulk) * std::min(1.0, (shear + bulk) * 5.0 / gradient.norm()) *
             gradient;
      }
      EXPECT_LT((F.transpose() * F - Mat3::Identity()).norm(), 1e-3) << poisson << '\n' << F;
      EXPECT_GT(F.determinant(), 0.0);
    }
  }
}

// StrainEnergy::stiffening: bodies of it against the closed forms of the laws that it contains, and what constants
// are refused.

constexpr double mu = 2e3;

/// A law as it is written in textbooks: dpsi/dX and dpsi/dY of an incompressible body over mu / 2.
struct Textbook {
  const char* name;
  Stiffening stiffening;
  std::function<double(double X, double Y)> by_first, by_second;
};

std::vector<Textbook> textbook_laws() {
  const auto zero = [](double, double) { return 0.0; };
  return {
      {"Mooney and Rivlin", {.second = 0.4}, [](double, double) { return 0.6; }, [](double, double) { return 0.4; }},
      {"Demiray", {.exponential = 1.0, .exponent = 2.5}, [](double X, double) { return std::exp(2.5 * X); }, zero},
      {"Veronda and Westmann",
       {.exponential = 1.5, .exponent = 2.0, .second = -0.5},
       [](double X, double) { return 1.5 * std::exp(2.0 * X); },
       [](double, double) { return -0.5; }},
      {"like cortex", like_cortex,
       [](double X, double Y) {
         const double e = 40.0 * X < 4.0 ? std::exp(40.0 * X) : std::exp(4.0), q = 1.0 + 20.0 * X;
         return 0.7 + 0.3 * e - 10.0 / q - 10.0 * 20.0 * (Y - X) / (q * q);
       },
       [](double X, double) { return 10.0 / (1.0 + 20.0 * X); }}};
}

/// Mean stresses on the faces x1, along x, and y1, along x and y, of a cube of 1 m in the homogeneous strain F: from
/// the velocities that a first step gives to its particles.
struct Faces {
  double xx = 0.0, xy = 0.0, yy = 0.0;
};
Faces stresses_on(const char* backend, const Material& material, const Mat3& F) {
  Model model = make_block({1, 1, 1}, 2, 2, 2);
  model.most_mass_moved = 0.0;
  set_material(model, material);
  const Scene scene(model);
  const auto solver = make_solver(backend, model, scene, {}, uncut());
  State state = rest_state(model);
  for (Vec3& x : state.position) x = F * x;
  solver->reset(state);
  const double dt = 1e-3 * solver->stable_step();
  EXPECT_TRUE(solver->step(1, dt).ok());
  state = solver->read();
  Faces mean;
  for (const Index i : model.group("x1")) mean.xx -= model.mass[i] / dt * state.velocity[i].x();
  for (const Index i : model.group("y1")) {
    mean.xy -= model.mass[i] / dt * state.velocity[i].x();
    mean.yy -= model.mass[i] / dt * state.velocity[i].y();
  }
  return mean;
}

/// A pressure that stretched cubes of one volume may have besides takes no part: it is what is left on the sides.
TEST(Stiffening, CubesHaveTheStressesOfTheTextbook) {
  for (const Textbook& law : textbook_laws()) {
    const Material material{.young = 2.98 * mu, .poisson = 0.49, .density = 1000, .stiffening = law.stiffening};
    const auto half = [&](double X, double Y, double over) { return law.by_first(X, Y) + law.by_second(X, Y) * over; };
    for (const char* backend : {"reference", "cpu"}) {
      for (const double s : {0.65, 0.9, 0.975, 1.05, 1.1, 1.6}) {
        const double side = 1.0 / std::sqrt(s);
        const double closed = mu * (s - 1 / (s * s)) * half(s * s + 2 / s - 3, 2 * s + 1 / (s * s) - 3, 1 / s);
        const Faces found = stresses_on(backend, material, Vec3(s, side, side).asDiagonal());
        EXPECT_NEAR(found.xx - found.yy * side / s, closed, 0.01 * std::abs(closed)) << law.name << backend << s;
      }
      for (const double amount : {0.05, 0.2, 0.6}) {
        const double X = amount * amount, closed = mu * amount * half(X, X, 1.0);
        Mat3 F = Mat3::Identity();
        F(0, 1) = amount;
        EXPECT_NEAR(stresses_on(backend, material, F).xy, closed, 0.01 * closed) << law.name << backend << amount;
      }
    }
  }
}

TEST(Stiffening, IsRefusedWhereTheStressFallsOrWithFibres) {
  Model model = make_block({0.02, 0.02, 0.02}, 2, 2, 2);
  Material tissue = soft_tissue(0.45);
  const auto refused = [&](const Stiffening& stiffening) {
    tissue.stiffening = stiffening;
    return message_of([&] { set_material(model, tissue); });
  };
  EXPECT_TRUE(says(refused({.second = 6.0}), "stress rises with every stretch from 0.6 to 1.7", "second 6",
                   "falls at a stretch of 1.", "bring second nearer to 0"));
  EXPECT_TRUE(says(refused({.second = -3.0}), "falls at a stretch of 0.8"));
  EXPECT_TRUE(says(refused({.exponential = -0.5, .exponent = 5.0}), "only second may be below 0"));
  EXPECT_TRUE(says(refused({.exponent = NAN}), "finite numbers"));
  EXPECT_TRUE(says(refused({.second_fades = -1.0}), "only second may be below 0"));
  EXPECT_EQ(refused(like_cortex), "(no error)");
  EXPECT_EQ(build_topology(model).options.strain_energy, StrainEnergy::stiffening);
  tissue.fibre_ratio = 2.0;
  set_material(model, tissue);
  EXPECT_TRUE(refuses([&] { build_topology(model); }, "fibre_ratio above 1 and one with stiffening"));
}

/// Tables of one stiffening are not for another.
TEST(Stiffening, IsPartOfTheModel) {
  Model model = make_block({0.02, 0.02, 0.02}, 2, 2, 2);
  Material tissue = soft_tissue(0.45);
  set_material(model, tissue);
  const auto plain = std::make_shared<const TopologyTextures>(build_topology(model));
  tissue.stiffening = like_cortex;
  set_material(model, tissue);
  const Scene scene(model);
  EXPECT_TRUE(refuses([&] { make_solver("reference", plain, scene); }, "stiffening"));
  EXPECT_NE(fingerprint(*plain), fingerprint(build_topology(model)));
}

}  // namespace
}  // namespace phymul::test
