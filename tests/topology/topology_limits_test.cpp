// SPDX-License-Identifier: MIT
//
// Bodies at the edge of what tables can be made of: repeated, flat and inside-out cells, sparse particles, materials.
#include <gtest/gtest.h>

#include <limits>
#include <numeric>

#include "support/bodies.h"
#include "support/message_of.h"
#include "topology/base_selection.h"
#include "topology/corner_simplices.h"

namespace phymul::test {
namespace {

bool says(const std::string& text, const char* part) {
  return text.find(part) != std::string::npos;
}

Model with_first_cell_twice() {
  Model model = make_tetrahedral_block({0.02, 0.02, 0.02}, 2, 2, 2, 0.1, 1);
  model.cells.push_back(model.cells.front());
  return model;
}

TEST(TopologyLimits, ARepeatedCellAddsStiffnessButNoBase) {
  const Model twice = with_first_cell_twice();
  Model once = twice;
  once.cells.pop_back();
  TopologyOptions options;
  options.bases = BaseSelection::opposite_faces;
  EXPECT_EQ(build_topology(twice, options).base_count, build_topology(once, options).base_count);

  Model tissue = twice, single = once;
  set_material(tissue, soft_tissue());
  set_material(single, soft_tissue());
  const TopologyTextures t = build_topology(tissue), s = build_topology(single);
  ASSERT_EQ(t.base_count, s.base_count);
  for (Index i = 0; i < t.particle_count; ++i) {
    const auto& cell = tissue.cells.front().particles;
    const bool in_it = std::find(cell.begin(), cell.end(), i) != cell.end();
    EXPECT_EQ(t.stiffness[i] > 1.001 * s.stiffness[i], in_it) << "particle " << i;
  }
}

TEST(TopologyLimits, PairsThatAllButCoincideAreNoBase) {
  for (const double scale : {1e-6, 1.0}) {
    const Vec3 x(0, scale, 0), a(scale, 0, 0);
    EXPECT_FALSE(has_plane(rest_pair(x, a, a + Vec3(1e-11 * scale, 0, 0))));
    EXPECT_TRUE(has_plane(rest_pair(x, a, a + Vec3(1e-6 * scale, 0, 0))));
  }
}

TEST(TopologyLimits, ParticlesOutsideTheMaterialTakeNoSprings) {
  Model model = make_block({0.02, 0.02, 0.02}, 2, 2, 2);
  model.rest.push_back({0.05, 0, 0});
  model.mass.push_back(1.0);
  model.stiffness.push_back(3.0);
  const Index near[] = {2, 5};
  model.neighbours.push_row(near, near + 2);
  set_material(model, soft_tissue());
  TopologyOptions options;
  options.on_sparse = SparseParticle::springs;
  EXPECT_TRUE(says(message_of([&] { build_topology(model, options); }),
                   "particle 27 is in no cell that has a material, and springs would need a stiffness"));
  options.on_sparse = SparseParticle::free;
  EXPECT_TRUE(build_topology(model, options).springs.empty());
}

TEST(TopologyLimits, AMaterialNeedsThreeDimensions) {
  Model strip = make_strip(0.02, 0.02, 2, 2);
  set_material(strip, soft_tissue());
  EXPECT_TRUE(says(message_of([&] { build_topology(strip); }), "a material needs a three-dimensional model"));
}

TEST(TopologyLimits, CalibrationTakesFiniteConstantsAndGivesNoNegativeOnes) {
  const double infinity = std::numeric_limits<double>::infinity();
  EXPECT_TRUE(says(message_of([&] {
                     calibrate({infinity, 0.3, 1000}, PoissonRoute::volume_term);
                   }),
                   "Young's modulus is inf"));
  for (double young = 1.0; young < 1e6; young *= 1.01) {
    EXPECT_GE(calibrate({young, -0.375, 1000}, PoissonRoute::volume_term).kappa, 0.0) << young;
  }
}

TEST(TopologyLimits, TetrahedraHaveOneVolumeTermEach) {
  Model mesh = make_tetrahedral_block({0.02, 0.02, 0.02}, 2, 2, 2, 0.1, 1);
  set_material(mesh, soft_tissue());
  TopologyOptions options;
  options.cell_average = 0.9;
  const TopologyTextures t = build_topology(mesh, options);
  EXPECT_EQ(t.cells.size(), mesh.cells.size());
  EXPECT_TRUE(t.volumes.empty());
}

TEST(TopologyLimits, TetrahedraWithTheAreaExponentTakeFittedBases) {
  Model mesh = make_tetrahedral_block({0.02, 0.02, 0.02}, 2, 2, 2, 0.1, 1), block = make_block({1, 1, 1}, 2, 2, 2);
  set_material(mesh, soft_tissue());
  set_material(block, soft_tissue());
  TopologyOptions options;
  options.poisson_route = PoissonRoute::area_exponent;
  EXPECT_EQ(build_topology(mesh, options).options.bases, BaseSelection::fitted);
  EXPECT_EQ(build_topology(block, options).options.bases, BaseSelection::opposite_faces);
}

TEST(CornerSimplices, FlatCornersAreLeftOutAndInsideOutOnesRefused) {
  Model flat = make_block({1, 1, 1}, 1, 1, 1);
  const std::vector<Index> ring = flat.cells[0].particles;
  // The ring's second corner lies on the line between its neighbours: no volume there, and none lost by it.
  flat.rest[ring[1]] = (flat.rest[ring[0]] + flat.rest[ring[2]]) / 2;
  flat.rest[ring[5]] = (flat.rest[ring[4]] + flat.rest[ring[6]]) / 2;
  const std::vector<CornerSimplex> corners = corner_simplices(flat, 0);
  EXPECT_EQ(corners.size(), 6u);
  double sum = 0.0;
  for (const CornerSimplex& corner : corners) sum += corner.share;
  EXPECT_NEAR(sum, cell_volume(flat, flat.cells[0]), 1e-12);
  // Past that line the corner looks inward while the cell as a whole does not.
  flat.rest[ring[1]] += 0.1 * (flat.rest[ring[3]] - flat.rest[ring[1]]);
  ASSERT_GT(cell_volume(flat, flat.cells[0]), 0.0);
  EXPECT_TRUE(says(message_of([&] { corner_simplices(flat, 0); }), "is inside out at rest"));
}

TEST(CornerSimplices, ACellWithoutVolumeIsRefused) {
  Model flat = make_tetrahedron(1.0);
  flat.rest[3] = flat.rest[0];
  EXPECT_TRUE(says(message_of([&] { corner_simplices(flat, 0); }), "is inside out at rest"));
}

}  // namespace
}  // namespace phymul::test
