// SPDX-License-Identifier: MIT
//
// Domains that lie alike share their constants, and these are the ones that each would have alone.
#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "elastic/scaled_tables.h"
#include "model/file_extras.h"
#include "support/bodies.h"
#include "support/message_of.h"
#include "topology/body_frames.h"
#include "topology/neighbourhoods.h"
#include "topology/topology_terms.h"

namespace phymul::test {
namespace {

std::size_t links_of_all_domains(const TopologyTextures& t) {
  std::size_t sum = 0;
  for (const DomainTexel& domain : t.domains) sum += static_cast<std::size_t>(domain.link_count);
  return sum;
}

/// A bar of two materials, of hexahedra.
Model two_materials() {
  Model bar = make_block({0.08, 0.04, 0.04}, 8, 4, 4);
  set_material(bar, {.young = 1e4, .poisson = 0.45, .density = 1000.0});
  set_material(bar, {.young = 5e4, .poisson = 0.3, .density = 1200.0},
               [](const Vec3& place) { return place.x() > 0.05; });
  return bar;
}

/// Per axis a domain is at the surface, beside one that is, or neither, on two sides: five places.
TEST(AlikeDomains, OfALatticeShareTheirLinks) {
  for (const int cells : {8, 16}) {
    const double side = 0.01 * cells;
    const TopologyTextures t = build_topology(with_material(make_block(Vec3::Constant(side), cells, cells, cells)));
    EXPECT_LE(t.links.size(), 125u * 26u);
    EXPECT_GT(links_of_all_domains(t), 4 * t.links.size());
  }
}

/// Each particle is moved by up to a thousand-millionth of the spacing, so that no two domains are alike.
TEST(AlikeDomains, HaveTheConstantsOfDomainsThatShareNothing) {
  const std::vector<Body> bodies{
      {"lattice", with_material(make_block({0.07, 0.06, 0.05}, 7, 6, 5))},
      {"two materials", two_materials()},
      {"pyramids", with_material(cut_into_pyramids(make_block({0.04, 0.03, 0.03}, 4, 3, 3)))},
      {"plane", with_material(make_strip(0.05, 0.03, 5, 3))}};
  for (const Body& body : bodies) {
    Model moved = body.model;
    jitter(moved, 1e-9, 7);
    TopologyOptions options;
    const TopologyTextures shared = build_topology(body.model, options);
    options.stabiliser = shared.options.stabiliser;
    const TopologyTextures own = build_topology(moved, options), with_same_s = build_topology(body.model, options);
    EXPECT_EQ(own.links.size(), links_of_all_domains(own)) << body.name;
    EXPECT_LT(with_same_s.links.size(), links_of_all_domains(own)) << body.name;
    ASSERT_EQ(with_same_s.domains.size(), own.domains.size());
    for (Index d = 0; d < static_cast<Index>(own.domains.size()); ++d) {
      const auto these = with_same_s.links_of(d), those = own.links_of(d);
      ASSERT_EQ(these.size(), those.size()) << body.name << ", domain " << d;
      ASSERT_NEAR(with_same_s.domains[d].inverse_volume, own.domains[d].inverse_volume,
                  1e-7 * own.domains[d].inverse_volume);
      double area = 0.0, stiffness = 0.0;
      for (const LinkTexel& link : those) {
        area = std::max(area, link.area.norm());
        stiffness = std::max(stiffness, std::abs(link.stiffness));
      }
      for (std::size_t k = 0; k < those.size(); ++k) {
        ASSERT_EQ(these[k].offset, those[k].offset) << body.name << ", domain " << d;
        ASSERT_LE((these[k].area - those[k].area).norm(), 1e-7 * area) << body.name << ", domain " << d;
        ASSERT_NEAR(these[k].stiffness, those[k].stiffness, 1e-7 * stiffness) << body.name << ", domain " << d;
      }
    }
  }
}

/// Materials that differ in density alone have equal links; a factor of one must not reach the other's.
TEST(AlikeDomains, OfTwoMaterialsShareNoLinks) {
  Model model = make_block({8, 8, 8}, 8, 8, 8);
  const Material one{.young = 1e4, .poisson = 0.3, .density = 1000.0};
  Material other = one;
  other.density = 1100.0;
  set_material(model, one);
  set_material(model, other, [](const Vec3& p) {
    return (static_cast<int>(p.x()) + static_cast<int>(p.y()) + static_cast<int>(p.z())) % 2 == 0;
  });
  const TopologyTextures t = build_topology(model);
  jitter(model, 0.02, 3);
  const std::vector<double> factors{1.0, 10.0};
  VecList wanted(t.rest.size()), found(t.rest.size());
  elastic_forces(t, model.rest, wanted, factors);
  ScaledTables scaled;
  elastic_forces(scaled.of(t, factors), model.rest, found);
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    ASSERT_LE((found[i] - wanted[i]).norm(), 1e-12 * largest_norm(wanted)) << i;
  }
}

/// Coordinates are rounded to 1e-9 of a cell there, so that most domains which should be alike are not.
TEST(AlikeDomains, LeaveNothingInsideFarFromTheOrigin) {
  Model block = make_block({0.06, 0.06, 0.06}, 6, 6, 6);
  for (Vec3& place : block.rest) place += Vec3(1e5 + 0.1, -2e5 - 0.3, 5e4 + 0.7);
  const TopologyTextures t = build_topology(with_material(block));
  for (Index i = 0; i < t.particle_count; ++i) {
    const Vec3 in_block = block.rest[i] - block.rest.front();
    const bool inside = in_block.minCoeff() > 0.005 && in_block.maxCoeff() < 0.055;
    EXPECT_EQ(t.domains[i].surface_link_count > 0, !inside) << i;
  }
}

// That what is calibrated on a body depends on nothing but the body.

/// However a body is turned, and beside whatever other.
TEST(BodyFrames, TheStabiliserIsTheBodysOwn) {
  const Mat3 turn = Eigen::AngleAxisd(1.1, Vec3(1, 2, 3).normalized()).toRotationMatrix();
  for (const Model& shape : {make_block({0.03, 0.02, 0.02}, 3, 2, 2), make_block({0.04, 0.04, 0.04}, 4, 4, 4),
                             make_tetrahedral_block({0.08, 0.02, 0.02}, 12, 3, 3, 0.2, 3),
                             make_cylinder(0.01, 0.04, 3, 8, 11), make_strip(0.04, 0.02, 4, 2)}) {
    const Model model = with_material(shape);
    const double alone = *build_topology(model).options.stabiliser;
    Model turned = model;
    for (Vec3& p : turned.rest) {
      p = shape.dimension == 2 ? Vec3(0.6 * p.x() - 0.8 * p.y(), 0.8 * p.x() + 0.6 * p.y(), 0.0) : Vec3(turn * p);
    }
    EXPECT_NEAR(*build_topology(turned).options.stabiliser, alone, 2e-6);
    Model other = with_material(make_block({0.03, 0.01, 0.02}, 9, 2, 5));
    if (shape.dimension == 2) continue;
    const std::vector<NamedBody> both{{"one", &model}, {"other", &other}};
    const TopologyTextures tables = build_topology(merge_models(both));
    const TopologyTextures own = build_topology(model);
    for (std::size_t d = 0; d < own.domains.size(); ++d) {
      ASSERT_NEAR(tables.domains[d].spread_stiffness, own.domains[d].spread_stiffness,
                  1e-9 * own.domains[d].spread_stiffness);
    }
  }
}

/// A bar that lies slanted, and a cube's lattice, whose moments tell nothing.
TEST(BodyFrames, AxesLieAsTheBodyDoes) {
  const Mat3 turn = Eigen::AngleAxisd(0.6, Vec3(1, -2, 0.5).normalized()).toRotationMatrix();
  for (Model model : {make_block({0.05, 0.02, 0.01}, 5, 4, 3), make_block({0.04, 0.04, 0.04}, 4, 4, 4, 26)}) {
    for (Vec3& p : model.rest) p = turn * p;
    const auto pairs = [&](const auto& visit) {
      for (Index i = 0; i < model.particle_count(); ++i) {
        for (const Index* j = model.neighbours.begin(i); j != model.neighbours.end(i); ++j) visit(i, *j);
      }
    };
    const BodyFrames frames(model, std::vector<double>(model.rest.size(), 1e-6), pairs);
    ASSERT_EQ(frames.parts(), 1);
    const Mat3 along = turn.transpose() * frames.of_part(0).axes;
    for (int axis = 0; axis < 3; ++axis) EXPECT_NEAR(along.col(axis).cwiseAbs().maxCoeff(), 1.0, 1e-9);
  }
}

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
