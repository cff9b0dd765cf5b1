// SPDX-License-Identifier: MIT
#include "wall_terms.h"

#include <phymul/error.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>

#include "model/cell_geometry.h"
#include "model/cut_cells.h"

namespace phymul {
namespace {

using Vec2 = Eigen::Vector2d;
using Mat2 = Eigen::Matrix2d;
using Row6 = Eigen::Matrix<double, 1, 6>;
using GradientWeights = Eigen::Matrix<double, 2, 6>;  // of six vertices: weights of x_,1 and x_,2
using HessianWeights = Eigen::Matrix<double, 3, 6>;   // of x_,11, x_,22 and twice x_,12

/// Least and most eigenvalue of bending moduli over those of the material: of misshapen patches L is not to be trusted.
constexpr double least_matched = 0.2, most_matched = 5.0;

using CellsOf = std::span<const std::vector<Index>>;

bool has(const Cell& cell, Index particle) {
  return std::ranges::find(cell.particles, particle) != cell.particles.end();
}

/// Beside a triangle, at one of its sides.
struct Beside {
  struct Wall {
    Index row = none, vertex = none;  // across the side
    double in_common = 0.0;           // share of the side
  };
  std::vector<Wall> walls{};  // more than one: the wall branches
  bool clamped = false;
};

Beside beside(const Model& model, Index row, std::array<Index, 2> side, CellsOf cells_of) {
  const Cell& own = model.cells[row];
  Beside found;
  for (const Index at : cells_of[side[0]]) {
    const Cell& cell = model.cells[at];
    if (at == row || !has(cell, side[1])) continue;
    found.clamped = found.clamped || is_clamp(cell);
    if (!is_wall(model, cell)) continue;
    const Vec3 its_centre = cell_centre(cell, model.rest);
    const double in_common = tissue_in_common(own, cell, side);
    if (!(in_common > 0.0)) continue;  // as of the other part of the same triangle
    const Index vertex = *std::ranges::find_if(cell.particles, [&](Index i) { return i != side[0] && i != side[1]; });
    if (has(own, vertex)) {
      throw Error(ErrorCode::invalid_model, cell_label(model, static_cast<std::size_t>(row)) + " and " +
                                                cell_label(model, static_cast<std::size_t>(at)) +
                                                ": expected one triangle of a wall between three particles");
    }
    // Of the parts of one triangle that with the most of the side.
    const auto known = std::ranges::find_if(found.walls, [&](const Beside::Wall& wall) {
      return cell_centre(model.cells[wall.row], model.rest) == its_centre;
    });
    if (known == found.walls.end()) {
      found.walls.push_back({at, vertex, in_common});
    } else if (in_common > known->in_common) {
      *known = {at, vertex, in_common};
    }
  }
  return found;
}

/// A triangle, its patch and where these are in the plane.
struct Patch {
  std::array<Index, 6> vertex{};
  std::array<bool, 3> clamped{};
  Eigen::Matrix<double, 2, 6> p = Eigen::Matrix<double, 2, 6>::Zero();
  double area = 0.0;   // m^2, of the triangle in space
  double share = 1.0;  // of its energy

  bool free(int side) const { return vertex[3 + side] == none; }
  Vec2 along(int side) const { return p.col((side + 2) % 3) - p.col((side + 1) % 3); }
  /// Outward, as long as the side.
  Vec2 across(int side) const { return {along(side).y(), -along(side).x()}; }
  double plane_area() const { return 0.5 * (along(1).x() * along(2).y() - along(1).y() * along(2).x()); }
};

/// Without what is across its sides.
Patch triangle_of(const Model& model, std::size_t row) {
  const Cell& cell = model.cells[row];
  Patch patch;
  const auto X = [&](int k) -> const Vec3& { return model.rest[patch.vertex[k]]; };
  for (int k = 0; k < 3; ++k) patch.vertex[k] = cell.particles[k];
  patch.area = area_vector(cell.particles, model.rest).norm();
  const double length = (X(1) - X(0)).norm();
  const double longest = std::max({length, (X(2) - X(1)).norm(), (X(0) - X(2)).norm()});
  if (!(patch.area > 1e-6 * longest * longest) || !(length > 0.0)) {
    throw Error(ErrorCode::invalid_model, cell_label(model, row) +
                                              ": expected a triangle of a wall to have an area; "
                                              "merge its corners, or remove it");
  }
  const Vec3 t = (X(1) - X(0)) / length;
  patch.p.col(1) = Vec2(length, 0.0);
  patch.p.col(2) = Vec2(t.dot(X(2) - X(0)), 2.0 * patch.area / length);
  return patch;
}

/// Where the vertices across its sides are in the plane.
void unfold(const Model& model, Patch& patch) {
  const auto X = [&](int k) -> const Vec3& { return model.rest[patch.vertex[k]]; };
  for (int side = 0; side < 3; ++side) {
    const int a = (side + 1) % 3, b = (side + 2) % 3;
    if (patch.free(side)) continue;
    const Vec3 r = X(3 + side) - X(a), s = (X(b) - X(a)).normalized();
    const double on = s.dot(r), out = (r - on * s).norm();
    patch.p.col(3 + side) =
        patch.p.col(a) + on * patch.along(side).normalized() + out * patch.across(side).normalized();
  }
}

/// N m.
double bending_stiffness(const Material& m) {
  return m.young * std::pow(m.thickness, 3) / (12.0 * (1.0 - m.poisson * m.poisson));
}

/// One for each choice of what is across its sides.
std::vector<Patch> patches_of(const Model& model, std::size_t row, CellsOf cells_of) {
  std::vector<Patch> patches{triangle_of(model, row)}, further;
  for (int side = 0; side < 3; ++side) {
    const Patch& triangle = patches.front();
    const Beside at = beside(model, static_cast<Index>(row),
                             {triangle.vertex[(side + 1) % 3], triangle.vertex[(side + 2) % 3]}, cells_of);
    const auto stiffness = [&](const Beside::Wall& wall) {
      return bending_stiffness(model.materials[model.cells[wall.row].material]);
    };
    double sum = 0.0;
    for (const Beside::Wall& wall : at.walls) sum += stiffness(wall);
    further.clear();
    for (Patch patch : patches) {
      patch.clamped[side] = at.clamped;
      patch.vertex[3 + side] = none;
      if (at.walls.empty()) further.push_back(patch);
      for (const Beside::Wall& wall : at.walls) {
        Patch one = patch;
        one.vertex[3 + side] = wall.vertex;
        if (at.walls.size() > 1) one.share *= stiffness(wall) / sum;
        further.push_back(one);
      }
    }
    patches.swap(further);
  }
  for (Patch& patch : patches) unfold(model, patch);
  return patches;
}

/// Where a derivative across the side is not known: of `unknown` the weights are 0.
GradientWeights side_gradient(const Patch& patch, int side, bool unknown) {
  const int a = (side + 1) % 3, b = (side + 2) % 3;
  GradientWeights g = GradientWeights::Zero();
  const Vec2 along = patch.along(side);
  if (patch.free(side)) {
    if (unknown) {
      g.col(b) = along / along.squaredNorm();
      g.col(a) = -g.col(b);
      return g;
    }
    for (int k = 0; k < 3; ++k) g.col(k) = -patch.across(k) / (2.0 * patch.plane_area());
    return g;
  }
  Mat2 diagonals;
  diagonals << along.transpose(), (patch.p.col(3 + side) - patch.p.col(side)).transpose();
  const Mat2 inverse = diagonals.inverse();
  g.col(b) += inverse.col(0);
  g.col(a) -= inverse.col(0);
  g.col(3 + side) += inverse.col(1);
  g.col(side) -= inverse.col(1);
  return g;
}

GradientWeights mean_gradient_of(const Patch& patch) {
  return (side_gradient(patch, 0, false) + side_gradient(patch, 1, false) + side_gradient(patch, 2, false)) / 3.0;
}

/// `clamped`: with the derivatives across clamped sides, which stay in space what they are at rest.
HessianWeights hessian_of(const Patch& patch, bool clamped) {
  HessianWeights H = HessianWeights::Zero();
  for (int side = 0; side < 3; ++side) {
    const GradientWeights g = side_gradient(patch, side, !(clamped && patch.clamped[side]));
    const Vec2 n = patch.across(side) / patch.plane_area();
    H.row(0) += n.x() * g.row(0);
    H.row(1) += n.y() * g.row(1);
    H.row(2) += n.x() * g.row(1) + n.y() * g.row(0);
  }
  return H;
}

/// What the unknown derivative across a free side adds to second derivatives.
Eigen::Vector3d across_free(const Patch& patch, int side) {
  const Vec2 n = patch.across(side).normalized();
  return {n.x() * n.x(), n.y() * n.y(), 2.0 * n.x() * n.y()};
}

/// The share of second derivatives that is left where no moment acts across free sides.
Mat3 without_moment(const Patch& patch, const Mat3& D) {
  Mat3 unknown = Mat3::Zero(), known = Mat3::Zero();
  for (int side = 0; side < 3; ++side) {
    if (!patch.free(side) || patch.clamped[side]) {
      known(side, side) = 1.0;  // any number: its column is 0
    } else {
      unknown.col(side) = across_free(patch, side);
    }
  }
  const Mat3 moments = unknown.transpose() * D, stiffness = moments * unknown + known;
  return Mat3::Identity() - unknown * stiffness.inverse() * moments;
}

/// Moduli of bending that give the moment D k where second derivatives are L k, within the bounds above. `H`: without
/// derivatives across sides that have one triangle; L takes them to be right.
Mat3 matched_moduli(const Patch& patch, const HessianWeights& H, const Mat3& D) {
  Eigen::Matrix<double, 6, 3> quadratics;
  for (int k = 0; k < 6; ++k) {
    const Vec2 p = patch.p.col(k);
    quadratics.row(k) << 0.5 * p.x() * p.x(), 0.5 * p.y() * p.y(), 0.5 * p.x() * p.y();
  }
  Mat3 L = H * quadratics;
  for (int side = 0; side < 3; ++side) {
    if (!patch.free(side)) continue;
    const Vec2 middle = 0.5 * (patch.p.col((side + 1) % 3) + patch.p.col((side + 2) % 3)), n = patch.across(side);
    const Vec3 slope(n.x() * middle.x(), n.y() * middle.y(), 0.5 * (n.x() * middle.y() + n.y() * middle.x()));
    L += across_free(patch, side) * slope.transpose() / patch.plane_area();
  }
  if (!(std::abs(L.determinant()) > 1e-3)) return D;
  const Mat3 once = D * L.inverse(), C = 0.5 * (once + once.transpose());
  const Eigen::SelfAdjointEigenSolver<Mat3> material(D);
  const Mat3 root = material.operatorSqrt(), inverse_root = material.operatorInverseSqrt();
  const Eigen::SelfAdjointEigenSolver<Mat3> ratio(inverse_root * C * inverse_root);
  const Vec3 within = ratio.eigenvalues().cwiseMax(least_matched).cwiseMin(most_matched);
  const Mat3 V = root * ratio.eigenvectors();
  return V * within.asDiagonal() * V.transpose();
}

/// The positive square root, by Cayley and Hamilton.
Mat2 root_of(const Mat2& positive) {
  const double root = std::sqrt(positive.determinant());
  return (positive + root * Mat2::Identity()) / std::sqrt(positive.trace() + 2.0 * root);
}

WallTexel texel_of(const Model& model, std::size_t row, Patch patch) {
  const Material& material = model.materials[model.cells[row].material];
  const double area = model.cells[row].share * patch.share * patch.area;  // m^2, of its tissue
  Eigen::Matrix<double, 3, 6> X = Eigen::Matrix<double, 3, 6>::Zero();
  for (int k = 0; k < 6; ++k) {
    if (patch.vertex[k] != none) X.col(k) = model.rest[patch.vertex[k]] - model.rest[patch.vertex[0]];
  }
  // Coordinates in which the tangents at rest are orthonormal: those of the unfolded patch stretched by the root of
  // their metric.
  const Mat2 metric = (X * mean_gradient_of(patch).transpose()).transpose() * (X * mean_gradient_of(patch).transpose());
  patch.p = root_of(metric) * patch.p;
  const GradientWeights g = mean_gradient_of(patch);
  const double nu = material.poisson, t = material.thickness;
  Mat3 D;
  D << 1.0, nu, 0.0, nu, 1.0, 0.0, 0.0, 0.0, 0.5 * (1.0 - nu);
  D *= material.young / (1.0 - nu * nu) * t * t * t / 12.0 * area;
  const Mat3 C = matched_moduli(patch, hessian_of(patch, false), D), left = without_moment(patch, C);
  const HessianWeights H = left * hessian_of(patch, false);
  WallTexel texel;
  texel.vertex = patch.vertex;
  const Eigen::Matrix<double, 3, 2> T = X * g.transpose();
  const Mat3 second = X * (left * hessian_of(patch, true)).transpose();
  for (int a = 0; a < 2; ++a) texel.tangent[a] = T.col(a);
  for (int a = 0; a < 3; ++a) texel.second[a] = second.col(a);
  for (int k = 0; k < 6; ++k) {
    if (patch.vertex[k] == none) continue;
    texel.gradient[k] = {g(0, k), g(1, k)};
    texel.hessian[k] = {H(0, k), H(1, k), H(2, k)};
  }
  texel.bending = {C(0, 0), C(1, 1), C(2, 2), C(1, 2), C(0, 2), C(0, 1)};
  const double shear = material.young / (2.0 * (1.0 + nu)), bulk = material.young / (3.0 * (1.0 - 2.0 * nu));
  texel.shear = area * t * shear;
  texel.compliance = 2.0 * shear / (3.0 * bulk);
  return texel;
}

}  // namespace

std::vector<WallTexel> wall_terms_of(const Model& model, Index row, CellsOf cells_of) {
  const auto at = static_cast<std::size_t>(row);
  std::vector<WallTexel> terms;
  for (const Patch& patch : patches_of(model, at, cells_of)) terms.push_back(texel_of(model, at, patch));
  return terms;
}

std::vector<WallTexel> wall_terms(const Model& model) {
  std::vector<WallTexel> terms;
  if (std::ranges::none_of(model.cells, [&](const Cell& cell) { return is_wall(model, cell) || is_clamp(cell); })) {
    return terms;
  }
  std::vector<std::vector<Index>> cells_of(model.rest.size());
  const auto rows = static_cast<Index>(model.cells.size());
  for (Index row = 0; row < rows; ++row) {
    const Cell& cell = model.cells[row];
    if (!is_of_wall(model, cell) && !is_clamp(cell)) continue;
    for (const Index i : cell.particles) cells_of[i].push_back(row);
  }
  for (Index row = 0; row < rows; ++row) {
    const Cell& cell = model.cells[row];
    if (is_wall(model, cell)) {
      for (const WallTexel& term : wall_terms_of(model, row, cells_of)) terms.push_back(term);
    }
    if (!is_clamp(cell)) continue;
    const auto triangles = std::ranges::count_if(cells_of[cell.particles[0]], [&](Index at) {
      return is_wall(model, model.cells[at]) && has(model.cells[at], cell.particles[1]);
    });
    // Where it is cut, or its triangle is removed, the edge is free.
    const auto is_changed_at = [&](Index i) {
      return std::ranges::any_of(cells_of[i], [&](Index at) {
        const Cell& wall = model.cells[at];
        return is_of_wall(model, wall) && (wall.share == 0.0 || !wall.cuts.empty());
      });
    };
    if (triangles == 1 || std::ranges::any_of(cell.particles, is_changed_at)) continue;
    throw Error(ErrorCode::invalid_model,
                cell_label(model, static_cast<std::size_t>(row)) +
                    ": expected a line with a material to be an edge of a wall with one triangle "
                    "(clamp_edges); set its material to -1, or remove it");
  }
  return terms;
}

}  // namespace phymul
