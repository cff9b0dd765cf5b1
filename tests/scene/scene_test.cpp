// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>
#include <phymul/phymul.h>

#include <Eigen/Geometry>
#include <limits>
#include <memory>
#include <numbers>
#include <type_traits>

#include "support/joined_particles.h"
#include "support/message_of.h"

namespace phymul {
namespace {

using namespace test;

constexpr double pi = std::numbers::pi;

TEST(ValueAt, IsLinearBetweenHeldAfterAndZeroBefore) {
  const std::vector<ValueEvent> events{{1.0, 2.0}, {3.0, 6.0}};
  EXPECT_EQ(value_at(events, 0.999), 0.0);
  EXPECT_EQ(value_at(events, 1.0), 2.0);
  EXPECT_DOUBLE_EQ(value_at(events, 1.5), 3.0);
  EXPECT_EQ(value_at(events, 3.0), 6.0);
  EXPECT_EQ(value_at(events, 1e9), 6.0);
  EXPECT_EQ(value_at({}, 1.0), 0.0);
}

TEST(ValueAt, TwoEventsOnOneDateAreAStep) {
  const std::vector<ValueEvent> events{{0.0, 0.0}, {1.0, 4.0}, {1.0, -2.0}, {2.0, 0.0}};
  EXPECT_DOUBLE_EQ(value_at(events, 0.5), 2.0);
  EXPECT_NEAR(value_at(events, 1.0 - 1e-12), 4.0, 1e-10);
  EXPECT_EQ(value_at(events, 1.0), -2.0);
  EXPECT_DOUBLE_EQ(value_at(events, 1.5), -1.0);
}

TEST(Scene, PaysOnlyForWhatItHolds) {
  const Model model = make_block({1, 1, 1}, 2, 2, 2);
  Scene scene(model);
  const auto sizes = [&] {
    const LoadFrame frame = at(scene, 0.0);
    return std::array<std::size_t, 3>{frame.force.size(), frame.fixed.size(), frame.target.size()};
  };
  using Sizes = std::array<std::size_t, 3>;
  EXPECT_EQ(sizes(), (Sizes{0, 0, 0}));
  scene.gravity({0, 0, -9.81});
  EXPECT_EQ(sizes(), (Sizes{0, 0, 0}));
  scene.add(made(LoadType::force, {}, {0, 0, 1}, 1.0));
  EXPECT_EQ(sizes(), (Sizes{0, 0, 0}));
  scene.add(made(LoadType::force, {3}, {0, 0, 1}, 1.0));
  EXPECT_EQ(sizes(), (Sizes{27, 0, 0}));
  scene.fix("x0");
  EXPECT_EQ(sizes(), (Sizes{27, 27, 27}));
  scene.clear();
  EXPECT_EQ(sizes(), (Sizes{0, 0, 0}));
  EXPECT_EQ(scene.gravity(), Vec3(0, 0, 0));
}

TEST(Scene, FixHoldsAtTheRestPlaceForEver) {
  const Model model = make_block({1, 1, 1}, 2, 2, 2);
  Scene scene(model);
  const std::vector<Index> listed{5};
  scene.fix("x0").fix(listed);
  for (const double time : {-1.0, 0.0, 1e6}) {
    const LoadFrame frame = at(scene, time);
    for (Index i = 0; i < model.particle_count(); ++i) {
      EXPECT_EQ(frame.fixed[i], i % 3 == 0 || i == 5 ? 7 : 0);
      EXPECT_EQ(frame.target[i], model.rest[i]);
    }
  }
  EXPECT_EQ(scene.loads()[0].applied_to, "x0");
}

TEST(Scene, TranslationDrivesHoldsAndLeavesFree) {
  const Model model = make_block({1, 1, 1}, 2, 2, 2);
  Scene scene(model);
  Load load = made(LoadType::translation, {4, 7}, {9.0, 0.0, 5.0}, 0.0);
  load.axes = {Axis::free, Axis::held, Axis::driven};  // the 9 belongs to a free axis: u is (0, 0, 1)
  load.events = {{1.0, 0.0}, {2.0, 0.1}};
  scene.add(load);
  const LoadFrame before = at(scene, 0.5), half = at(scene, 1.5);
  EXPECT_EQ(before.fixed[4], 6);
  EXPECT_EQ(before.fixed[5], 0);
  EXPECT_EQ(before.target[4], model.rest[4]);
  expect_near(half.target[4], model.rest[4] + Vec3(0, 0, 0.05));
  expect_near(half.target[7], model.rest[7] + Vec3(0, 0, 0.05));
  load = made(LoadType::translation, {4}, {0.0, 3.0, 4.0}, 0.5);
  scene.clear().add(load);
  EXPECT_EQ(at(scene, 0.0).fixed[4], 7);
  expect_near(at(scene, 0.0).target[4], model.rest[4] + Vec3(0, 0.3, 0.4));
}

TEST(Scene, TowardPointsFromEachRestPlace) {
  const Model model = make_block({2, 2, 2}, 2, 2, 2);
  Scene scene(model);
  Load load = made(LoadType::translation, {12, 14, 13}, {0, 0, 0}, 0.25);
  load.toward = 13;  // the middle
  scene.add(load);
  load.type = LoadType::force;
  load.particles = {0};
  scene.add(load);
  const LoadFrame frame = at(scene, 1.0);
  expect_near(frame.target[12], Vec3(0.25, 1, 1));
  expect_near(frame.target[14], Vec3(1.75, 1, 1));
  expect_near(frame.target[13], Vec3(1, 1, 1));
  expect_near(frame.force[0], 0.25 * Vec3(1, 1, 1).normalized());
}

TEST(Scene, RotationTurnsAboutTheCentroid) {
  const Model model = make_block({2, 2, 2}, 2, 2, 2);
  Scene scene(model);
  Load load = made(LoadType::rotation, model.group("z1"), {0, 0, 2}, 0.0);
  load.axes = {Axis::free, Axis::free, Axis::driven};
  load.events = {{0.0, 0.0}, {1.0, pi / 2}};
  scene.add(load);
  const LoadFrame start = at(scene, 0.0), end = at(scene, 1.0);
  for (const Index i : model.group("z1")) {
    EXPECT_EQ(start.target[i], model.rest[i]);
    EXPECT_EQ(end.fixed[i], 7);
    const Vec3 from = model.rest[i] - Vec3(1, 1, 2);
    expect_near(end.target[i], Vec3(1 - from.y(), 1 + from.x(), 2));
  }
  EXPECT_EQ(end.fixed[0], 0);
  load.axes.fill(Axis::driven);
  load.toward = 0;  // about the line from the side's middle to the origin: a full turn comes back
  load.events = {{0.0, 2 * pi}};
  scene.clear().add(load);
  for (const Index i : model.group("z1")) expect_near(at(scene, 0.0).target[i], model.rest[i], 1e-14);
  load.events = {{0.0, pi}};
  scene.clear().add(load);
  const Vec3 u = Vec3(-1, -1, -2).normalized(), from = model.rest[18] - Vec3(1, 1, 2);
  expect_near(at(scene, 0.0).target[18], Vec3(1, 1, 2) + 2 * u * u.dot(from) - from);
}

TEST(Scene, ForcesAddUp) {
  const Model model = make_block({1, 1, 1}, 2, 2, 2);
  Scene scene(model);
  scene.add({made(LoadType::force, {1, 2, 2}, {0, 0, 5}, 3.0), made(LoadType::force, {2}, {1, 0, 0}, -1.0)});
  const LoadFrame frame = at(scene, 0.0);
  expect_near(frame.force[1], Vec3(0, 0, 3));
  expect_near(frame.force[2], Vec3(-1, 0, 3));
  expect_near(total_of(frame.force), Vec3(-1, 0, 6));
}

TEST(Scene, AccelerationIsMassTimesValue) {
  Model model = make_block({1, 1, 1}, 2, 2, 2);
  for (Index i = 0; i < model.particle_count(); ++i) model.mass[i] = 1.0 + i;
  Scene scene = Scene(model).add(made(LoadType::acceleration, {2, 6}, {0, -1, 0}, 4.0));
  expect_near(at(scene, 0.0).force[2], Vec3(0, -12, 0));
  expect_near(at(scene, 0.0).force[6], Vec3(0, -28, 0));
  // The whole body along one direction is gravity, and needs no forces.
  std::vector<Index> all(27);
  for (Index i = 0; i < 27; ++i) all[i] = i;
  scene.clear().gravity({1, 0, 0}).add(made(LoadType::acceleration, all, {0, 0, -2}, 9.81));
  const LoadFrame frame = at(scene, 0.0);
  EXPECT_TRUE(frame.force.empty());
  expect_near(frame.gravity, Vec3(1, 0, -9.81));
  Load toward = made(LoadType::acceleration, all, {0, 0, 0}, 2.0);
  toward.toward = 13;
  scene.clear().add(toward);
  expect_near(at(scene, 0.0).force[12], 13 * 2.0 * Vec3(1, 0, 0));
  EXPECT_EQ(at(scene, 0.0).force[13], Vec3(0, 0, 0));
}

TEST(Scene, TheLaterImposingLoadHolds) {
  const Model model = make_block({1, 1, 1}, 2, 2, 2);
  Load lift = made(LoadType::translation, {0, 1}, {0, 0, 1}, 0.2);
  lift.axes = {Axis::free, Axis::free, Axis::driven};
  const Load shift = made(LoadType::translation, {1, 2}, {1, 0, 0}, 0.3);
  Scene scene = Scene(model).add({shift, lift});
  LoadFrame frame = at(scene, 0.0);
  EXPECT_EQ(frame.fixed[0], 4);  // imposed beats free, free does not loosen
  EXPECT_EQ(frame.fixed[1], 7);
  expect_near(frame.target[1], model.rest[1] + Vec3(0.3, 0, 0.2));
  scene.clear().add({lift, shift});
  frame = at(scene, 0.0);
  EXPECT_EQ(frame.fixed[1], 7);
  expect_near(frame.target[1], model.rest[1] + Vec3(0.3, 0, 0));
  expect_near(frame.target[0], model.rest[0] + Vec3(0, 0, 0.2));
}

TEST(Scene, VersionGrowsByOneAtEveryChange) {
  const Model model = make_block({1, 1, 1}, 2, 2, 2);
  Scene scene(model);
  const Load load = made(LoadType::force, {0}, {1, 0, 0}, 1.0);
  std::uint64_t version = scene.version();
  const auto grown = [&] { return scene.version() == ++version; };
  scene.fix("x0");
  EXPECT_TRUE(grown());
  scene.gravity({0, 0, -1});
  EXPECT_TRUE(grown());
  scene.add(load);
  EXPECT_TRUE(grown());
  scene.add({load, load});
  EXPECT_TRUE(grown());
  scene.replace(3, made(LoadType::force, {0}, {0, 1, 0}, 5.0));
  EXPECT_TRUE(grown());
  expect_near(at(scene, 0.0).force[0], Vec3(2, 5, 0));
  scene.remove(1);
  EXPECT_TRUE(grown());
  EXPECT_EQ(scene.loads().size(), 3u);
  expect_near(at(scene, 0.0).force[0], Vec3(1, 5, 0));
  scene.clear();
  EXPECT_TRUE(grown());
  EXPECT_TRUE(scene.loads().empty());
}

TEST(Scene, EventsAreSortedStably) {
  const Model model = make_tetrahedron(1.0);
  Load load = made(LoadType::force, {0}, {1, 0, 0}, 0.0);
  load.events = {{2.0, 1.0}, {1.0, 5.0}, {2.0, 3.0}, {0.0, 7.0}};
  Scene scene = Scene(model).add(load);
  const std::vector<ValueEvent> expected{{0.0, 7.0}, {1.0, 5.0}, {2.0, 1.0}, {2.0, 3.0}};
  EXPECT_EQ(scene.loads()[0].events, expected);
  scene.replace(0, load);
  EXPECT_EQ(scene.loads()[0].events, expected);
}

TEST(Scene, NewEventsLeaveTheRestAsItWas) {
  const Model model = make_tetrahedron(1.0);
  Scene scene = Scene(model).add(made(LoadType::force, {0}, {1, 0, 0}, 5.0));
  Load idle = made(LoadType::force, {1}, {0, 0, 0}, 0.0);
  scene.add(idle);
  const std::uint64_t version = scene.version(), values = scene.values_version();
  scene.set_events(0, std::vector<ValueEvent>{{1.0, 4.0}, {0.0, 2.0}});
  EXPECT_EQ(scene.version(), version);
  EXPECT_EQ(scene.values_version(), values + 1);
  expect_near(at(scene, 0.5).force[0], Vec3(3, 0, 0));
  const std::vector<Load> before = scene.loads();
  EXPECT_TRUE(refuses([&] { scene.set_events(2, before[0].events); }, "row of one of 2 loads, got 2"));
  EXPECT_TRUE(refuses([&] { scene.set_events(0, {}); }, "at least one value"));
  EXPECT_THROW(scene.set_events(0, std::vector<ValueEvent>{{0.0, INFINITY}}), Error);
  EXPECT_TRUE(refuses([&] { scene.set_events(1, std::vector<ValueEvent>{{0.0, 1.0}}); }, "not zero"));
  EXPECT_EQ(scene.loads(), before);
  EXPECT_EQ(scene.values_version(), values + 1);
}

TEST(Scene, RefusesWhatMakesNoSenseAndStaysAsItWas) {
  const Model model = make_block({1, 1, 1}, 2, 2, 2);
  Scene scene = Scene(model).gravity({0, 0, -9.81}).fix("z0");
  const std::uint64_t version = scene.version();
  const std::vector<Load> loads = scene.loads();
  const Load good = made(LoadType::force, {0}, {1, 0, 0}, 1.0);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto refused = [&](const char* text, auto change) {
    Load load = good;
    load.applied_to = "needle";
    change(load);
    EXPECT_TRUE(refuses([&] { scene.add(std::vector<Load>{good, load}); }, text));
    EXPECT_THROW(scene.replace(0, load), Error) << text;
  };
  refused("force on \"needle\": expected particles from 0 to 26, got 27", [](Load& l) { l.particles = {3, 27}; });
  refused("got -1", [](Load& l) { l.particles = {-1}; });
  refused("point toward from 0 to 26 (or -1 for none), got 30", [](Load& l) { l.toward = 30; });
  refused("point toward", [](Load& l) { l.toward = -2; });
  refused("at least one value", [](Load& l) { l.events.clear(); });
  refused("finite dates and values, got value nan at date 0", [&](Load& l) { l.events[0].value = nan; });
  refused("finite dates and values", [&](Load& l) { l.events.push_back({INFINITY, 1.0}); });
  refused("expected a finite direction", [&](Load& l) { l.direction.y() = nan; });
  refused("a direction that is not zero", [](Load& l) { l.direction.setZero(); });
  refused("a direction that is not zero", [](Load& l) { l.axes = {Axis::held, Axis::driven, Axis::driven}; });
  refused("expected an axis", [](Load& l) {
    l.type = LoadType::rotation;
    l.direction.setZero();
    l.events[0].value = 0.0;
  });
  refused("lies at the centroid", [](Load& l) {
    l.type = LoadType::rotation;
    l.particles = {12, 14};
    l.toward = 13;
  });
  refused("no facet has all of its particles", [](Load& l) {
    l.type = LoadType::pressure;
    l.particles = {0, 1, 3};
  });
  EXPECT_TRUE(refuses([&] { scene.fix("liver"); }, "\"x0\""));
  EXPECT_THROW(scene.fix(std::vector<Index>{99}), Error);
  EXPECT_THROW(scene.gravity({0, nan, 0}), Error);
  EXPECT_TRUE(refuses([&] { scene.remove(1); }, "row of one of 1 loads, got 1"));
  EXPECT_THROW(scene.replace(1, good), Error);
  EXPECT_EQ(scene.version(), version);
  EXPECT_EQ(scene.loads(), loads);
  EXPECT_EQ(scene.gravity(), Vec3(0, 0, -9.81));
  EXPECT_TRUE(at(scene, 0.0).force.empty());
}

TEST(Scene, ZeroDirectionIsAllowedWhereNothingMoves) {
  const Model model = make_block({1, 1, 1}, 2, 2, 2);
  Scene scene = Scene(model).add(made(LoadType::translation, {3}, {0, 0, 0}, 0.0));
  EXPECT_EQ(at(scene, 0.0).fixed[3], 7);
  EXPECT_EQ(at(scene, 0.0).target[3], model.rest[3]);
}

TEST(Scene, StaysInThePlaneOfATwoDimensionalModel) {
  const Model strip = make_strip(2, 1, 2, 2);
  Scene scene(strip);
  EXPECT_TRUE(refuses([&] { scene.gravity({0, 0, -9.81}); }, "two-dimensional"));
  EXPECT_TRUE(refuses([&] { scene.add(made(LoadType::force, {0}, {0, 1, 1}, 1.0)); }, "direction with z = 0"));
  EXPECT_TRUE(refuses([&] { scene.add(made(LoadType::rotation, {0, 1}, {1, 0, 0}, 1.0)); }, "an axis along z"));
  scene.gravity({0, -9.81, 0}).add(made(LoadType::rotation, strip.group("x1"), {0, 0, 1}, pi / 2)).fix("x0");
  const LoadFrame frame = at(scene, 0.0);
  expect_near(frame.target[2], Vec3(2.5, 0.5, 0));
}

TEST(Scene, TakesNoTemporaryModel) {
  EXPECT_TRUE((std::is_constructible_v<Scene, const Model&>));
  EXPECT_FALSE((std::is_constructible_v<Scene, Model>));
}

// What owns a scene and its solver must not compile as something to move.
static_assert(!std::is_move_constructible_v<Scene> && !std::is_constructible_v<Scene, Scene&>);
static_assert(!std::is_assignable_v<Scene&, Scene> && !std::is_assignable_v<Scene&, const Scene&>);
struct SceneAndSolver {
  Scene scene;
  std::unique_ptr<int> solver;
};
static_assert(!std::is_move_constructible_v<SceneAndSolver>);

TEST(Scene, CopiesAreIndependent) {
  const Model model = make_block({1, 1, 1}, 1, 1, 1);
  Scene scene = Scene(model).fix("x0").gravity({0, 0, -1});
  const auto ball = scene.add_tool("ball", {.shape = Sphere{0.1}});
  const Scene other = scene.copy();
  ball.move_to({.position = {1, 2, 3}});
  EXPECT_EQ(scene.loads().size(), 1u);
  EXPECT_EQ(scene.tools().front().pose.position, Vec3(1, 2, 3));
  EXPECT_EQ(other.loads(), scene.loads());
  EXPECT_EQ(other.tools().front().pose.position, Vec3(0, 0, 0));
}

TEST(Scene, RefusesAModelThatIsNotOne) {
  Model model = make_block({1, 1, 1}, 1, 1, 1);
  model.mass.clear();
  EXPECT_THROW(Scene{model}, Error);
  model = make_block({1, 1, 1}, 1, 1, 1);
  model.components.back().particles.push_back(8);
  EXPECT_THROW(Scene{model}, Error);
}

TEST(Scene, EvaluatingLeavesNoTraceOfTheInstantBefore) {
  const Model model = make_block({1, 1, 1}, 2, 2, 2);
  Load lift = made(LoadType::translation, model.group("z1"), {0, 0, 1}, 0.0), push = lift;
  lift.events = {{0.0, 0.0}, {1.0, 1.0}, {2.0, 0.0}};
  push.type = LoadType::force;
  push.events = lift.events;
  Load more = push;
  more.particles = {0, 18, 20};
  Scene scene = Scene(model).add({lift, push, more});
  LoadFrame frame;
  scene.prepare(frame);
  for (const double time : {0.3, 1.7, 0.9, 5.0, -1.0}) {
    scene.evaluate(time, frame);
    const LoadFrame fresh = at(scene, time);
    EXPECT_EQ(frame.force, fresh.force);
    EXPECT_EQ(frame.target, fresh.target);
    EXPECT_EQ(frame.fixed, fresh.fixed);
    EXPECT_EQ(frame.gravity, fresh.gravity);
  }
}

TEST(SceneOwnership, SharesOwnershipOfItsModel) {
  auto model = std::make_shared<const Model>(make_block({1, 1, 1}, 1, 1, 1));
  const std::weak_ptr<const Model> watched = model;
  auto scene = std::make_unique<Scene>(std::move(model));
  const Scene copy = scene->copy();
  scene.reset();
  ASSERT_FALSE(watched.expired());
  EXPECT_EQ(copy.model().particle_count(), 8);
  EXPECT_TRUE(refuses([] { Scene(std::shared_ptr<const Model>()); }, "got null"));
}

TEST(SceneOwnership, GivesToolsNamesAndHandles) {
  const Model model = make_block({1, 1, 1}, 1, 1, 1);
  Scene scene(model);
  const ToolHandle ball = scene.add_tool(Sphere{0.1});
  const ToolHandle rod = scene.add_tool({.shape = Capsule{0.1, 0.2}, .friction = 0.5});
  rod.move_to({.position = {1, 2, 3}});
  EXPECT_EQ(scene.tools().at(0).name, "tool 1");
  EXPECT_EQ(scene.tools().at(1).name, "tool 2");
  EXPECT_EQ(scene.tool("tool 2").target_pose().position, Vec3(1, 2, 3));
  EXPECT_NE(ball.id(), rod.id());
  EXPECT_TRUE(ball.is_of(scene));
  const auto probe = scene.add_tool("probe", {.shape = Sphere{0.1}});
  const auto rope = scene.add_joint("rope", {.springs = {{at_particle(0), at_world({0, 0, 1})}}});
  EXPECT_EQ(probe.id(), scene.tool("probe").id());
  EXPECT_EQ(rope.id(), scene.joint("rope").id());
}

}  // namespace
}  // namespace phymul
