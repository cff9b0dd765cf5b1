// SPDX-License-Identifier: MIT
//
// Scene::modes says the same as Scene::evaluate.
#include <gtest/gtest.h>
#include <phymul/load_frame.h>

#include "support/bodies.h"

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

}  // namespace
}  // namespace phymul::test
