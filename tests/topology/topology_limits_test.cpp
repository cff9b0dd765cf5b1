// SPDX-License-Identifier: MIT
//
// Bodies at the edge of what tables can be made of: repeated, flat and inside-out cells, sparse particles, materials.
#include <gtest/gtest.h>

#include "support/bodies.h"
#include "support/message_of.h"
#include "topology/base_selection.h"
#include "topology/corner_simplices.h"

namespace phymul::test {
namespace {

Model with_first_cell_twice() {
  Model model = make_tetrahedral_block({0.02, 0.02, 0.02}, 2, 2, 2, 0.1, 1);
  model.cells.push_back(model.cells.front());
  return model;
}

TEST(TopologyLimits, ARepeatedCellAddsVolume) {
  const auto domains = [](Model model) {
    set_material(model, soft_tissue());
    return build_topology(model).domains;
  };
  Model once = with_first_cell_twice();
  const std::vector<Index> cell = once.cells.front().particles;
  const std::vector<DomainTexel> t = domains(once);
  once.cells.pop_back();
  const std::vector<DomainTexel> s = domains(once);
  ASSERT_EQ(t.size(), s.size());
  for (std::size_t d = 0; d < t.size(); ++d) {
    const bool in_it = std::ranges::find(cell, t[d].particle) != cell.end();
    EXPECT_EQ(t[d].inverse_volume < 0.999 * s[d].inverse_volume, in_it) << "particle " << t[d].particle;
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
  add_particle(model, {0.05, 0, 0}, {2, 5}, 3.0);
  set_material(model, soft_tissue());
  TopologyOptions options{.on_sparse = SparseParticle::springs};
  EXPECT_TRUE(refuses([&] { build_topology(model, options); },
                      "particle 27 is in no cell that has a material, and springs would need a stiffness"));
  options.on_sparse = SparseParticle::free;
  EXPECT_TRUE(build_topology(model, options).springs.empty());
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
  EXPECT_TRUE(refuses([&] { corner_simplices(flat, 0); }, "is inside out at rest"));
}

TEST(CornerSimplices, ACellWithoutVolumeIsRefused) {
  Model flat = make_tetrahedron(1.0);
  flat.rest[3] = flat.rest[0];
  EXPECT_TRUE(refuses([&] { corner_simplices(flat, 0); }, "is inside out at rest"));
}

}  // namespace
}  // namespace phymul::test
