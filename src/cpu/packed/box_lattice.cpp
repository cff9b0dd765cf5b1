// SPDX-License-Identifier: MIT
#include "box_lattice.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "packed_rows.h"

namespace phymul::cpu {
namespace {

constexpr double equal = 1e-9;

bool near(double a, double b, double scale) {
  return std::abs(a - b) <= equal * std::abs(scale);
}

/// Which axis each of three edges lies along, and the octant they span.
struct Frame {
  std::array<int, 3> axis{};
  int octant = 0;
};

std::optional<Frame> frame_of(const double* edges) {
  Frame frame;
  int axes = 0;
  for (int k = 0; k < 3; ++k) {
    const double* e = edges + 3 * k;
    const int axis =
        static_cast<int>(std::max_element(e, e + 3, [](double a, double b) { return std::abs(a) < std::abs(b); }) - e);
    for (int a = 0; a < 3; ++a) {
      if (a != axis && !near(e[a], 0.0, e[axis])) return std::nullopt;
    }
    frame.axis[k] = axis;
    axes |= 1 << axis;
    if (e[axis] > 0.0) frame.octant |= 1 << axis;
  }
  return axes == 7 ? std::optional(frame) : std::nullopt;
}

/// Constants of a corner simplex that do not depend on the corner; nothing where it is not that of a box.
struct Corner {
  std::array<double, 3> edge{}, share{}, apex_lambda{};
  double apex_share = 0.0, volume_stiffness = 0.0;
};

std::optional<Corner> corner_of(const double* c, const Frame& frame) {
  Corner corner;
  for (int k = 0; k < 3; ++k) corner.edge[frame.axis[k]] = std::abs(c[3 * k + frame.axis[k]]);
  const auto& h = corner.edge;
  double inverse_squares = 0.0;
  for (const double edge : h) inverse_squares += 1.0 / (edge * edge);
  // Heights have the sign of the normal that the edges' order gives.
  const int sign = ((frame.axis[1] - frame.axis[0] + 3) % 3 == 1 ? 1 : -1) *
                   (std::array{-1, 1, 1, -1, 1, -1, -1, 1}[static_cast<std::size_t>(frame.octant)]);
  for (int k = 0; k < 3; ++k) {
    const int axis = frame.axis[k];
    const double* base = c + 9 + 5 * k;  // share, height, 1 / |w0|^2, lambda of the other two
    const double area = h[(axis + 1) % 3] * h[(axis + 2) % 3];
    const bool usual = base[0] == 0.0 || (near(base[1], sign * h[axis] / area, h[axis] / area) &&
                                          near(base[3], 0.0, 1.0) && near(base[4], 0.0, 1.0));
    if (!usual || !near(base[2], 1.0 / (area * area), base[2])) return std::nullopt;
    corner.share[axis] = base[0];
  }
  const double* apex = c + 24;
  const double height = 1.0 / (h[0] * h[1] * h[2] * inverse_squares);
  if (apex[0] != 0.0 && !near(apex[1], -sign * height, height)) return std::nullopt;
  corner.apex_share = apex[0];
  for (int k = 0; k < 3; ++k) {
    const int axis = frame.axis[k];
    corner.apex_lambda[axis] = 1.0 / (h[axis] * h[axis] * inverse_squares);
    if (apex[0] != 0.0 && !near(apex[3 + k], corner.apex_lambda[axis], 1.0)) return std::nullopt;
  }
  const double inverse_volume = sign / (h[0] * h[1] * h[2]);
  if (c[31] != 0.0 && !near(c[30], inverse_volume, inverse_volume)) return std::nullopt;
  corner.volume_stiffness = c[31];
  return corner;
}

bool same(const Corner& a, const Corner& b) {
  for (int k = 0; k < 3; ++k) {
    if (!near(a.edge[k], b.edge[k], a.edge[k]) || !near(a.share[k], b.share[k], a.share[k])) return false;
  }
  return near(a.apex_share, b.apex_share, a.apex_share) &&
         near(a.volume_stiffness, b.volume_stiffness, a.volume_stiffness);
}

simd::BoxShape box_shape(const Corner& c, double shape_stiffness, double volume_stiffness) {
  const auto& h = c.edge;
  const double product = h[0] * h[1] * h[2];
  double inverse_squares = 0.0;
  for (const double edge : h) inverse_squares += 1.0 / (edge * edge);
  simd::BoxShape box;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double area = product / h[axis], height = h[axis] / area;
    box.h[axis] = narrow(h[axis]);
    box.leg[axis] = {narrow(area),
                     narrow(2.0 * area),
                     narrow(1.0 / (area * area)),
                     narrow(c.share[axis]),
                     narrow(c.share[axis] * height),
                     narrow(2.0 * c.share[axis] * height),
                     narrow(height)};
    box.lambda[axis] = narrow(c.apex_lambda[axis]);
    box.share_lambda[axis] = narrow(c.apex_share * c.apex_lambda[axis]);
    box.gradient[axis] = narrow(0.25 / h[axis]);
  }
  const double height = 1.0 / (product * inverse_squares);
  box.apex_rest = narrow(1.0 / (product * product * inverse_squares));
  box.apex_share_height = narrow(c.apex_share * height);
  box.apex_height = narrow(height);
  box.inverse_volume = narrow(1.0 / product);
  box.corner_volume = narrow(c.volume_stiffness / product);
  box.shape_stiffness = narrow(shape_stiffness);
  box.volume_stiffness = narrow(volume_stiffness);
  const double least = std::min({h[0], h[1], h[2]});
  box.tame = narrow(1e4 * least * least);
  return box;
}

struct Box {
  simd::BoxShape shape;
  std::array<Frame, 8> frame;
};

std::optional<Box> box_of(const std::vector<double>& shape) {
  Box box;
  std::optional<Corner> first;
  for (int corner = 0; corner < 8; ++corner) {
    const double* c = shape.data() + simplex_constant_count * corner;
    const auto frame = frame_of(c);
    if (!frame) return std::nullopt;
    const auto found = corner_of(c, *frame);
    if (!found || (first && !same(*first, *found))) return std::nullopt;
    if (!first) first = found;
    box.frame[static_cast<std::size_t>(corner)] = *frame;
  }
  const double* cell = shape.data() + 8 * simplex_constant_count;
  for (int k = 1; k < 8; ++k) {
    for (int a = 0; a < 3; ++a) {
      const double gradient = 0.25 / first->edge[a];
      // A corner's edges point away from it.
      const double sign = (box.frame[static_cast<std::size_t>(k)].octant >> a & 1) != 0 ? -1.0 : 1.0;
      if (!near(cell[3 * (k - 1) + a], sign * gradient, gradient)) return std::nullopt;
    }
  }
  box.shape = box_shape(*first, cell[21], cell[22]);
  return box;
}

/// Stars as they grow; one particle has several where shapes meet or neighbours differ from cell to cell.
class Stars {
 public:
  void add(Index centre, int shape, int octant, const std::array<Index, 3>& spoke) {
    const auto c = static_cast<std::size_t>(centre);
    if (c >= last_of_.size()) last_of_.resize(c + 1, none);
    for (Index s = last_of_[c]; s != none; s = before_[s]) {
      if (all_[s].shape == shape && takes(all_[s], octant, spoke)) return;
    }
    Star star;
    star.centre = centre;
    star.shape = shape;
    takes(star, octant, spoke);
    before_.push_back(last_of_[c]);
    last_of_[c] = static_cast<Index>(all_.size());
    all_.push_back(star);
  }
  std::vector<Star> taken() { return std::move(all_); }

 private:
  static bool takes(Star& star, int octant, const std::array<Index, 3>& spoke) {
    if ((star.octants >> octant & 1) != 0) return false;
    for (int a = 0; a < 3; ++a) {
      const Index there = star.spoke[2 * a + (octant >> a & 1)];
      if (there != none && there != spoke[a]) return false;
    }
    for (int a = 0; a < 3; ++a) star.spoke[2 * a + (octant >> a & 1)] = spoke[a];
    star.octants |= 1 << octant;
    return true;
  }

  std::vector<Star> all_;
  std::vector<Index> last_of_, before_;  // stars of a particle, one leading to the next
};

}  // namespace

BoxLattice take_boxes(Hexahedra& hexahedra) {
  BoxLattice lattice;
  std::vector<std::optional<Box>> boxes;
  for (const auto& shape : hexahedra.shapes) {
    boxes.push_back(box_of(shape));
    lattice.shapes.push_back(boxes.back() ? boxes.back()->shape : simd::BoxShape{});
  }
  Stars stars;
  std::vector<Hexahedron> others;
  for (const Hexahedron& cell : hexahedra.all) {
    const std::optional<Box>& box = boxes[static_cast<std::size_t>(cell.shape)];
    if (!box) {
      others.push_back(cell);
      continue;
    }
    Hexahedron sorted = cell;
    for (std::size_t k = 0; k < 8; ++k) {
      const Frame& frame = box->frame[k];
      std::array<Index, 3> spoke{};
      for (std::size_t m = 0; m < 3; ++m) spoke[frame.axis[m]] = cell.vertex[simd::hexahedron_edges[k][m]];
      stars.add(cell.vertex[k], cell.shape, frame.octant, spoke);
      sorted.vertex[static_cast<std::size_t>(7 - frame.octant)] = cell.vertex[k];
    }
    lattice.boxes.push_back(sorted);
  }
  hexahedra.all = std::move(others);
  lattice.stars = stars.taken();
  return lattice;
}

}  // namespace phymul::cpu
