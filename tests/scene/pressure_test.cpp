// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>
#include <phymul/scene.h>
#include <phymul/shapes.h>

#include <utility>

#include "support/scene_parts.h"

namespace phymul {
namespace {

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
}  // namespace phymul
