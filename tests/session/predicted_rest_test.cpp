// SPDX-License-Identifier: MIT
//
// StaticOptions::predict: calls that follow each other as loads, tools and held places change come to the same rest, in
// fewer evaluations.
#include <gtest/gtest.h>
#include <phymul/topology_textures.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <utility>

#include "statics/grid_level.h"
#include "statics/rest_body.h"
#include "support/bodies.h"
#include "support/failure_states.h"

namespace phymul::test {
namespace {

SimulationOptions soft_tissue(double poisson) {
  SimulationOptions options;
  options.material = Material{.young = 10e3, .poisson = poisson, .density = 1000};
  options.backend = "reference";
  return options;
}

Simulation cantilever(double poisson) {
  Simulation sim(make_tetrahedral_block({0.2, 0.05, 0.05}, 8, 2, 2, 0.2, 1), soft_tissue(poisson));
  sim.scene().fix("x0");
  return sim;
}

Simulation under_a_ball(ToolContact contact) {
  Simulation sim(make_block({0.08, 0.08, 0.05}, 9, 9, 6), soft_tissue(0.45));
  sim.scene().fix("z0").add_tool(
      "ball", {.shape = Sphere{0.02}, .pose = {.position = {0.04, 0.04, 0.066}}, .contact = contact});
  return sim;
}

struct Motion {
  std::string name;
  std::function<Simulation()> make;
  std::function<void(Simulation&, int)> change;  // to call k
  double share;                                  // of the evaluations without predictions, at most
};

void move_ball(Simulation& sim, int k) {
  sim.scene().tool("ball").move_to({.position = {0.04 + 5e-5 * k, 0.04, 0.065 - 5e-5 * k}});
}

std::vector<Motion> motions() {
  const auto load = [](Simulation& sim, int k) { sim.scene().gravity({0, 0, -0.2 * std::pow(1.01, k)}); };
  return {{"a load that grows", [] { return cantilever(0.3); }, load, 0.35},
          {"a load that grows, nu 0.45", [] { return cantilever(0.45); }, load, 0.35},
          {"a load that turns", [] { return cantilever(0.45); },
           [](Simulation& sim, int k) {
             sim.scene().gravity(Vec3(0, 0.006 * std::sin(0.35 * k), -0.2 - 0.006 * std::cos(0.35 * k)));
           },
           0.7},
          {"a tissue that is pulled",
           [] {
             Simulation sim = cantilever(0.45);
             sim.scene().add_tool("grip", {.shape = Sphere{0.015}, .pose = {.position = {0.2, 0.025, 0.05}}});
             sim.scene().tool("grip").grasp(0.003);
             sim.advance(1e-3);
             return sim;
           },
           [](Simulation& sim, int k) {
             sim.scene().tool("grip").move_to({.position = {0.2, 0.025, 0.05 + 2e-4 * k}});
           },
           0.5},
          {"a ball", [] { return under_a_ball(ToolContact::particles); }, move_ball, 0.5}};
}

TEST(PredictedRest, IsTheRestThatAnySearchFindsInFewerEvaluations) {
  for (const Motion& motion : motions()) {
    Simulation sims[] = {motion.make(), motion.make()};
    int evaluations[] = {0, 0};
    double off = 0.0;
    for (int k = 0; k < 16; ++k) {
      for (int predict = 0; predict < 2; ++predict) {
        motion.change(sims[predict], k);
        const StaticResult result = sims[predict].solve_static({.tolerance = 1e-4, .predict = predict == 1});
        ASSERT_TRUE(result.converged()) << motion.name << ", call " << k << ": " << result.message();
        EXPECT_LE(result.residual, 1e-4) << motion.name;
        if (k > 2) evaluations[predict] += result.evaluations;
      }
      off = std::max(off, largest_distance(sims[0].state().position, sims[1].state().position));
    }
    EXPECT_LT(off, 1e-3 * sims[0].max_displacement()) << motion.name;
    EXPECT_LT(evaluations[1], motion.share * evaluations[0]) << motion.name;
    std::printf("%s: %d evaluations in place of %d, %.1e of the displacement apart\n", motion.name.c_str(),
                evaluations[1], evaluations[0], off / sims[0].max_displacement());
  }
}

/// Where points of triangles share a force, a search takes a few estimates of it alone; calls that follow each other go
/// on with them, and come nearer to the law.
TEST(PredictedRest, GoesOnWithTheForcesOfAToolOnTheSurface) {
  Simulation sim = under_a_ball(ToolContact::surface);
  const auto ball = sim.scene().tool("ball");
  std::vector<double> forces;
  for (int k = 0; k < 20; ++k) {
    move_ball(sim, std::min(k, 5));
    ASSERT_TRUE(sim.solve_static({.predict = true}).converged());
    forces.push_back(sim.force_on(ball).force.norm());
  }
  EXPECT_NEAR(forces[19], forces[18], 1e-3 * forces[19]);
  Simulation once = under_a_ball(ToolContact::surface);
  move_ball(once, 5);
  ASSERT_TRUE(once.solve_static().converged());
  const double first = once.force_on(once.scene().tool("ball")).force.norm();
  EXPECT_NEAR(first, forces.back(), 0.05 * first);
  EXPECT_GT(std::abs(first - forces.back()), 1e-3 * first);  // else this test shows nothing
}

/// What was found before is of no use, or in the way, where the body, what is held or the tools are others.
TEST(PredictedRest, IsOfTheSceneAsItIsNow) {
  const std::vector<std::pair<std::string, std::function<void(Simulation&)>>> changes{
      {"load", [](Simulation& sim) { sim.scene().gravity(Vec3(0, 0.1, -0.2)); }},
      {"ball",
       [](Simulation& sim) {
         sim.scene().add_tool("ball", {.shape = Sphere{0.02}, .pose = {.position = {0.15, 0.025, 0.056}}});
       }},
      {"larger ball",
       [](Simulation& sim) {
         sim.scene().remove_tool("ball");
         sim.scene().add_tool("ball", {.shape = Sphere{0.024}, .pose = {.position = {0.15, 0.025, 0.056}}});
       }},
      {"ball far away",
       [](Simulation& sim) {
         sim.scene().tool("ball").move_to({.position = {0.15, 0.025, 0.2}});
       }},
      {"stiffness", [](Simulation& sim) { sim.scene().scale_stiffness(2.0); }},
      {"cells",
       [](Simulation& sim) {
         sim.remove_cells(std::vector<Index>{100, 101});
       }},
      {"held", [](Simulation& sim) { sim.scene().fix("x1"); }},
      {"no ball", [](Simulation& sim) { sim.scene().remove_tool("ball"); }},
      {"the load again", [](Simulation& sim) { sim.scene().gravity(Vec3(0, 0, -0.2)); }}};
  Simulation sim = cantilever(0.45);
  sim.scene().gravity({0, 0, -0.2});
  for (std::size_t k = 0; k < changes.size(); ++k) {
    for (int again = 0; again < 2; ++again) {
      ASSERT_TRUE(sim.solve_static({.predict = true}).converged()) << changes[k].first;
    }
    changes[k].second(sim);
    ASSERT_TRUE(sim.solve_static({.predict = true}).converged()) << changes[k].first;
    Simulation fresh = cantilever(0.45);
    fresh.scene().gravity({0, 0, -0.2});
    for (std::size_t done = 0; done <= k; ++done) changes[done].second(fresh);
    ASSERT_TRUE(fresh.solve_static().converged()) << changes[k].first;
    EXPECT_LT(largest_distance(sim.state().position, fresh.state().position), 1e-5 * fresh.max_displacement())
        << changes[k].first;
  }
}

/// Where a plate has left the body, its stiffness must leave the preconditioner: with it a search takes 3.2 times the
/// evaluations of one that does not predict, without it 1.07 times.
TEST(PredictedRest, AToolThatLeftIsNotInTheWay) {
  int evaluations[] = {0, 0};
  for (int predict = 0; predict < 2; ++predict) {
    Simulation sim(make_block({0.08, 0.08, 0.05}, 9, 9, 6), soft_tissue(0.45));
    const auto at = [](double z) { return ToolPose{.position = {0, 0, z}, .orientation = {0, 1, 0, 0}}; };
    sim.scene().fix("z0").gravity({0.1, 0, -0.2}).add_tool("plate", {.shape = HalfSpace{}, .pose = at(0.0499)});
    for (const double z : {0.0499, 0.04989, 0.0505}) {
      sim.scene().tool("plate").move_to(at(z));
      const StaticResult result = sim.solve_static({.predict = predict == 1});
      ASSERT_TRUE(result.converged()) << result.message();
      evaluations[predict] = result.evaluations;
    }
  }
  EXPECT_LE(evaluations[1], 1.5 * evaluations[0]);
}

/// With other tools a way has other numbers of estimates; what came before says nothing of them.
TEST(PredictedRest, ForgetsWaysOfOtherSizes) {
  RestChanges changes;
  changes.add(Eigen::Vector2d(1, 2), Eigen::Vector2d(1, 0));
  changes.add(Eigen::Vector3d(3, 4, 5), Eigen::Vector2d(0, 1));
  Eigen::VectorXd way;
  ASSERT_TRUE(changes.find(Eigen::Vector2d(0.5, 0.7), way));
  EXPECT_TRUE(way.isApprox(Eigen::Vector3d(2.1, 2.8, 3.5))) << way;
}

TEST(PredictedRest, ReturnsFromAStateThatWasBrokenSince) {
  constexpr double side = 0.02;
  constexpr int across = 3;
  Simulation sim(make_tetrahedral_block({side, side, side}, across, across, across, 0.2, 3), soft_tissue(0.45));
  sim.scene().fix("z0");
  for (const FailureState& failure : failure_states()) {
    for (int k = 0; k < 4; ++k) {
      sim.scene().gravity({0.1 * k, 0, -1});
      ASSERT_TRUE(sim.solve_static({.predict = true}).converged());
    }
    const State rest = sim.state();
    std::mt19937 bits(5);
    State broken = rest;
    failure.apply(broken.position, side, side / across, bits);
    sim.set_state(broken);
    const StaticResult result = sim.solve_static({.predict = true});
    ASSERT_TRUE(result.converged()) << failure.name << ": " << result.message();
    EXPECT_LT(largest_distance(sim.state().position, rest.position), 1e-4 * sim.max_displacement()) << failure.name;
  }
}

/// Tables keep the rows of what was removed.
TEST(RestGrid, HasTheTermsOfAParticleWhoseFirstDomainWasRemoved) {
  Model model = make_block({0.04, 0.02, 0.02}, 4, 2, 2);
  set_material(model, {1e4, 0.3, 1000.0});
  set_material(model, {2e4, 0.3, 1000.0}, [](const Vec3& place) { return place.x() > 0.02; });
  Simulation sim(std::move(model), {.backend = "reference"});
  const TopologyTextures& body = sim.solver().topology();
  const auto at =
      std::ranges::find_if(body.rest, [](const Vec3& x) { return (x - Vec3(0.02, 0.01, 0.01)).norm() < 1e-9; });
  const auto i = static_cast<Index>(at - body.rest.begin());
  sim.remove_cells(sim.model().cells_in([](const Vec3& place) { return place.x() > 0.01 && place.x() < 0.02; }));
  const auto left = [&](Index row) { return body.domains[body.first_domain[i] + row].link_count > 0; };
  ASSERT_TRUE(!left(0) && left(1));
  GridLevel level(body, {}, GridShape::over(body.rest, 0.02));
  const std::vector<Mat3> at_rest(body.domains.size(), Mat3::Zero());
  std::vector<Mat3> blocks(body.rest.size(), Mat3::Zero());
  blocks[i] = 1e3 * Mat3::Identity();  // N/m
  const double without = level.dense_stiffness(at_rest).trace();
  level.add_terms(body, blocks);
  EXPECT_GT(level.dense_stiffness(at_rest).trace(), without + 100.0);
}

}  // namespace
}  // namespace phymul::test
