// SPDX-License-Identifier: MIT
//
// Measures of cells; and check_mesh(): cells that overlap their neighbours, however their vertices are ordered.
#include <gtest/gtest.h>
#include <phymul/phymul.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <random>
#include <set>

#include "model/cell_geometry.h"
#include "support/flaws.h"
#include "support/message_of.h"

namespace phymul {
namespace {

/// Corners of each volume cell type in its unit shape, wound as Cell documents.
VecList unit_corners(CellType type) {
  const Vec3 o(0, 0, 0), x(1, 0, 0), y(0, 1, 0), z(0, 0, 1);
  switch (type) {
    case CellType::tetrahedron:
      return {o, x, y, z};
    case CellType::wedge:
      return {o, x, y, z, x + z, y + z};
    case CellType::pyramid:
      return {o, x, x + y, y, Vec3(0.5, 0.5, 1)};
    default:
      return {o, x, x + y, y, z, x + z, x + y + z, y + z};
  }
}

/// As a hexahedron with vertices that coincide: the trilinear map of each type.
std::array<int, 8> collapsed(CellType type) {
  switch (type) {
    case CellType::tetrahedron:
      return {0, 1, 2, 2, 3, 3, 3, 3};
    case CellType::wedge:
      return {0, 1, 2, 2, 3, 4, 5, 5};
    case CellType::pyramid:
      return {0, 1, 2, 3, 4, 4, 4, 4};
    default:
      return {0, 1, 2, 3, 4, 5, 6, 7};
  }
}

/// Integral of the Jacobian of the trilinear map by 2 x 2 x 2 Gauss points, exact for its degree.
double gauss_volume(CellType type, const VecList& x) {
  const std::array<int, 8> corner = collapsed(type);
  constexpr int sx[] = {-1, 1, 1, -1, -1, 1, 1, -1}, sy[] = {-1, -1, 1, 1, -1, -1, 1, 1},
                sz[] = {-1, -1, -1, -1, 1, 1, 1, 1};
  double sum = 0.0;
  for (int g = 0; g < 8; ++g) {
    const double r = sx[g] / std::sqrt(3.0), s = sy[g] / std::sqrt(3.0), t = sz[g] / std::sqrt(3.0);
    Mat3 jacobian = Mat3::Zero();
    for (int v = 0; v < 8; ++v) {
      const double a = 1 + sx[v] * r, b = 1 + sy[v] * s, c = 1 + sz[v] * t;
      jacobian += x[corner[v]] * Eigen::RowVector3d(sx[v] * b * c, a * sy[v] * c, a * b * sz[v]) / 8.0;
    }
    sum += jacobian.determinant();
  }
  return sum;
}

std::vector<Index> first_rows(CellType type) {
  std::vector<Index> rows(static_cast<std::size_t>(cell_size(type)));
  for (std::size_t v = 0; v < rows.size(); ++v) rows[v] = static_cast<Index>(v);
  return rows;
}

class VolumeCell : public testing::TestWithParam<CellType> {
 protected:
  VecList distorted(unsigned seed) const {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> number(-0.2, 0.2);
    VecList x = unit_corners(GetParam());
    for (Vec3& v : x) v += Vec3(number(random), number(random), number(random));
    return x;
  }
};

TEST_P(VolumeCell, VolumeIsThatOfTheTrilinearMap) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    const VecList x = distorted(seed);
    const double expected = gauss_volume(GetParam(), x);
    EXPECT_GT(expected, 0.0);
    EXPECT_NEAR(signed_volume(GetParam(), first_rows(GetParam()), x), expected, 1e-14);
  }
}

TEST_P(VolumeCell, VolumeKeepsItsDigitsFarFromTheOrigin) {
  VecList x = unit_corners(GetParam());
  const double near = signed_volume(GetParam(), first_rows(GetParam()), x);
  for (Vec3& v : x) v += Vec3(1e6, -1e6, 1e6);
  EXPECT_NEAR(signed_volume(GetParam(), first_rows(GetParam()), x), near, 1e-9);
}

TEST_P(VolumeCell, FacesAreClosedAndOutward) {
  const VecList x = distorted(7);
  Vec3 centre = Vec3::Zero(), sum = Vec3::Zero();
  for (const Vec3& v : x) centre += v / static_cast<double>(x.size());
  std::set<std::pair<Index, Index>> directed;
  for (const CellFace& face : cell_faces(GetParam())) {
    std::vector<Index> ring;
    for (const int v : face) {
      if (v >= 0) ring.push_back(v);
    }
    for (std::size_t k = 0; k < ring.size(); ++k) directed.insert({ring[k], ring[(k + 1) % ring.size()]});
    EXPECT_GT(area_vector(ring, x).dot(x[ring[0]] - centre), 0.0);
    sum += area_vector(ring, x);
  }
  EXPECT_NEAR(sum.norm(), 0.0, 1e-14);
  // Each edge is run through once each way, and the edges are those of the table.
  EXPECT_EQ(directed.size(), 2 * cell_edges(GetParam()).size());
  for (const CellEdge& edge : cell_edges(GetParam())) {
    EXPECT_TRUE(directed.count({edge[0], edge[1]}) == 1 && directed.count({edge[1], edge[0]}) == 1);
  }
}

TEST_P(VolumeCell, CornersArePositiveAndFollowEdges) {
  const VecList x = unit_corners(GetParam());
  const auto joined = [&](int a, int b) {
    const auto edges = cell_edges(GetParam());
    return std::any_of(edges.begin(), edges.end(), [&](const CellEdge& e) {
      return e == CellEdge{a, b} || e == CellEdge{b, a};
    });
  };
  int row = 0;
  for (const CellCorner& c : cell_corners(GetParam())) {
    EXPECT_EQ(c[0], row++);
    for (int k = 1; k < 4; ++k) EXPECT_TRUE(joined(c[0], c[k]));
    EXPECT_GT((x[c[1]] - x[c[0]]).cross(x[c[2]] - x[c[0]]).dot(x[c[3]] - x[c[0]]), 0.0);
  }
  EXPECT_EQ(row, GetParam() == CellType::pyramid ? 4 : cell_size(GetParam()));
}

TEST_P(VolumeCell, ReversalTurnsTheVolumeAndKeepsTheEdges) {
  const VecList x = distorted(3);
  const std::vector<Index> rows = first_rows(GetParam());
  std::vector<Index> turned;
  for (const int place : cell_reversal(GetParam())) turned.push_back(rows[place]);
  EXPECT_NEAR(signed_volume(GetParam(), turned, x), -signed_volume(GetParam(), rows, x), 1e-15);
  std::set<std::set<Index>> before, after;
  for (const CellEdge& e : cell_edges(GetParam())) {
    before.insert({rows[e[0]], rows[e[1]]});
    after.insert({turned[e[0]], turned[e[1]]});
  }
  EXPECT_EQ(before, after);
}

INSTANTIATE_TEST_SUITE_P(All, VolumeCell,
                         testing::Values(CellType::tetrahedron, CellType::wedge, CellType::pyramid,
                                         CellType::hexahedron),
                         [](const auto& type) { return std::string(cell_name(type.param)); });

TEST(CellGeometry, AreaOfAWarpedQuadIsTheIntegralOfItsNormal) {
  const VecList x{Vec3(0, 0, 0), Vec3(2, 0, 0), Vec3(2, 3, 1), Vec3(0, 3, 0)};
  // Half the cross product of the diagonals (2, 3, 1) and (-2, 3, 0).
  EXPECT_TRUE(area_vector(first_rows(CellType::quad), x).isApprox(Vec3(-1.5, -1.0, 6.0)));
  EXPECT_TRUE(area_vector(std::vector<Index>{0, 1, 3}, x).isApprox(Vec3(0, 0, 3)));
}

TEST(CellGeometry, OnlySolidCellsHaveAMeasure) {
  const VecList x{Vec3(0, 0, 0), Vec3(2, 0, 0), Vec3(2, 3, 0), Vec3(0, 3, 0)};
  Cell quad{.type = CellType::quad, .particles = {0, 1, 2, 3}};
  EXPECT_EQ(signed_measure(3, quad, x), 0.0);
  EXPECT_DOUBLE_EQ(signed_measure(2, quad, x), 6.0);
  std::reverse(quad.particles.begin(), quad.particles.end());
  EXPECT_DOUBLE_EQ(signed_measure(2, quad, x), -6.0);
}

/// A vertex pushed through its neighbours is no matter of winding: turned round, cells would lie one in the other.
TEST(TangledCells, AreRefused) {
  const Model whole = make_tetrahedral_block({0.04, 0.04, 0.04}, 4, 4, 4, 0.1, 3);
  const Model flat = make_strip(0.04, 0.04, 4, 4);
  for (const Model& model : {whole, flat}) {
    Model tangled = model;
    const auto inner = std::ranges::min_element(tangled.rest, {}, [&](const Vec3& p) {
      return (p - Vec3(0.02, 0.02, model.dimension == 3 ? 0.02 : 0.0)).norm();
    });
    inner->x() += 0.026;
    const std::vector<Finding> findings = find_flaws(tangled);
    EXPECT_TRUE(has(findings, Flaw::tangled));
    EXPECT_FALSE(has(findings, Flaw::winding));
    const Model before = tangled;
    const std::string message = message_of([&] { check_mesh(tangled, "liver.msh"); });
    EXPECT_TRUE(message.starts_with("liver.msh: ")) << message;
    EXPECT_TRUE(says(message, "whatever the order of the vertices"));
    EXPECT_TRUE(tangled == before);
    // The same cells listed mirrored, in part or all, are only wound the wrong way.
    for (const std::size_t every : {1, 3}) {
      Model mirrored = model;
      for (std::size_t row = 0; row < mirrored.cells.size(); row += every) {
        mirror(mirrored.cells[row]);
      }
      EXPECT_TRUE(has(find_flaws(mirrored), Flaw::winding)) << every;
      check_mesh(mirrored);
      EXPECT_TRUE(find_flaws(mirrored).empty()) << every;
    }
  }
}

/// In a file that is wound the wrong way throughout, the one cell that is not is the one to name.
TEST(TangledCells, AreTheOnesThatLieWrong) {
  Model model = make_tetrahedral_block({0.04, 0.04, 0.04}, 4, 4, 4, 0.1, 3);
  const std::vector<Index> corner = model.cells[200].particles;
  const Vec3 face = (model.rest[corner[1]] + model.rest[corner[2]] + model.rest[corner[3]]) / 3.0;
  model.rest.push_back(model.rest[corner[0]] + 1.2 * (face - model.rest[corner[0]]));  // beyond the face
  model.mass.push_back(1.0);
  model.stiffness.push_back(1.0);
  model.cells[200].particles = {static_cast<Index>(model.rest.size()) - 1, corner[1], corner[2], corner[3]};
  model.neighbours = neighbours_from_cells(model.cells, model.particle_count());
  for (Cell& cell : model.cells) mirror(cell);
  for (const Finding& finding : find_flaws(model)) {
    if (finding.flaw == Flaw::tangled) {
      EXPECT_TRUE(std::ranges::count(finding.items, 200) == 1) << finding.message;
    }
  }
  EXPECT_TRUE(has(find_flaws(model), Flaw::tangled));
}

TEST(TangledCells, ACellAndItsMirroredDuplicateAreNone) {
  Model model = make_tetrahedron(0.01);
  model.cells.push_back(model.cells.front());
  mirror(model.cells.back());
  EXPECT_FALSE(has(find_flaws(model), Flaw::tangled));
  EXPECT_TRUE(has(find_flaws(model), Flaw::winding));
  EXPECT_TRUE(has(find_flaws(model), Flaw::duplicate_cell));
}

}  // namespace
}  // namespace phymul
