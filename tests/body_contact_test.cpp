// SPDX-License-Identifier: MIT
//
// Bodies that touch each other, and themselves.
#include <gtest/gtest.h>

#include <algorithm>

#include "cpu/ball_grid.h"
#include "message_of.h"
#include "run_scenes.h"

namespace phymul {
namespace {

using namespace test;

TEST(BallGrid, FindsWhatTryingAllPairsFinds) {
  std::mt19937 bits(2);
  for (const double far : {0.0, 1000.0}) {
    VecList points;
    for (int k = 0; k < 500; ++k) points.push_back(random_vector(bits, 3) + Vec3(far, -far, far));
    points.push_back(points[3]);
    const double side = 0.2;
    cpu::BallGrid grid;
    for (int again = 0; again < 2; ++again) {
      grid.build(points, side);
      std::vector<std::pair<std::size_t, std::size_t>> found, wanted;
      grid.each_pair([&](std::size_t a, std::size_t b) {
        if ((points[a] - points[b]).norm() <= side) found.push_back({a, b});
      });
      for (std::size_t a = 0; a < points.size(); ++a) {
        for (std::size_t b = a + 1; b < points.size(); ++b) {
          if ((points[a] - points[b]).norm() <= side) wanted.push_back({a, b});
        }
      }
      std::sort(found.begin(), found.end());
      EXPECT_EQ(found, wanted);
      EXPECT_GT(wanted.size(), 500u);
    }
  }
}

Model tissue_block(const Vec3& at, const Vec3& size = {0.02, 0.02, 0.02}, int cells = 4) {
  Model model = make_block(size, cells, cells, cells);
  set_material(model, {5e3, 0.3, 1000.0});
  return moved(std::move(model), at);
}

/// Two cubes, the upper one a gap above the lower one and turned off its lattice by a shift.
Model stacked(double gap) {
  const Model low = tissue_block({0, 0, 0}), high = tissue_block({0.0013, 0.0021, 0.02 + gap});
  const NamedBody bodies[] = {{"low", &low}, {"high", &high}};
  return merge_models(bodies);
}

double lowest(const State& state, const std::vector<Index>& particles) {
  double z = 1e9;
  for (const Index i : particles) z = std::min(z, state.position[i].z());
  return z;
}

Vec3 mean_place(const State& state, const std::vector<Index>& particles) {
  Vec3 centre = Vec3::Zero();
  for (const Index i : particles) centre += state.position[i] / static_cast<double>(particles.size());
  return centre;
}

/// Dropped from 5 cm: never through, never apart, and at rest on the other in the end.
TEST(BodyContact, ABodyDroppedOnAnotherStaysOnIt) {
  const Model model = stacked(0.05);
  for (const BackendCase& backend : cpu_backends) {
    Scene scene(model);
    scene.gravity({0, 0, -9.81}).fix("low/z0").contacts({.friction = 0.5});
    SolverOptions options = options_for(backend, 3.0);
    const auto solver = make_solver(backend.name, model, scene, {}, options);
    const double dt = 0.4 * solver->stable_step();
    const std::vector<Index> high = model.group("high"), low = model.group("low");
    double deepest = 1e9, fastest = 0.0;
    const int calls = static_cast<int>(1.2 / (20 * dt));
    for (int k = 0; k < calls; ++k) {
      const StepReport report = solver->step(20, dt);
      ASSERT_TRUE(report.ok()) << report.message();
      deepest = std::min(deepest, lowest(solver->read(), high));
      fastest = std::max(fastest, report.max_speed);
    }
    const State end = solver->read();
    EXPECT_GT(deepest, 0.01) << backend.name;  // above the middle of the lower cube at all times
    EXPECT_LT(fastest, 2.5) << backend.name;   // m/s; it falls at 1
    EXPECT_GT(mean_place(end, high).z(), mean_place(end, low).z() + 0.01) << backend.name;
    EXPECT_LT(mean_place(end, high).z(), mean_place(end, low).z() + 0.03) << backend.name;
    Vec3 speed = Vec3::Zero();
    for (const Index i : high) speed += end.velocity[i] / static_cast<double>(high.size());
    EXPECT_LT(speed.norm(), 0.02) << backend.name;
  }
}

/// Thrown at each other at 2 m/s without gravity: what one loses the other gains, to rounding, at every step.
TEST(BodyContact, MomentumIsKeptToRounding) {
  const Model model = stacked(0.01);
  for (const double friction : {0.0, 0.6}) {
    Scene scene(model);
    scene.contacts({.friction = friction});
    SolverOptions options;
    options.largest_push = std::numeric_limits<double>::infinity();
    const auto solver = make_solver("reference", model, scene, {}, options);
    State state = rest_state(model);
    double scale = 0.0;
    for (const Index i : model.group("high")) state.velocity[i] = Vec3(0.5, 0.2, -2.0);
    for (Index i = 0; i < model.particle_count(); ++i) scale += model.mass[i] * state.velocity[i].norm();
    solver->reset(state);
    const Momentum start = solver->momentum();
    const double dt = 0.1 * solver->stable_step();
    double turned = 0.0;
    for (int k = 0; k < 400; ++k) {
      const StepReport report = solver->step(1, dt);
      ASSERT_TRUE(report.ok()) << report.message();
      const Momentum now = solver->momentum();
      ASSERT_LT((now.linear - start.linear).norm(), 1e-13 * scale) << k;
      turned = std::max(turned, (now.angular - start.angular).norm());
    }
    double given = 0.0;
    const State end = solver->read();
    for (const Index i : model.group("low")) given += model.mass[i] * end.velocity[i].z();
    EXPECT_LT(given, -0.1 * scale);  // they met
    // Along the line between two balls there is no torque; what is left is the parting of overlaps. Rubbing turns
    // them, as balls without a spin of their own cannot.
    if (friction == 0.0) EXPECT_LT(turned, 1e-3 * scale * 0.02);
  }
}

/// On a body that stays, inclined gravity: beyond the angle of friction it slides, well below it stays.
TEST(BodyContact, FrictionHoldsAndSlides) {
  const Model floor = tissue_block({-0.03, -0.02, -0.0225}, {0.12, 0.06, 0.02}, 24), block = tissue_block({0, 0, 0});
  const NamedBody bodies[] = {{"floor", &floor}, {"block", &block}};
  const Model model = merge_models(bodies);
  const std::vector<Index> own = model.group("block");
  double way[2] = {0, 0};
  for (const bool rough : {false, true}) {
    Scene scene(model);
    scene.fix("floor").gravity({4.0, 0, -9.0}).contacts({.friction = rough ? 1.0 : 0.0, .radius = 0.003});
    const auto solver = make_solver("cpu", model, scene, {}, options_for({"cpu", 2}, 20.0));
    const double dt = 0.4 * solver->stable_step();
    ASSERT_TRUE(solver->step(static_cast<int>(0.15 / dt), dt).ok());
    way[rough] = mean_place(solver->read(), own).x() - mean_place(rest_state(model), own).x();
  }
  EXPECT_GT(way[0], 0.012);
  EXPECT_LT(way[1], 0.006);
}

TEST(BodyContact, BitsDoNotDependOnThreads) {
  const Model model = stacked(0.003);
  State end[2];
  for (int threads : {1, 2}) {
    Scene scene(model);
    scene.gravity({0, 0, -9.81}).fix("low/z0").contacts({});
    const auto solver = make_solver("cpu", model, scene, {}, options_for({"cpu", threads}));
    ASSERT_TRUE(solver->step(400, 0.4 * solver->stable_step()).ok());
    end[threads - 1] = solver->read();
  }
  EXPECT_EQ(end[0], end[1]);
}

/// A body by itself, at rest and bent, has no contact of its own: its skin is no neighbour to itself.
TEST(BodyContact, ASingleBodyIsAsWithoutContacts) {
  const Model model = tissue_block({0, 0, 0});
  State end[2];
  for (const bool touching : {false, true}) {
    Scene scene(model);
    scene.gravity({0, 0, -9.81}).fix("x0");
    if (touching) scene.contacts({});
    const auto solver = make_solver("reference", model, scene, {}, options_for({"reference", 0}));
    ASSERT_TRUE(solver->step(300, 0.4 * solver->stable_step()).ok());
    end[touching] = solver->read();
  }
  EXPECT_EQ(end[0], end[1]);
}

/// A strip of tissue folded over itself: with self the halves stay apart, without they pass through each other.
TEST(BodyContact, ABodyTouchesItself) {
  Model model = make_block({0.06, 0.01, 0.005}, 24, 4, 2);
  set_material(model, {5e3, 0.3, 1000.0});
  std::vector<Index> middle, first_end, last_end;
  for (Index i = 0; i < model.particle_count(); ++i) {
    if (std::abs(model.rest[i].x() - 0.03) < 0.001) middle.push_back(i);
    if (model.rest[i].x() < 0.012) first_end.push_back(i);
    if (model.rest[i].x() > 0.048) last_end.push_back(i);
  }
  double least[2] = {1e9, 1e9};
  for (const bool self : {false, true}) {
    Scene scene(model);
    scene.fix(middle).contacts({.self = self});
    const auto push = [&](const std::vector<Index>& end, double sign) {
      Load load;
      load.type = LoadType::force;
      load.particles = end;
      load.direction = {sign, 0, 0.25};  // up first, then together above the middle
      load.events = {{0, 0}, {0.1, 0.002}};
      scene.add(load);
    };
    push(first_end, 1.0);
    push(last_end, -1.0);
    const auto solver = make_solver("cpu", model, scene, {}, options_for({"cpu", 2}, 10.0));
    const double dt = 0.4 * solver->stable_step();
    for (int k = 0; k < static_cast<int>(0.4 / (40 * dt)); ++k) {
      const StepReport report = solver->step(40, dt);
      ASSERT_TRUE(report.ok()) << report.message();
      const State state = solver->read();
      for (const Index i : first_end) {
        for (const Index j : last_end) {
          least[self] = std::min(least[self], (state.position[i] - state.position[j]).norm());
        }
      }
    }
  }
  EXPECT_LT(least[0], 0.001);
  EXPECT_GT(least[1], 0.0015);  // balls are 2.5 mm across or so
}

TEST(BodyContact, AnOverlapAtTheStartGoesWithoutSpeed) {
  const Model model = stacked(-0.002);
  Scene scene(model);
  scene.contacts({.friction = 0.0});
  const auto solver = make_solver("reference", model, scene, {}, options_for({"reference", 0}, 0.0));
  const double dt = 0.4 * solver->stable_step();
  const StepReport report = solver->step(400, dt);
  ASSERT_TRUE(report.ok()) << report.message();
  const double apart =
      mean_place(solver->read(), model.group("high")).z() - mean_place(solver->read(), model.group("low")).z();
  EXPECT_GT(apart, 0.0185);
  EXPECT_LT(apart, 0.03);
  EXPECT_LT(solver->energy().kinetic, 1e-4 * 5e3 * 8e-6);  // J; of E V
}

TEST(BodyContact, RefusesWhatMakesNoSense) {
  const Model model = make_tetrahedron(0.01);
  Scene scene(model);
  EXPECT_NE(message_of([&] { scene.contacts({.friction = -1}); }).find("coefficient of friction of 0 or more"),
            std::string::npos);
  EXPECT_NE(message_of([&] { scene.contacts({.radius = -1}); }).find("radius"), std::string::npos);
  EXPECT_NE(message_of([&] { scene.contacts({.rounds = 0}); }).find("1 round"), std::string::npos);
  EXPECT_FALSE(scene.contacts());
}

}  // namespace
}  // namespace phymul
