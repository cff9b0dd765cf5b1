// SPDX-License-Identifier: MIT
#include <phymul/error.h>
#include <phymul/skin.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <string>

#include "base/box_tree.h"
#include "base/decimal.h"
#include "base/fnv.h"
#include "cell_geometry.h"

namespace phymul {
namespace {

using Weights = std::array<double, 8>;

/// Shape functions at local coordinates: hexahedra [-1, 1]^3; wedges r, s >= 0, r + s <= 1, t in [-1, 1]; tetrahedra
/// r, s, t >= 0, r + s + t <= 1; pyramids r, s in [-1, 1], t in [0, 1] with the apex at t = 1.
Weights shape_functions(CellType type, const Vec3& local) {
  const double r = local.x(), s = local.y(), t = local.z();
  Weights w{};
  const auto ring = [&](std::size_t first, double share) {
    w[first] = share * (1 - r) * (1 - s) / 4;
    w[first + 1] = share * (1 + r) * (1 - s) / 4;
    w[first + 2] = share * (1 + r) * (1 + s) / 4;
    w[first + 3] = share * (1 - r) * (1 + s) / 4;
  };
  switch (type) {
    case CellType::hexahedron:
      ring(0, (1 - t) / 2);
      ring(4, (1 + t) / 2);
      break;
    case CellType::wedge:
      for (std::size_t k : {0u, 3u}) {
        const double share = k == 0 ? (1 - t) / 2 : (1 + t) / 2;
        w[k] = share * (1 - r - s), w[k + 1] = share * r, w[k + 2] = share * s;
      }
      break;
    case CellType::tetrahedron:
      w[0] = 1 - r - s - t, w[1] = r, w[2] = s, w[3] = t;
      break;
    default:
      ring(0, 1 - t);
      w[4] = t;
  }
  return w;
}

double outside(CellType type, const Vec3& p) {
  const double r = p.x(), s = p.y(), t = p.z();
  switch (type) {
    case CellType::hexahedron:
      return (p.cwiseAbs().maxCoeff() - 1) / 2;
    case CellType::wedge:
      return std::max({-r, -s, r + s - 1, (std::abs(t) - 1) / 2});
    case CellType::tetrahedron:
      return std::max({-r, -s, -t, r + s + t - 1});
    default:
      return std::max({(std::abs(r) - 1) / 2, (std::abs(s) - 1) / 2, -t, t - 1});
  }
}

struct Place {
  Index cell = -1;
  Weights weight{};
  double outside = std::numeric_limits<double>::infinity();  ///< of the cell, in sizes of it
};

/// The largest distance from the cell's box, in sizes of the box, of a point that is so much outside of the cell: the
/// sum of the negative shape functions there, which is largest for hexahedra. Cells whose boxes are farther away than
/// that of the best cell so far need not be looked at.
double beyond_box(double outside) {
  return outside * (3.0 + outside * (6.0 + outside * 4.0));
}

/// Whether the point is in the box, or no more than `margin` times the box's size off along each axis.
bool is_near(const Eigen::AlignedBox3d& box, const Vec3& point, double margin) {
  const Vec3 around = margin * box.sizes();
  return ((point - box.min() + around).array() >= 0.0).all() && ((box.max() + around - point).array() >= 0.0).all();
}

/// The volume cells of a body at rest, and where a point is in them.
class CellSearch {
 public:
  explicit CellSearch(const Model& model) : model_(model) {
    VecList middle;
    for (Index row = 0; row < static_cast<Index>(model.cells.size()); ++row) {
      if (!is_solid(3, model.cells[row])) continue;
      for (const Index i : model.cells[row].particles) {
        if (i >= 0 && i < model.particle_count()) continue;
        throw Error(ErrorCode::invalid_model, "Skin: cell " + std::to_string(row) + " has particle " +
                                                  std::to_string(i) + " of a body of " +
                                                  std::to_string(model.particle_count()));
      }
      cells_.push_back(row);
      boxes_.push_back(box_of(model.cells[row]));
      middle.push_back(boxes_.back().center());
    }
    if (cells_.empty()) {
      throw Error(ErrorCode::invalid_model,
                  "Skin: the body has no volume cells, between whose particles a point could move");
    }
    tree_ = BoxTree(middle, {});
    node_boxes_.resize(tree_.nodes.size());
    node_sides_.assign(tree_.nodes.size(), Vec3::Zero());
    for (std::size_t n = tree_.nodes.size(); n-- > 0;) {
      const BoxTree::Node& node = tree_.nodes[n];
      node_boxes_[n] = boxes_[tree_.items[node.first]];
      for (Index k = node.first; k < node.end; ++k) {
        const Eigen::AlignedBox3d& box = boxes_[tree_.items[k]];
        node_boxes_[n].extend(box);
        node_sides_[n] = node_sides_[n].cwiseMax(box.sizes());
      }
    }
  }

  /// Of a cell, for any point; none where its map has none there.
  Weights weights_in(Index cell, const Vec3& point) const {
    return place_in(cell, box_of(model_.cells[cell]), point).weight;
  }

  /// The cell that the point is in, or within `most_outside` least outside of.
  Place find(const Vec3& point, double most_outside) const {
    // Beyond a corner of a tetrahedron, whose sizes are its heights, its box is three times as near.
    const double most = 3.0 * std::max(most_outside, 0.5);
    Place best;
    for (const double margin : {1e-6, 0.4, 1.0, most}) {
      best = best_within(point, margin);
      if (best.outside <= 0.0 || beyond_box(best.outside) <= margin) break;
    }
    return best;
  }

 private:
  Eigen::AlignedBox3d box_of(const Cell& cell) const {
    Eigen::AlignedBox3d box;
    for (const Index i : cell.particles) box.extend(model_.rest[i]);
    return box;
  }

  Place best_within(const Vec3& point, double margin) const {
    Place best;
    for (Index n = 0; n < static_cast<Index>(tree_.nodes.size()) && best.outside > 0.0;) {
      const BoxTree::Node& node = tree_.nodes[n];
      const Eigen::AlignedBox3d around(node_boxes_[n].min() - margin * node_sides_[n],
                                       node_boxes_[n].max() + margin * node_sides_[n]);
      if (!around.contains(point)) {
        n = node.next;
        continue;
      }
      for (Index k = node.first; node.is_leaf && k < node.end; ++k) {
        const Index item = tree_.items[k];
        if (!is_near(boxes_[item], point, margin)) continue;
        const Place place = place_in(cells_[item], boxes_[item], point);
        if (place.outside < best.outside) best = place;
      }
      ++n;
    }
    return best;
  }

  /// Newton's method, of which tetrahedra need one step; the map is linear in each coordinate, so that a central
  /// difference of any length is exact.
  Place place_in(Index row, const Eigen::AlignedBox3d& box, const Vec3& point) const {
    const Cell& cell = model_.cells[row];
    const auto at = [&](const Vec3& local) {
      const Weights w = shape_functions(cell.type, local);
      Vec3 sum = Vec3::Zero();
      for (std::size_t v = 0; v < cell.particles.size(); ++v) sum += w[v] * model_.rest[cell.particles[v]];
      return sum;
    };
    Vec3 local = cell.type == CellType::hexahedron ? Vec3(0, 0, 0) : Vec3(0.25, 0.25, 0.25);
    for (int step = 0; step < 30; ++step) {
      Mat3 slope;
      for (int axis = 0; axis < 3; ++axis) {
        const Vec3 half = 0.25 * Vec3::Unit(axis);
        slope.col(axis) = 2.0 * (at(local + half) - at(local - half));
      }
      const Vec3 move = slope.partialPivLu().solve(point - at(local));
      if (!move.allFinite()) break;
      if (cell.type == CellType::tetrahedron) {
        local += move;
        break;
      }
      local += move.cwiseMax(-1.0).cwiseMin(1.0);
      if (move.norm() < 1e-13) break;
    }
    // Far outside of a warped cell the map may have no such point.
    if (!((at(local) - point).norm() < 1e-9 * box.diagonal().norm())) return {};
    Place place{row, shape_functions(cell.type, local), outside(cell.type, local)};
    // Parts of a cut cell lie in one place: the point is in the one that has tissue there.
    for (const CellCut& cut : cell.cuts) {
      double value = 0.0, largest = 0.0;
      for (std::size_t v = 0; v < 4; ++v) {
        value += place.weight[v] * cut[v];
        largest = std::max(largest, std::abs(cut[v]));
      }
      place.outside = std::max(place.outside, -value / largest);
    }
    return place;
  }

  const Model& model_;
  std::vector<Index> cells_;                // rows of Model::cells
  std::vector<Eigen::AlignedBox3d> boxes_;  // of each
  BoxTree tree_;
  std::vector<Eigen::AlignedBox3d> node_boxes_;
  VecList node_sides_;  // of the largest box in each
};

/// m at rest, well within the tissue of a cut cell: of its corners and the middles of its edges and faces, a little
/// inside of it, the one farthest behind its cuts.
Vec3 place_in_tissue(const Model& model, const Cell& cell) {
  constexpr double inward = 0.1;
  Vec3 best = Vec3::Zero();
  double farthest = -std::numeric_limits<double>::infinity();
  for (unsigned corners = 1; corners < 16; ++corners) {
    double behind = std::numeric_limits<double>::infinity();
    std::array<double, 4> weight{};
    Vec3 place = Vec3::Zero();
    for (std::size_t v = 0; v < 4; ++v) {
      weight[v] = inward / 4.0 + (corners >> v & 1 ? (1.0 - inward) / std::popcount(corners) : 0.0);
      place += weight[v] * model.rest[cell.particles[v]];
    }
    for (const CellCut& cut : cell.cuts) {
      double value = 0.0, largest = 0.0;
      for (std::size_t v = 0; v < 4; ++v) value += weight[v] * cut[v], largest = std::max(largest, std::abs(cut[v]));
      behind = std::min(behind, value / largest);
    }
    if (behind > farthest) farthest = behind, best = place;
  }
  return best;
}

/// [N] m at rest: of each particle its place, but where that is beyond a cut or near one a place in the cell of it
/// that has most tissue.
VecList places_in_tissue(const Model& model) {
  VecList places = model.rest;
  std::vector<char> beside_cut(places.size(), 0);
  const auto is_cut = [](const Cell& cell) { return cell.type == CellType::tetrahedron && !cell.cuts.empty(); };
  for (const Cell& cell : model.cells) {
    if (!is_cut(cell) || cell.share == 0.0) continue;
    for (const CellCut& cut : cell.cuts) {
      double largest = 0.0;
      for (const double value : cut) largest = std::max(largest, std::abs(value));
      for (std::size_t v = 0; v < 4; ++v) {
        if (!(cut[v] > 0.25 * largest)) beside_cut[cell.particles[v]] = 1;
      }
    }
  }
  std::vector<double> most(places.size(), 0.0);
  for (const Cell& cell : model.cells) {
    if (!is_solid(3, cell)) continue;
    const double volume = std::abs(signed_measure(3, cell, model.rest));
    for (const Index i : cell.particles) {
      if (beside_cut[i] == 0 || volume <= most[i]) continue;
      most[i] = volume;
      places[i] = is_cut(cell) ? place_in_tissue(model, cell) : cell_centre(cell, model.rest);
    }
  }
  return places;
}

/// Of a point at `at`, whose cell is sought at `tissue`.
Place place_of_point(const CellSearch& search, std::size_t point, const Vec3& at, const Vec3& tissue,
                     double most_outside) {
  Place place = tissue.allFinite() ? search.find(tissue, most_outside) : Place{};
  if (!(place.outside <= most_outside)) {
    throw Error(ErrorCode::invalid_argument,
                "Skin: point " + std::to_string(point) + " at " + place_text(at) + " is not within " +
                    to_decimal(most_outside) +
                    " cells of the body; expected points in the frame and units (m) of Model::rest. Where the body "
                    "lacks a thin part, take a smaller spacing or a larger most_outside");
  }
  if (at != tissue) {
    const Weights there = search.weights_in(place.cell, at);
    if (there != Weights{}) place.weight = there;
  }
  return place;
}

std::uint64_t hash_of(const VecList& rest) {
  Fnv hash;
  hash.add(rest);
  return hash.value();
}

}  // namespace

void Skin::bind(std::span<const Index> particles, std::span<const double> weights) {
  particle_.insert(particle_.end(), particles.begin(), particles.end());
  weight_.insert(weight_.end(), weights.begin(), weights.begin() + static_cast<std::ptrdiff_t>(particles.size()));
}

Skin::Skin(const Model& model, std::span<const Vec3> points, double most_outside)
    : particle_count_(model.rest.size()), rest_hash_(hash_of(model.rest)) {
  const CellSearch search(model);
  for (std::size_t k = 0; k < points.size(); ++k) {
    const Place place = place_of_point(search, k, points[k], points[k], most_outside);
    bind(model.cells[place.cell].particles, place.weight);
    first_.push_back(particle_.size());
    farthest_outside_ = std::max(farthest_outside_, place.outside);
  }
}

Skin::Skin(const Model& model, const Model& other, double most_outside)
    : particle_count_(model.rest.size()), rest_hash_(hash_of(model.rest)) {
  const CellSearch search(model);
  const VecList tissue = places_in_tissue(other);
  for (std::size_t i = 0; i < tissue.size(); ++i) {
    if (other.mass[i] > 0.0) {
      const Place place = place_of_point(search, i, other.rest[i], tissue[i], most_outside);
      bind(model.cells[place.cell].particles, place.weight);
    }
    first_.push_back(particle_.size());
  }
}

Skin::Skin(const Model& model, const TissueSurface& surface)
    : particle_count_(model.rest.size()), rest_hash_(hash_of(model.rest)) {
  for (std::size_t k = 0; k < surface.vertices.size(); ++k) {
    const TissueVertex& vertex = surface.vertices[k];
    for (std::size_t v = 0; v < 4 && vertex.particles[v] >= 0; ++v) {
      if (vertex.particles[v] >= model.particle_count()) {
        throw Error(ErrorCode::invalid_argument, "Skin: vertex " + std::to_string(k) + " has particle " +
                                                     std::to_string(vertex.particles[v]) + " of a body of " +
                                                     std::to_string(model.rest.size()) +
                                                     "; expected the tissue_surface of this model");
      }
      particle_.push_back(vertex.particles[v]);
      weight_.push_back(vertex.weights[v]);
    }
    first_.push_back(particle_.size());
  }
}

bool Skin::is_bound_to(const Model& model) const {
  return rest_hash_ == hash_of(model.rest);
}

void Skin::deform(std::span<const Vec3> position, VecList& points) const {
  if (position.size() != particle_count_) {
    throw Error(ErrorCode::invalid_argument, "Skin::deform: expected the positions of " +
                                                 std::to_string(particle_count_) + " particles, got " +
                                                 std::to_string(position.size()));
  }
  points.resize(size());
  for (std::size_t k = 0; k < points.size(); ++k) {
    Vec3 sum = Vec3::Zero();
    for (std::size_t e = first_[k]; e < first_[k + 1]; ++e) sum += weight_[e] * position[particle_[e]];
    points[k] = sum;
  }
}

VecList Skin::deform(std::span<const Vec3> position) const {
  VecList points;
  deform(position, points);
  return points;
}

}  // namespace phymul
