// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "model/closed_surface.h"
#include "support/message_of.h"
#include "support/run_scenes.h"

namespace phymul {
namespace {

using namespace test;

using TriangleList = std::vector<std::array<Index, 3>>;
const TriangleList tetrahedron_faces = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};

/// By hand: the unit corner tetrahedron has 1/6, its gradient at the apex (0, 0, 1) is a third of the base's area, 1/6.
TEST(EnclosedVolume, OfATetrahedronByHand) {
  for (const Vec3& origin : {Vec3(0, 0, 0), Vec3(5, -7, 3)}) {
    VecList x{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    for (Vec3& p : x) p += origin;
    EXPECT_NEAR(enclosed_volume(tetrahedron_faces, x), 1.0 / 6.0, 1e-15);
    VecList gradient(4);
    volume_gradient(tetrahedron_faces, x, gradient);
    EXPECT_NEAR((gradient[3] - Vec3(0, 0, 1.0 / 6.0)).norm(), 0.0, 1e-15);
    EXPECT_NEAR((gradient[0] + Vec3(1, 1, 1) / 6.0).norm(), 0.0, 1e-15);
    EXPECT_NEAR(sum(gradient).norm(), 0.0, 1e-15);
    EXPECT_NEAR(torque(x, gradient).norm(), 0.0, 1e-15);
    // Grown by s about its corner all edges are 1 + s: V = (1 + s)^3 / 6.
    VecList along(4);
    for (int k = 0; k < 4; ++k) along[k] = x[k] - origin;
    const auto c = volume_along(tetrahedron_faces, x, along);
    EXPECT_NEAR(c[0], 0.5, 1e-14);
    EXPECT_NEAR(c[1], 0.5, 1e-14);
    EXPECT_NEAR(c[2], 1.0 / 6.0, 1e-14);
    EXPECT_NEAR(root_of_cubic(c, 7.0 / 6.0).value(), 1.0, 1e-14);          // twice as long: eight times the volume
    EXPECT_NEAR(root_of_cubic(c, -7.0 / 48.0).value(), -0.5, 1e-14);       // half as long: an eighth
    EXPECT_NEAR(root_of_cubic(c, -0.999999 / 6.0).value(), -0.99, 1e-10);  // a hundredth
  }
}

TEST(EnclosedVolume, TheCubicIsExactAlongAnyDirections) {
  std::mt19937 bits(4);
  for (int k = 0; k < 200; ++k) {
    VecList x(4), along(4), there(4);
    for (int i = 0; i < 4; ++i) {
      x[i] = random_vector(bits, 3);
      along[i] = random_vector(bits, 3);
    }
    const auto c = volume_along(tetrahedron_faces, x, along);
    const double s = 3.0 * uniform(bits);
    for (int i = 0; i < 4; ++i) there[i] = x[i] + s * along[i];
    const double grown = enclosed_volume(tetrahedron_faces, there) - enclosed_volume(tetrahedron_faces, x);
    EXPECT_NEAR(((c[2] * s + c[1]) * s + c[0]) * s, grown, 1e-12);
  }
}

TEST(EnclosedVolume, RootsAreTheNearestOnTheGrowingBranchOrNone) {
  EXPECT_EQ(root_of_cubic({1, 0, 0}, 0.0), 0.0);
  EXPECT_NEAR(root_of_cubic({2, 0, 0}, 3.0).value(), 1.5, 1e-15);
  EXPECT_NEAR(root_of_cubic({1, 1, 0}, 2.0).value(), 1.0, 1e-15);
  EXPECT_FALSE(root_of_cubic({1, 1, 0}, -0.3));  // s + s^2 is at least -1/4
  EXPECT_NEAR(root_of_cubic({1, 1, 0}, -0.2499999).value(), -0.5, 1e-3);
  EXPECT_FALSE(root_of_cubic({1, 0, -1.0 / 3.0}, 0.7));  // s - s^3 / 3 grows to 2/3 only
  EXPECT_NEAR(root_of_cubic({1, 0, -1.0 / 3.0}, 0.5).value(), 2.0 * std::sin(std::asin(0.75) / 3.0), 1e-14);
  EXPECT_NEAR(root_of_cubic({1e-30, 0, 1}, 8.0).value(), 2.0, 1e-14);
  EXPECT_NEAR(root_of_cubic({0.001, 1, -0.5}, 0.501).value(), 1.0, 1e-14);  // where the slope at 0 leads past the end
  EXPECT_NEAR(root_of_cubic({0.001, -1, -0.5}, -0.501).value(), -1.0, 1e-14);
  EXPECT_FALSE(root_of_cubic({0, 0, 0}, 1.0));  // nothing is free to move
  EXPECT_FALSE(root_of_cubic({-1, 0, 1}, 1.0));
  std::mt19937 bits(8);
  for (int k = 0; k < 1000; ++k) {
    const std::array<double, 3> c{1.0 + uniform(bits), 3.0 * uniform(bits), 3.0 * uniform(bits)};
    const double wanted = 2.0 * uniform(bits);
    const auto s = root_of_cubic(c, wanted);
    if (s) {
      EXPECT_NEAR(((c[2] * *s + c[1]) * *s + c[0]) * *s, wanted, 1e-14 * (1.0 + std::abs(wanted)));
    }
  }
}

/// A block without any volume term of its own (p = 0, stiffness in N/m).
Model soft_block() {
  Model model = make_block({0.03, 0.02, 0.02}, 6, 4, 4);
  for (double& k : model.stiffness) k = 5.0;
  for (double& m : model.mass) m = 1e-4;
  return model;
}

double relative_volume_error(const Scene& scene, const State& state) {
  const VolumeConstraint& kept = scene.volume_constraints().front();
  return std::abs(enclosed_volume(kept.triangles, state.position) / kept.volume - 1.0);
}

TEST(KeptVolume, IsThatOfTheCells) {
  const Model block = soft_block();
  Scene scene = Scene(block).constrain_volume();
  EXPECT_NEAR(scene.volume_constraints()[0].volume, 0.03 * 0.02 * 0.02, 1e-18);
  const Model ball = make_cylinder(0.01, 0.04, 3, 8, 10);
  Scene other = Scene(ball).constrain_volume();
  EXPECT_NEAR(other.volume_constraints()[0].volume, volume(ball, ball.rest), 1e-3 * volume(ball, ball.rest));
}

/// Squeezed to two thirds between moving ends, under gravity: exact at every step, where the body alone loses a good
/// deal.
TEST(KeptVolume, IsExactInASqueezedBodyUnderGravity) {
  const Model model = soft_block();
  for (const BackendCase& backend : cpu_backends) {
    double worst[2] = {0, 0};
    for (const bool kept : {false, true}) {
      Scene scene = Scene(model).gravity({0, 0, -9.81}).fix("x0"), measure = Scene(model).constrain_volume();
      if (kept) scene.constrain_volume();
      const auto solver = make_solver(backend.name, model, scene, {}, options_for(backend, 20.0));
      const double dt = 0.3 * solver->stable_step();
      scene.add(pull(model, "x1", {-1, 0, 0}, {{0, 0}, {1500 * dt, 0.01}}));
      for (int k = 0; k < 100; ++k) {
        ASSERT_TRUE(is_ok(solver->step(20, dt)));
        worst[kept] = std::max(worst[kept], relative_volume_error(measure, solver->read()));
      }
    }
    EXPECT_GT(worst[0], 0.02) << backend.name;
    EXPECT_LT(worst[1], std::string(backend.name) == "reference" ? 1e-12 : 1e-6) << backend.name;
  }
}

/// What a tool that was put into a body, or the parting of two, has moved without speed in the same step is made up
/// for too.
TEST(KeptVolume, IsExactWhereParticlesWereShifted) {
  const Model model = soft_block();
  for (const char* backend : {"reference", "cpu"}) {
    Scene scene = Scene(model).constrain_volume(), measure = scene.copy();
    scene.add_tool("probe", {.shape = Sphere{0.008}, .pose = {.position = {0.015, 0.010, 0.024}}});
    const auto solver = make_solver(backend, model, scene);
    ASSERT_TRUE(is_ok(solver->step(1, 0.3 * solver->stable_step())));
    const State state = solver->read();
    EXPECT_GT(solver->tool_force("probe").particles, 0) << backend;
    EXPECT_LT(state.position[model.group("z1")[17]].z(), 0.0195) << backend;  // m: under the sphere
    EXPECT_LT(relative_volume_error(measure, state), backend[0] == 'r' ? 1e-12 : 1e-6) << backend;
  }
}

/// The local term alone holds volume only as far as it is stiff.
TEST(KeptVolume, IsExactWhereTheLocalTermIsNot) {
  const Model model = with_material(make_block({0.03, 0.02, 0.02}, 6, 4, 4), soft_tissue(0.45));
  double worst[2] = {0, 0};
  for (const bool kept : {false, true}) {
    Scene scene = Scene(model).fix("x0"), measure = Scene(model).constrain_volume();
    if (kept) scene.constrain_volume();
    const auto solver = make_solver("reference", model, scene, {}, options_for({"reference", 0}, 20.0));
    const double dt = 0.3 * solver->stable_step();
    scene.add(pull(model, "x1", {-1, 0, 0}, {{0, 0}, {800 * dt, 0.006}}));
    for (int k = 0; k < 40; ++k) {
      ASSERT_TRUE(is_ok(solver->step(25, dt)));
      worst[kept] = std::max(worst[kept], relative_volume_error(measure, solver->read()));
    }
  }
  EXPECT_GT(worst[0], 1e-3);
  EXPECT_LT(worst[1], 1e-12);
}

/// Free in space, thrown, turning and out of shape: linear and angular momentum stay.
TEST(KeptVolume, KeepsLinearAndAngularMomentumOfAFreeBody) {
  const Model model = soft_block();
  Scene scene = Scene(model).constrain_volume();
  const auto solver = make_solver("reference", model, scene);
  State state = rest_state(model);
  std::mt19937 bits(9);
  double scale = 0.0, arm = 0.0;
  for (std::size_t i = 0; i < model.rest.size(); ++i) {
    state.velocity[i] = Vec3(0.3, -0.1, 0.2) + Vec3(0, 0, 20).cross(model.rest[i]) + 0.1 * random_vector(bits, 3);
    scale += model.mass[i] * state.velocity[i].norm();
    arm = std::max(arm, model.rest[i].norm());
  }
  solver->reset(state);
  const Momentum start = solver->momentum();
  const double dt = 0.2 * solver->stable_step();
  ASSERT_TRUE(solver->step(500, dt).ok());
  const Momentum end = solver->momentum();
  EXPECT_LT((end.linear - start.linear).norm(), 1e-13 * scale);
  EXPECT_LT((end.angular - start.angular).norm(), 1e-12 * scale * (arm + 500 * dt));
  EXPECT_LT(relative_volume_error(scene, solver->read()), 1e-12);
}

/// What is held stays, and the others make up for it; at rest is at rest.
TEST(KeptVolume, LeavesHeldParticlesAndComesToRest) {
  const Model model = soft_block();
  for (const BackendCase& backend : cpu_backends) {
    Scene scene = Scene(model).fix("x0").gravity({0, 0, -9.81}).constrain_volume();
    SolverOptions options = options_for(backend, 30.0);
    options.rest_tolerance = 1e-6;
    const auto solver = make_solver(backend.name, model, scene, {}, options);
    const RestResult rest = solver->run_to_rest(100000, 0.4 * solver->stable_step());
    EXPECT_TRUE(rest.converged()) << backend.name << ": " << rest.message();
    const State state = solver->read();
    for (const Index i : model.group("x0")) EXPECT_EQ(state.position[i], model.rest[i]);
    EXPECT_LT(relative_volume_error(scene, state), backend.threads == 0 ? 1e-12 : 1e-6);
  }
}

TEST(KeptVolume, BitsDoNotDependOnThreads) {
  const Model model = block_at(Vec3::Zero());
  State end[2];
  for (int threads : {1, 2}) {
    Scene scene = Scene(model).fix("x0").gravity({0, 0, -9.81}).constrain_volume();
    const auto solver = make_solver("cpu", model, scene, {}, options_for({"cpu", threads}));
    ASSERT_TRUE(solver->step(100, 0.4 * solver->stable_step()).ok());
    end[threads - 1] = solver->read();
  }
  EXPECT_EQ(end[0], end[1]);
}

TEST(KeptVolume, OfBodiesByName) {
  const Model one = soft_block(), two = moved(soft_block(), {0.1, 0, 0});
  const Model both = merged({{"one", &one}, {"two", &two}});
  Scene scene = Scene(both).gravity({0, 0, -9.81}).fix("one/x0").fix("two/x0").constrain_volume("two");
  const auto solver = make_solver("reference", both, scene);
  ASSERT_TRUE(solver->step(400, 0.3 * solver->stable_step()).ok());
  EXPECT_LT(relative_volume_error(scene, solver->read()), 1e-12);
  Scene measure = Scene(both).constrain_volume("one");
  EXPECT_GT(relative_volume_error(measure, solver->read()), 1e-6);
  EXPECT_TRUE(refuses([&] { scene.constrain_volume(); }, "belongs to another surface"));
}

/// Parting two bodies moves nothing that is imposed: a body held whole keeps its volume without any help.
TEST(KeptVolume, OfAHeldBodyIsNotLostWhereAnotherLiesInIt) {
  const Model held = soft_block(), free = moved(soft_block(), {0.0013, 0.0011, 0.0195});
  const Model both = merged({{"held", &held}, {"free", &free}});
  for (const char* backend : {"reference", "cpu"}) {
    Scene scene = Scene(both).fix("held").constrain_volume("held").contacts({});
    const auto solver = make_solver(backend, both, scene);
    EXPECT_TRUE(is_ok(solver->step(5, 0.3 * solver->stable_step())));
    EXPECT_GT(solver->read().position.back().z(), both.rest.back().z());  // parted
  }
}

TEST(KeptVolume, OfARegionIsThatOfTheCellsItLists) {
  Model row = make_block({0.03, 0.01, 0.01}, 3, 1, 1);
  row.add_group("ends", {});
  row.components.back().cell_refs = {0, 2};
  Scene scene(row);
  scene.constrain_volume("ends");
  EXPECT_NEAR(scene.volume_constraints().front().volume, 2e-6, 1e-15);
  EXPECT_EQ(scene.volume_constraints().front().triangles.size(), 24u);
}

TEST(KeptVolume, OpenSurfacesAreRefusedWithTheirEdge) {
  Model cup = make_tetrahedron(0.01);
  cup.cells = {{.type = CellType::triangle, .particles = {0, 1, 3}},
               {.type = CellType::triangle, .particles = {1, 2, 3}},
               {.type = CellType::triangle, .particles = {2, 0, 3}}};
  Scene scene(cup);
  EXPECT_EQ(message_of([&] { scene.constrain_volume(); }),
            "constrain_volume: expected a closed surface, but its edge from particle 0 to 1 is open (or its two "
            "triangles are "
            "wound against each other); add the missing facets");
  EXPECT_TRUE(scene.volume_constraints().empty());
  const Model flat = make_strip(0.02, 0.01, 2, 1);
  Scene plane(flat);
  EXPECT_TRUE(refuses([&] { plane.constrain_volume(); }, "three-dimensional"));
  VolumeConstraint wrong{{{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}}, -1.0, {}};
  EXPECT_TRUE(refuses([&] { scene.constrain_volume(wrong); }, "a volume above 0"));
  wrong.triangles[0][0] = 77;
  EXPECT_TRUE(refuses([&] { scene.constrain_volume(wrong); }, "got 77"));
}

TEST(KeptVolume, ThatCannotBeRestoredIsReported) {
  const Model model = soft_block();
  for (const BackendCase& backend : cpu_backends) {
    Scene scene = Scene(model).fix(every_particle(model)).constrain_volume();
    const auto solver = make_solver(backend.name, model, scene);
    const double dt = 0.3 * solver->stable_step();
    EXPECT_TRUE(solver->step(3, dt).ok());  // nothing is missing
    scene.add(pull(model, "x1", {1, 0, 0}, {{0, 0}, {3 * dt, 0}, {4 * dt, -0.001}}));
    const State before = solver->read();
    const StepReport report = solver->step(5, dt);
    EXPECT_EQ(report.status, StepStatus::volume_lost) << report.message();
    EXPECT_EQ(report.steps, 0);
    EXPECT_TRUE(says(report.message(), "all of them are held"));
    EXPECT_EQ(solver->read(), before);
  }
}

/// Held whole, by loads or by tools, and carried forty of its sizes away: rounding is no loss, what its ends lose is.
TEST(KeptVolume, OfWhatIsHeldWholeIsLostOnlyWhereItChanges) {
  const double size = 0.01;  // m
  const Model model = make_block(Vec3::Constant(size), 1, 2, 2);
  const Vec3 far = 40.0 * size * Vec3(0.6, -0.48, 0.64);
  for (const BackendCase& backend : cpu_backends) {
    for (const bool by_tools : {false, true}) {
      Scene scene = Scene(model).constrain_volume();
      const auto to = [&](const char* end, const Vec3& way) {
        const double x = end[1] == '0' ? 0.0 : size;
        if (by_tools) return scene.tool(end).move_to({.position = Vec3(x, 0.5 * size, 0.5 * size) + way});
        scene.replace(x > 0.0, pull(model, end, way, {{0, way.norm()}}));
      };
      for (const char* end : {"x0", "x1"}) {
        if (!by_tools) {
          scene.add(pull(model, end, far, {{0, 0}}));
          continue;
        }
        const Vec3 at(end[1] == '0' ? 0.0 : size, 0.5 * size, 0.5 * size);
        scene.add_tool(end, {.shape = Box{{0.1 * size, 0.6 * size, 0.6 * size}}, .pose = {.position = at}});
        scene.tool(end).grasp(0.0);
      }
      const auto solver = make_solver(backend.name, model, scene);
      const double dt = 0.3 * solver->stable_step();
      ASSERT_TRUE(solver->step(1, dt).ok());
      to("x0", far);
      for (const double lost : {0.0, 5e-5, 5e-4, 1e-2}) {
        to("x1", far - lost * size * Vec3::UnitX());
        const State before = solver->read();
        const StepReport report = solver->step(1, dt);
        SCOPED_TRACE(testing::Message() << backend.name << (by_tools ? ", tools, " : ", loads, ") << lost);
        EXPECT_EQ(report.status, lost < 1e-4 ? StepStatus::ok : StepStatus::volume_lost) << report.message();
        EXPECT_EQ(solver->read().position == before.position, !report.ok());
        EXPECT_LT((solver->read().position.front() - model.rest.front() - far).norm(), 1e-6 * far.norm());
      }
    }
  }
}

/// Also in a simulation, which reads a state before.
TEST(KeptVolume, PushesFullyInTheFirstStep) {
  const Model model = soft_block();
  Scene scene = Scene(model).constrain_volume();
  scene.set_fluid("volume 1", {.law = FluidLaw::gas, .outer_pressure = 1e4});
  scene.set_volume("volume 1", 1.05 * scene.volume_constraints()[0].volume);
  const VolumeConstraint gas = scene.volume_constraints()[0];
  const auto solver = make_solver("reference", model, scene);
  const double dt = 0.3 * solver->stable_step();
  solver->start(rest_state(model), dt);
  ASSERT_TRUE(solver->step(1, dt).ok());
  Simulation sim(model, {.backend = "reference"});
  sim.scene().constrain_volume(gas);
  ASSERT_TRUE(sim.step(1, dt).ok());
  const double way = displacement_norms(model, solver->read()).max;
  EXPECT_GT(way, 0.0);
  EXPECT_NEAR(sim.max_displacement(), way, 1e-9 * way);
}

/// The volumes of a replay are in the scene's order, also where some were removed and put in again.
TEST(KeptVolume, IsRecordedInOrder) {
  const Model a = soft_block(), b = moved(a, {0.1, 0, 0}), c = moved(a, {0.2, 0, 0});
  const Model all = merge_models(std::vector<NamedBody>{{"a", &a}, {"b", &b}, {"c", &c}});
  Scene scene = Scene(all).constrain_volume("a").constrain_volume("b").constrain_volume("c");
  const std::vector<VolumeConstraint> kept = scene.volume_constraints();
  const auto recorded = make_solver("reference", all, scene);
  Recorder recorder(*recorded, scene);
  const double dt = 0.3 * recorded->stable_step();
  for (const std::vector<int>& rows : {std::vector<int>{1}, {0, 2}, {1, 0}}) {
    recorder.step(2, dt);
    for (const int row : rows) {
      scene.remove_volume(kept[row].name);
      scene.constrain_volume(kept[row]);
    }
    recorder.step(2, dt);
    recorder.checkpoint();
    Scene again(all);
    const auto replayed = make_solver("reference", all, again);
    EXPECT_EQ(message_of([&] { Replay(recorder.recording(), *replayed, again).run(); }), "(no error)");
    EXPECT_EQ(replayed->snapshot(), recorded->snapshot());
  }
}

}  // namespace
}  // namespace phymul
