// SPDX-License-Identifier: MIT
#include "topology/base_selection.h"
#include "model/file_extras.h"

#include <gtest/gtest.h>

#include <set>

#include "support/bodies.h"
#include "support/message_of.h"
#include "topology/topology_terms.h"

namespace phymul::test {
namespace {

TopologyOptions selecting(BaseSelection bases) {
  return {.bases = bases};
}

Index inner_particle(const Model& block) {
  Index best = 0;
  for (Index i = 0; i < block.particle_count(); ++i) {
    if (block.neighbours.size(i) > block.neighbours.size(best)) best = i;
  }
  return best;
}

TEST(BaseGeometry, TriangleUnderAPoint) {
  const RestBase base = rest_triangle({0.25, 0.5, 3.0}, {0, 0, 1}, {1, 0, 1}, {0, 1, 1});
  EXPECT_DOUBLE_EQ(base.beta, 2.0);
  EXPECT_DOUBLE_EQ(base.lambda[0], 0.25);
  EXPECT_DOUBLE_EQ(base.lambda[1], 0.25);
  EXPECT_DOUBLE_EQ(base.lambda[2], 0.5);
  EXPECT_DOUBLE_EQ(base.area, 1.0);
  EXPECT_DOUBLE_EQ(base.quality, 0.5);
  EXPECT_EQ(base.normal, Vec3(0, 0, 1));
}

TEST(BaseGeometry, PairInThePlane) {
  const RestBase base = rest_pair({0.5, 3.0, 0}, {0, 1, 0}, {2, 1, 0});
  EXPECT_DOUBLE_EQ(base.beta, 2.0);
  EXPECT_DOUBLE_EQ(base.lambda[0], 0.75);
  EXPECT_DOUBLE_EQ(base.lambda[1], 0.25);
  EXPECT_EQ(base.lambda[2], 0.0);
  EXPECT_EQ(base.normal, Vec3(0, 1, 0));  // left of the direction of travel
  EXPECT_FALSE(has_plane(rest_pair({0, 1, 0}, {2, 2, 0}, {2, 2, 0})));
}

TEST(BaseGeometry, CollinearityIsJudgedAgainstTheBaseItself) {
  for (double scale : {1e-9, 1.0, 1e6}) {
    const Vec3 a(0, 0, 0), b(scale, 0, 0);
    EXPECT_FALSE(has_plane(rest_triangle({0, 0, scale}, a, b, {2 * scale, 0, 0})));
    EXPECT_FALSE(has_plane(rest_triangle({0, 0, scale}, a, b, {2 * scale, 1e-12 * scale, 0})));
    EXPECT_TRUE(has_plane(rest_triangle({0, 0, scale}, a, b, {2 * scale, 1e-6 * scale, 0})));
    EXPECT_FALSE(has_plane(rest_triangle({0, 0, scale}, a, a, b)));
  }
}

TEST(BaseSelection, CountsOfALattice) {
  // C(n, 3) less those on a line through the neighbourhood.
  const int triples[3][3] = {{6, 20, 20}, {18, 816, 804}, {26, 2600, 2564}};
  for (const auto& [valence, candidates, with_plane] : triples) {
    const Model block = make_block({4, 4, 4}, 4, 4, 4, valence);
    const Index centre = inner_particle(block);
    ASSERT_EQ(block.neighbours.size(centre), valence);
    EXPECT_EQ(neighbour_bases(block, centre, selecting(BaseSelection::all)).size(),
              static_cast<std::size_t>(with_plane))
        << valence << ", of " << candidates;
  }
}

TEST(BaseSelection, LexicographicInNeighbourPlaces) {
  const Model block = make_block({3, 3, 3}, 3, 3, 3, 18);
  const Index centre = inner_particle(block);
  const Index* row = block.neighbours.begin(centre);
  std::array<std::ptrdiff_t, 3> last{-1, -1, -1};
  for (const RestBase& base : neighbour_bases(block, centre, {})) {
    std::array<std::ptrdiff_t, 3> place{};
    for (std::size_t k = 0; k < 3; ++k) place[k] = std::find(row, block.neighbours.end(centre), base.vertex[k]) - row;
    EXPECT_LT(place[0], place[1]);
    EXPECT_LT(place[1], place[2]);
    EXPECT_LT(last, place);
    last = place;
  }
}

TEST(BaseSelection, ThinTriplesAreRejectedAndCounted) {
  const Model body = jittered_block();
  TopologyOptions options;
  std::size_t all = 0, kept = 0;
  for (Index i = 0; i < body.particle_count(); ++i) {
    all += neighbour_bases(body, i, selecting(BaseSelection::all)).size();
    for (const RestBase& base : neighbour_bases(body, i, options)) {
      ++kept;
      EXPECT_GE(base.quality, 0.05 * (1 - 1e-8));
      for (double lambda : base.lambda) EXPECT_LE(std::abs(lambda), 1.25 * (1 + 1e-8));
    }
  }
  EXPECT_LT(kept, all);
  options.min_quality = 0.0;
  options.max_barycentric = 1e9;
  EXPECT_EQ(build_topology(body, options).base_count, build_topology(body, selecting(BaseSelection::all)).base_count);
}

TEST(BaseSelection, EqualNeighbourhoodsKeepEqualSets) {
  const Model block = make_block({0.3, 0.3, 0.3}, 6, 6, 6, 26);  // steps that doubles do not hold exactly
  std::set<std::size_t> counts;
  for (Index i = 0; i < block.particle_count(); ++i) {
    if (block.neighbours.size(i) == 26) counts.insert(neighbour_bases(block, i, {}).size());
  }
  EXPECT_EQ(counts.size(), 1u);
}

TEST(CornerSimplices, SharesSumToTheCell) {
  for (const Body& body : bodies()) {
    if (body.model.dimension == 2) continue;
    for (Index row = 0; row < static_cast<Index>(body.model.cells.size()); ++row) {
      double sum = 0.0;
      for (const CornerSimplex& corner : corner_simplices(body.model, row)) sum += corner.share;
      const double volume = cell_volume(body.model, body.model.cells[row]);
      EXPECT_NEAR(sum, volume, 1e-12 * volume);
    }
  }
}

TEST(CornerSimplices, MirroredCellIsNamed) {
  Model block = make_block({1, 1, 1}, 2, 1, 1);
  std::swap_ranges(block.cells[1].particles.begin(), block.cells[1].particles.begin() + 4,
                   block.cells[1].particles.begin() + 4);
  EXPECT_TRUE(refuses([&] { corner_simplices(block); }, "cell 1 (HEXAHEDRON) is inside out"));
  change_extras(block, [](FileExtras& extras) { extras.cell_index = {-1, 77}; });
  EXPECT_TRUE(refuses([&] { corner_simplices(block); }, "cell 1 (HEXAHEDRON, file index 77)"));
}

}  // namespace
}  // namespace phymul::test
