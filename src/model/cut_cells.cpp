// SPDX-License-Identifier: MIT
#include "cut_cells.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace phymul {
namespace {

using Barycentric = Eigen::Vector4d;  // barycentric coordinates
using CutPiece = std::array<Barycentric, 4>;

/// Of the area of a face, by its barycentric coordinates: less is rounding.
constexpr double no_area = 1e-9;

double volume_of(const CutPiece& piece) {
  Eigen::Matrix4d corners;
  corners << piece[0], piece[1], piece[2], piece[3];
  return std::abs(corners.determinant());
}

/// The part of a piece where a function is above 0, as tetrahedra: of four, three, two, one or no corner.
void add_part_above(const CutPiece& piece, const CellCut& cut, std::vector<CutPiece>& parts) {
  const Barycentric values(cut[0], cut[1], cut[2], cut[3]);
  std::array<std::size_t, 4> above{}, below{};  // below: or on it
  std::array<double, 4> value{};
  std::size_t a = 0, b = 0;
  for (std::size_t v = 0; v < 4; ++v) {
    value[v] = values.dot(piece[v]);
    (value[v] > 0.0 ? above[a++] : below[b++]) = v;
  }
  const auto crossing = [&](std::size_t i, std::size_t j) {
    return Barycentric(piece[i] + value[i] / (value[i] - value[j]) * (piece[j] - piece[i]));
  };
  if (a == 4) {
    parts.push_back(piece);
  } else if (a == 3) {
    const std::size_t tip = below[0];
    const Barycentric l = crossing(above[0], tip), m = crossing(above[1], tip), n = crossing(above[2], tip);
    parts.push_back({l, m, n, piece[above[0]]});
    parts.push_back({m, n, piece[above[0]], piece[above[1]]});
    parts.push_back({n, piece[above[0]], piece[above[1]], piece[above[2]]});
  } else if (a == 2) {
    const Barycentric &p = piece[above[0]], &q = piece[above[1]];
    const Barycentric pa = crossing(above[0], below[0]), pb = crossing(above[0], below[1]);
    const Barycentric qa = crossing(above[1], below[0]), qb = crossing(above[1], below[1]);
    parts.push_back({p, pa, pb, q});
    parts.push_back({q, pa, pb, qb});
    parts.push_back({q, pa, qa, qb});
  } else if (a == 1) {
    parts.push_back(
        {piece[above[0]], crossing(above[0], below[0]), crossing(above[0], below[1]), crossing(above[0], below[2])});
  }
}

}  // namespace

/// Sutherland and Hodgman's clipping of a triangle.
double face_share(std::span<const FaceCut> cuts) {
  std::vector<Vec3> polygon{Vec3::UnitX(), Vec3::UnitY(), Vec3::UnitZ()}, clipped;
  for (const FaceCut& cut : cuts) {
    if (cut[0] == 0.0 && cut[1] == 0.0 && cut[2] == 0.0) continue;  // the face lies on the cut: it bounds the tissue
    const Vec3 values(cut[0], cut[1], cut[2]);
    clipped.clear();
    for (std::size_t k = 0; k < polygon.size(); ++k) {
      const Vec3 &from = polygon[k], &to = polygon[(k + 1) % polygon.size()];
      const double here = values.dot(from), there = values.dot(to);
      if (here >= 0.0) clipped.push_back(from);
      if (here * there < 0.0) clipped.push_back(from + here / (here - there) * (to - from));
    }
    polygon.swap(clipped);
  }
  Vec3 area = Vec3::Zero();
  for (std::size_t k = 2; k < polygon.size(); ++k) {
    area += (polygon[k - 1] - polygon[0]).cross(polygon[k] - polygon[0]);
  }
  return area.norm() / std::sqrt(3.0);
}

double tissue_share(std::span<const CellCut> cuts, std::size_t corners) {
  if (corners == 3) {
    std::vector<FaceCut> of_face;
    for (const CellCut& cut : cuts) of_face.push_back({cut[0], cut[1], cut[2]});
    return face_share(of_face);
  }
  std::vector<CutPiece> pieces{
      {Barycentric::Unit(0), Barycentric::Unit(1), Barycentric::Unit(2), Barycentric::Unit(3)}},
      parts;
  for (const CellCut& cut : cuts) {
    parts.clear();
    for (const CutPiece& piece : pieces) add_part_above(piece, cut, parts);
    pieces.swap(parts);
  }
  double sum = 0.0;
  for (const CutPiece& piece : pieces) sum += volume_of(piece);
  return sum;
}

bool has_tissue(std::span<const FaceCut> cuts) {
  return face_share(cuts) > no_area;
}

double tissue_in_common(std::span<const Index> of_a, std::span<const CellCut> cuts_of_a, std::span<const Index> of_b,
                        std::span<const CellCut> cuts_of_b, const std::array<Index, 2>& side) {
  double from = 0.0, to = 1.0;
  const auto cut = [&](std::span<const Index> particles, std::span<const CellCut> cuts) {
    bool along = false;
    for (const CellCut& values : cuts) {
      const auto value = [&](Index i) {
        return values[static_cast<std::size_t>(std::ranges::find(particles, i) - particles.begin())];
      };
      const double first = value(side[0]), last = value(side[1]);
      along = along || (first == 0.0 && last == 0.0);
      const double at = first / (first - last);
      if (first <= 0.0 && last <= 0.0 && first + last < 0.0) to = from;
      if (first < 0.0 && last > 0.0) from = std::max(from, at);
      if (first > 0.0 && last < 0.0) to = std::min(to, at);
    }
    return along;
  };
  const bool along_a = cut(of_a, cuts_of_a), along_b = cut(of_b, cuts_of_b);
  return along_a && along_b ? 0.0 : std::max(0.0, to - from);
}

double tissue_in_common(const Cell& a, const Cell& b, const std::array<Index, 2>& side) {
  return tissue_in_common(a.particles, a.cuts, b.particles, b.cuts, side);
}

bool divides(const CellCut& cut) {
  return std::ranges::any_of(cut, [](double value) { return value > 0.0; }) &&
         std::ranges::any_of(cut, [](double value) { return value < 0.0; });
}

std::optional<Eigen::Vector4d> middle_of_section(const CellCut& cut, std::size_t corners) {
  int above = 0, below = 0, points = 0;
  Eigen::Vector4d sum = Eigen::Vector4d::Zero();
  for (std::size_t a = 0; a < corners; ++a) {
    above += cut[a] > 0.0 ? 1 : 0;
    below += cut[a] < 0.0 ? 1 : 0;
  }
  const bool crosses = above > 0 && below > 0, lies_on = above + below == 1;
  if (!crosses && !lies_on) return std::nullopt;
  for (Eigen::Index a = 0; a < static_cast<Eigen::Index>(corners); ++a) {
    const double at_a = cut[static_cast<std::size_t>(a)];
    if (at_a == 0.0) {
      sum[a] += 1.0;
      ++points;
    }
    for (Eigen::Index b = 0; b < a; ++b) {
      const double at_b = cut[static_cast<std::size_t>(b)];
      if (at_a * at_b >= 0.0) continue;
      const double t = at_a / (at_a - at_b);
      sum[a] += 1.0 - t;
      sum[b] += t;
      ++points;
    }
  }
  return sum / points;
}

void add_cuts_of_face(std::span<const Index> particles, std::span<const CellCut> of_cell,
                      const std::array<Index, 3>& face, std::vector<FaceCut>& cuts) {
  for (const CellCut& cut : of_cell) {
    FaceCut& own = cuts.emplace_back();
    for (std::size_t k = 0; k < 3; ++k) {
      own[k] = cut[static_cast<std::size_t>(std::ranges::find(particles, face[k]) - particles.begin())];
    }
  }
}

}  // namespace phymul
