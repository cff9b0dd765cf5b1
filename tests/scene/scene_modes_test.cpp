// SPDX-License-Identifier: MIT
//
// Scene::modes says the same as Scene::evaluate.
#include <phymul/load_frame.h>
#include <phymul/scene.h>
#include <phymul/shapes.h>

#include <gtest/gtest.h>
#include <utility>

#include "support/bodies.h"
#include "support/scene_parts.h"

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

}  // namespace

}  // namespace phymul::test
