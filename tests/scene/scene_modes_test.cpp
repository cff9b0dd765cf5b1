// SPDX-License-Identifier: MIT
//
// Scene::modes says the same as Scene::evaluate. What a scene accepts as a joint, and what it says of what it refuses.
#include <gtest/gtest.h>
#include <phymul/load_frame.h>
#include <phymul/phymul.h>

#include <limits>
#include <utility>

#include "support/bodies.h"
#include "support/joined_particles.h"
#include "support/message_of.h"
#include "support/outside_backend.h"

namespace phymul::test {
namespace {

Load load_of(LoadType type, std::vector<Index> particles, const Vec3& direction) {
  return {.type = type, .particles = std::move(particles), .events = {{0.0, 0.1}, {1.0, 0.7}}, .direction = direction};
}

TEST(SceneModes, SumToWhatEvaluateSays) {
  const Model model = make_block({0.03, 0.02, 0.02}, 3, 2, 2);
  Scene scene = Scene(model).fix("x0").gravity({0, 1, -9.81});
  scene.add(load_of(LoadType::rotation, model.group("x1"), {1, 2, 3}));
  scene.add(load_of(LoadType::force, model.group("y1"), {1, 0, 1}));
  scene.add(load_of(LoadType::force, model.group("z1"), {0, 1, 0}));
  scene.add(load_of(LoadType::pressure, model.group("z1"), {0, 0, 0}));
  scene.add(load_of(LoadType::acceleration, every_particle(model), {0, 0, 1}));
  Load slide = load_of(LoadType::translation, model.group("x1"), {0, 1, 0});
  slide.axes = {Axis::free, Axis::driven, Axis::held};  // over the rotation, on two axes
  scene.add(slide);

  const LoadModes modes = scene.modes();
  ASSERT_EQ(modes.fixed.size(), model.rest.size());
  LoadFrame frame;
  scene.prepare(frame);
  EXPECT_EQ(modes.fixed, frame.fixed);
  std::vector<double> value(static_cast<std::size_t>(modes.count));
  for (const double time : {0.0, 0.4, 2.0}) {
    scene.evaluate(time, frame);
    scene.mode_values(time, value);
    Vec3 gravity = modes.gravity;
    for (const LoadModes::Part& part : modes.acceleration) gravity += value[part.mode] * part.vector;
    EXPECT_LE((gravity - frame.gravity).norm(), 1e-14);
    for (Index i = 0; i < model.particle_count(); ++i) {
      Vec3 target = model.rest[i], force = Vec3::Zero();
      for (Index r = modes.target_offset[i]; r < modes.target_offset[i + 1]; ++r) {
        target += value[modes.target[r].mode] * modes.target[r].vector;
      }
      for (Index r = modes.force_offset[i]; r < modes.force_offset[i + 1]; ++r) {
        force += value[modes.force[r].mode] * modes.force[r].vector;
      }
      EXPECT_LE((target - frame.target[i]).norm(), 1e-15) << i;
      EXPECT_LE((force - frame.force[i]).norm(), 1e-14) << i;
    }
  }
}

TEST(SceneModes, ALoadWithoutAnAxisImposesNothing) {
  const Model model = make_tetrahedron(0.01);
  Scene scene(model);
  Load load = load_of(LoadType::translation, {0, 3}, {0, 1, 0});
  load.axes.fill(Axis::free);
  scene.add(load);
  const LoadModes modes = scene.modes();
  EXPECT_TRUE(modes.fixed.empty() && modes.target_offset.empty() && modes.target.empty());
}

TEST(SceneModes, HoldNothingThatDoesNotAct) {
  const Model model = make_tetrahedron(0.01);
  Scene scene(model);
  const LoadModes empty = scene.modes();
  EXPECT_EQ(empty.count, 0);
  EXPECT_TRUE(empty.fixed.empty() && empty.target_offset.empty() && empty.force_offset.empty());
  const std::vector<Index> first{0};
  scene.fix(first);
  const LoadModes fixed = scene.modes();
  EXPECT_EQ(fixed.target_offset, std::vector<Index>(5, 0));  // held at rest: no part
  EXPECT_EQ(fixed.fixed[0], 7);
  EXPECT_TRUE(fixed.force_offset.empty());
}

TEST(Pressure, PushesInwardOnTheSurfaceAlone) {
  for (const Model& model : {make_block({1, 2, 3}, 2, 3, 4), make_tetrahedral_block({1, 2, 3}, 2, 3, 4, 0.2, 5)}) {
    Scene scene = Scene(model).add(made(LoadType::pressure, model.group("x1"), {0, 0, 0}, 100.0));
    expect_near(total_of(at(scene, 0.0).force), Vec3(-600, 0, 0), 1e-10);
    Load directed = made(LoadType::pressure, model.group("x1"), {0, 0, 3}, 100.0);
    scene.clear().add(directed);
    expect_near(total_of(at(scene, 0.0).force), Vec3(0, 0, 600), 1e-10);
    // All particles: the closed surface pushes with no sum, and nothing pushes inside.
    std::vector<Index> all(model.rest.size());
    for (std::size_t i = 0; i < all.size(); ++i) all[i] = static_cast<Index>(i);
    scene.clear().add(made(LoadType::pressure, all, {0, 0, 0}, 100.0));
    const LoadFrame frame = at(scene, 0.0);
    expect_near(total_of(frame.force), Vec3(0, 0, 0), 1e-10);
    double work = 0.0;
    for (Index i = 0; i < model.particle_count(); ++i) {
      const Vec3& x = model.rest[i];
      const bool inside = x.minCoeff() > 0 && x.x() < 1 && x.y() < 2 && x.z() < 3;
      if (inside) {
        EXPECT_EQ(frame.force[i], Vec3(0, 0, 0));
      }
      work += frame.force[i].dot(x);
    }
    // p times the surface integral of -n.x is -3 p V.
    EXPECT_NEAR(work, -3 * 100.0 * 6.0, 1e-9) << model.name;
  }
}

TEST(Pressure, SharesAFacetEvenly) {
  const Model model = make_block({1, 1, 1}, 2, 2, 2);
  Scene scene = Scene(model).add(made(LoadType::pressure, model.group("z1"), {0, 0, 0}, 8.0));
  const LoadFrame frame = at(scene, 0.0);
  expect_near(frame.force[18], Vec3(0, 0, -0.5));  // corner: a quarter of one facet of 1/4 m^2
  expect_near(frame.force[19], Vec3(0, 0, -1.0));
  expect_near(frame.force[22], Vec3(0, 0, -2.0));
  EXPECT_EQ(frame.force[13], Vec3(0, 0, 0));
}

TEST(Pressure, IsInwardForMirroredCellsToo) {
  Model model = make_block({1, 1, 1}, 1, 1, 1);
  std::swap(model.cells[0].particles[0], model.cells[0].particles[2]);
  std::swap(model.cells[0].particles[4], model.cells[0].particles[6]);
  Scene scene = Scene(model).add(made(LoadType::pressure, model.group("y0"), {0, 0, 0}, 1.0));
  expect_near(total_of(at(scene, 0.0).force), Vec3(0, 1, 0));
}

TEST(Pressure, OnASurfaceModelAndInThePlane) {
  Model shell = make_block({1, 1, 1}, 1, 1, 1);
  const std::vector<Index> top{4, 5, 7, 6};
  shell.cells[0].type = CellType::quad;
  shell.cells[0].particles = top;
  Scene scene = Scene(shell).add(made(LoadType::pressure, top, {0, 0, 0}, 3.0));
  expect_near(total_of(at(scene, 0.0).force), Vec3(0, 0, -3));
  expect_near(at(scene, 0.0).force[4], Vec3(0, 0, -0.75));

  Model strip = make_strip(2, 1, 4, 2);
  Scene plane = Scene(strip).add(made(LoadType::pressure, strip.group("y1"), {0, 0, 0}, 3.0));
  expect_near(total_of(at(plane, 0.0).force), Vec3(0, -6, 0));
  std::vector<Cell> lines(1);
  lines[0].type = CellType::line;
  lines[0].particles = {0, 4};  // along +x, the outside on its right: below
  strip.cells = lines;
  strip.components.clear();
  Scene line = Scene(strip).add(made(LoadType::pressure, {0, 4}, {0, 0, 0}, 3.0));
  expect_near(total_of(at(line, 0.0).force), Vec3(0, 6, 0));
}

class JointsOfAScene : public testing::Test {
 protected:
  Joint one(JointSpring spring) const { return {.springs = {std::move(spring)}, .stiffness = 1.0}; }
  testing::AssertionResult refuses_joint(const Joint& joint, std::string_view part) {
    const std::uint64_t version = scene_.version();
    const testing::AssertionResult result = refuses([&] { scene_.add_joint("j", joint); }, part);
    EXPECT_EQ(scene_.version(), version) << "the scene stays as it was";
    return result;
  }
  const Model model_ = with_material(make_block({0.02, 0.02, 0.02}, 2, 2, 2));
  Scene scene_{model_};
};

TEST_F(JointsOfAScene, AndToolsGetNamesThatNoneHas) {
  scene_.add_joint("joint 2", one({at_particle(0), at_particle(1)}));
  scene_.add_tool("tool 2", {.shape = Sphere{0.01}});
  for (const std::string number : {"3", "4"}) {
    scene_.add_joint(one({at_particle(0), at_particle(2)}));
    EXPECT_EQ(scene_.joints().back().name, "joint " + number);
    scene_.add_tool(Sphere{0.01});
    EXPECT_EQ(scene_.tools().back().name, "tool " + number);
  }
}

TEST_F(JointsOfAScene, RefusesAnchorsThatDoNotFit) {
  const Anchor here = at_particle(3), there = at_world({0, 0, 1});
  EXPECT_TRUE(refuses_joint({}, "joint \"j\": expected at least one spring, got none"));
  EXPECT_TRUE(refuses_joint(one({at_particle(27), there}), "spring 0: expected particles from 0 to 26, got 27"));
  EXPECT_TRUE(refuses_joint(one({here, at_particle(-1)}), "expected particles from 0 to 26, got -1"));
  EXPECT_TRUE(refuses_joint(one({there, at_world({0, 0, 2})}), "got two at the world or at tools"));
  EXPECT_TRUE(refuses_joint(one({here, here}), "expected two different anchors, got the same one twice"));
  EXPECT_TRUE(refuses_joint(one({{.particles = {1, 2}, .weights = {0.5, 0.6}}, there}), "got a sum of 1.1"));
  EXPECT_TRUE(refuses_joint(one({{.particles = {1, 2}, .weights = {1.0}}, there}), "a weight for each of 2"));
  EXPECT_TRUE(refuses_joint(one({{.particles = {1, 1}, .weights = {0.5, 0.5}}, there}), "got one twice"));
  EXPECT_TRUE(refuses_joint(one({{.particles = {}, .weights = {1.0}}, here}), "expected particles for an anchor's"));
  EXPECT_TRUE(refuses_joint(one({{.particles = {1}, .weights = {1.0}, .tool = "t"}, there}), "got both"));
  EXPECT_TRUE(refuses_joint(one({here, at_tool("probe")}), "the scene has no tool \"probe\""));
  EXPECT_TRUE(refuses_joint(one({here, at_world({0, 0, std::nan("")})}), "expected a finite point"));
  EXPECT_TRUE(refuses([] { at_mean({}); }, "at_mean: expected at least one particle, got none"));
  EXPECT_TRUE(refuses([] { at_tool(""); }, "at_tool: expected a tool's name"));
}

TEST_F(JointsOfAScene, RefusesConstantsOutOfTheirRange) {
  const JointSpring good{at_particle(3), at_world({0, 0, 1})};
  Joint joint = one(good);
  joint.stiffness = -1.0;
  EXPECT_TRUE(refuses_joint(joint, "expected a finite stiffness, 0 or more; got -1"));
  joint = one(good);
  joint.damping = std::numeric_limits<double>::infinity();
  EXPECT_TRUE(refuses_joint(joint, "expected a finite damping"));
  joint = one(good);
  joint.breaking_force = 0.0;
  EXPECT_TRUE(refuses_joint(joint, "expected a breaking force above 0, got 0"));
  EXPECT_TRUE(refuses_joint(one({good.a, good.b, 0.1, 0.0}), "expected a finite share above 0, got 0"));
  EXPECT_TRUE(refuses_joint(one({good.a, good.b, std::nan("")}), "expected a finite rest length"));
  EXPECT_TRUE(refuses([&] { scene_.add_joint("", one(good)); }, "expected a name, got an empty one"));
  EXPECT_TRUE(refuses([&] { scene_.add_joint("j", one(good), VecList(3)); }, "expected 27 positions, or none; got 3"));
  scene_.add_joint("j", one(good));
  EXPECT_TRUE(refuses_joint(one(good), "joint \"j\": there is one of that name"));
  const JointHandle handle = scene_.joint("j");
  EXPECT_TRUE(refuses([&] { handle.set_stiffness(-1.0, 0.0); }, "expected a finite stiffness"));
  EXPECT_TRUE(refuses([&] { handle.set_rest_length(-1.0); }, "expected a finite rest length"));
  EXPECT_TRUE(refuses([&] { handle.set_rest_lengths(std::vector{1.0, 2.0}); }, "for each of 1 springs, got 2"));
}

TEST_F(JointsOfAScene, GivesRestLengthsAndNames) {
  const JointHandle first = scene_.add_joint({at_particle(0), at_world({0, 0, -0.5})}, 2.0);
  EXPECT_EQ(first.joint().springs[0].rest_length, 0.5);
  VecList moved = model_.rest;
  moved[0].z() = 0.25;
  scene_.add_joint("late", one({at_particle(0), at_world({0, 0, -0.5})}), moved);
  EXPECT_EQ(scene_.joint("late").joint().springs[0].rest_length, 0.75);
  scene_.add_tool({.shape = Sphere{0.01}, .pose = {.position = {0, 0, 3}, .orientation = {0, 1, 0, 0}}});
  const JointHandle third = scene_.add_joint({at_particle(0), at_tool("tool 1", {0, 0, 1})}, 2.0);
  EXPECT_EQ(third.joint().springs[0].rest_length, 2.0) << "the tool is upside down";
  EXPECT_EQ(scene_.joints()[2].name, "joint 3");

  EXPECT_TRUE(refuses([&] { scene_.remove_tool("tool 1"); }, "the joint \"joint 3\" has an anchor at it"));
  EXPECT_TRUE(refuses([&] { scene_.remove_joint("none"); }, "no joint \"none\"; it has: joint 1, late, joint 3"));
  scene_.remove_joint("joint 3").remove_tool("tool 1");
  EXPECT_TRUE(refuses([&] { third.joint(); }, "no longer has the joint of this handle"));
  EXPECT_EQ(scene_.joints().size(), 2u);
  scene_.clear();
  EXPECT_TRUE(scene_.joints().empty());
}

TEST_F(JointsOfAScene, TakeTheirLengthFromThePositionsThatArePassed) {
  VecList moved_up = model_.rest;
  for (Vec3& x : moved_up) x.z() += 0.5;
  const JointSpring spring{at_particle(26), at_world(model_.rest[26])};
  const auto length = [](const JointHandle& joint) { return joint.joint().springs[0].rest_length; };
  EXPECT_EQ(length(scene_.add_joint(spring, 5.0)), 0.0);
  EXPECT_EQ(length(scene_.add_joint(spring, 5.0, 0.1, moved_up)), 0.5);
  EXPECT_EQ(length(scene_.add_joint(Joint{.springs = {spring}, .stiffness = 5.0, .breaking_force = 1.0}, moved_up)),
            0.5);
}

TEST_F(JointsOfAScene, RefusesPatchesThatDoNotFit) {
  const Attachment springs{.stiffness = 1e5};
  const std::vector<Index> top = model_.group("z1");
  const VecList flat(3, Vec3::Zero());
  const auto patch_of = [&](const std::vector<Index>& patch) {
    return [&] { scene_.attach(patch, World{}, springs); };
  };
  EXPECT_TRUE(refuses(patch_of({}), "attach: expected particles of the surface, got none"));
  EXPECT_TRUE(refuses(patch_of({27}), "expected particles from 0 to 26, got 27"));
  EXPECT_TRUE(refuses(patch_of({0, 1}), "expected particles that span facets of the surface"));
  EXPECT_TRUE(refuses([&] { scene_.attach(top, "bone", springs); }, "\"bone\""));
  EXPECT_TRUE(refuses([&] { scene_.attach(top, "z1", springs); }, "particle 18 belongs to it"));
  EXPECT_TRUE(refuses([&] { scene_.attach(top, World{}, {.stiffness = -2.0}); }, "expected a finite stiffness"));
  EXPECT_TRUE(refuses([&] { scene_.attach(top, World{}, {.position = flat}); }, "expected 27 positions"));
  Scene other(model_);
  const ToolHandle tool = other.add_tool(Sphere{0.01});
  EXPECT_TRUE(refuses([&] { scene_.attach(top, tool, springs); }, "expected a tool of this scene"));
  EXPECT_TRUE(scene_.joints().empty());
}

TEST_F(JointsOfAScene, APatchTakesEachOfItsParticlesOnce) {
  std::vector<Index> top = model_.group("z1");
  const std::size_t once = scene_.attach(top, World{}, {.stiffness = 1e5}).joint().springs.size();
  EXPECT_EQ(once, 9u);
  top.insert(top.end(), top.begin(), top.end());
  EXPECT_EQ(scene_.attach(top, World{}, {.stiffness = 1e5}).joint().springs.size(), once);
}

/// Glued where the bodies are, and not where they were at rest: the springs have no force there.
TEST_F(JointsOfAScene, GlueTakesThePositionsThatArePassed) {
  const Model upper = moved(model_, {0, 0, 0.021});
  const Model both = merged({{"lower", &model_}, {"upper", &upper}});
  VecList now = both.rest;
  for (const Index i : both.group("upper")) now[i] = both.rest[i] + Vec3(0.003, -0.002, 0.004);
  for (const Index i : both.group("lower")) now[i] = both.rest[i] + Vec3(0.001, 0.001, 0.005);
  Scene scene(both);
  scene.attach(both.group("upper/z0"), "lower", {.stiffness = 1e5, .position = now});
  for (const JointSpring& spring : scene.joints().front().joint.springs) {
    Vec3 partner = Vec3::Zero();
    for (std::size_t k = 0; k < spring.b.particles.size(); ++k) {
      partner += spring.b.weights[k] * now[spring.b.particles[k]];
    }
    EXPECT_LT((partner - now[spring.a.particles.front()]).norm(), 1e-12);
  }
}

TEST_F(JointsOfAScene, RefusesGlueThatIsTooFar) {
  const Model upper = moved(model_, {0, 0, 0.035});
  const Model both = merged({{"lower", &model_}, {"upper", &upper}});
  Scene scene(both);
  const auto glue = [&] { scene.attach(both.group("upper/z0"), "lower", {.stiffness = 1e5}); };
  EXPECT_TRUE(refuses(glue, "within one cell of \"lower\": Skin: point 0"));
  const auto to_a_side = [&] { scene.attach(both.group("upper/z0"), "lower/z1", {.stiffness = 1e5}); };
  EXPECT_TRUE(refuses(to_a_side, "no cell has all its particles in \"lower/z1\""));
}

TEST_F(JointsOfAScene, GlueHoldsAtTheCellsThatARegionLists) {
  const Model row = make_block({0.03, 0.01, 0.01}, 3, 1, 1);
  const Model cube = moved(make_block({0.006, 0.01, 0.01}, 1, 1, 1), {0.012, 0, 0.01});
  const NamedBody bodies[] = {{"row", &row}, {"cube", &cube}};
  Model both = merge_models(bodies);
  both.add_group("ends", {});
  both.components.back().cell_refs = {0, 2};
  Scene scene(both);
  scene.attach(both.group("cube/z0"), "ends", {.stiffness = 1e5});
  for (const JointSpring& spring : scene.joints().front().joint.springs) {
    const std::vector<Index>& partners = spring.b.particles;
    EXPECT_TRUE(partners == both.cells[0].particles || partners == both.cells[2].particles);
  }
}

TEST_F(JointsOfAScene, AreRefusedByWhatDoesNotKnowThem) {
  Simulation sim(model_, {.backend = "reference"});
  sim.scene().fix("z0").add_joint("rope", one({at_particle(20), at_world({0, 0, 1})}));
  EXPECT_TRUE(refuses([&] { sim.solver().joint_report("none"); }, "no joint \"none\""));
  Scene other(model_);
  const JointHandle foreign = other.add_joint({at_particle(20), at_world({0, 0, 1})}, 1.0);
  EXPECT_TRUE(refuses([&] { sim.report_of(foreign); }, "joint of another scene"));
}

TEST_F(JointsOfAScene, AreRefusedByBackendsThatDoNotTakeThem) {
  scene_.add_joint("rope", one({at_particle(20), at_world({0, 0, 1})}));
  const auto topology = std::make_shared<const TopologyTextures>(build_topology(model_));
  EXPECT_TRUE(refuses([&] { OutsideBackend(topology, scene_); }, "the scene has joints"));
  Scene later(model_);
  OutsideBackend solver(topology, later);
  later.add_joint("rope", one({at_particle(20), at_world({0, 0, 1})}));
  const StepReport report = solver.step(1, 0.5 * solver.stable_step());
  EXPECT_EQ(report.status, StepStatus::not_supported);
  EXPECT_TRUE(says(report.message(), "the scene has joints"));
}

}  // namespace
}  // namespace phymul::test
