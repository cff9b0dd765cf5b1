// SPDX-License-Identifier: MIT
#include "surface_crossings.h"

#include <Eigen/Geometry>
#include <algorithm>

#include "model/closed_surface.h"

namespace phymul {
namespace {

double triple(const Vec3& a, const Vec3& b, const Vec3& c) {
  return a.dot(b.cross(c));
}

class Search {
 public:
  explicit Search(const Surface& surface)
      : surface_(surface), tree_(middles_of(surface.vertices, surface.triangles), {}) {
    boxes_.resize(tree_.nodes.size());
    for (std::size_t n = 0; n < boxes_.size(); ++n) {
      for (Index item = tree_.nodes[n].first; item < tree_.nodes[n].end; ++item) {
        for (const Index p : triangle(tree_.items[item])) boxes_[n].extend(surface_.vertices[p]);
      }
    }
  }

  std::optional<SurfaceCrossing> find() const {
    for (Index own = 0; own < static_cast<Index>(surface_.triangles.size()); ++own) {
      Eigen::AlignedBox3d box;
      for (const Index p : triangle(own)) box.extend(surface_.vertices[p]);
      for (std::size_t n = 0; n < tree_.nodes.size();) {
        const BoxTree::Node& node = tree_.nodes[n];
        if (!boxes_[n].intersects(box)) {
          n = static_cast<std::size_t>(node.next);
          continue;
        }
        for (Index item = node.first; node.is_leaf && item < node.end; ++item) {
          const Index other = tree_.items[item];
          if (other <= own) continue;
          if (const auto place = crossing(triangle(own), triangle(other))) return SurfaceCrossing{{own, other}, *place};
        }
        ++n;
      }
    }
    return {};
  }

 private:
  const Triangle& triangle(Index row) const { return surface_.triangles[row]; }

  std::optional<Vec3> crossing(const Triangle& s, const Triangle& t) const {
    for (int k = 0; k < 3; ++k) {
      if (const auto place = through(s[k], s[(k + 1) % 3], t)) return place;
      if (const auto place = through(t[k], t[(k + 1) % 3], s)) return place;
    }
    return {};
  }

  /// Where the edge p, q passes through the inside of the triangle. An edge from one of its corners only touches it.
  std::optional<Vec3> through(Index p, Index q, const Triangle& t) const {
    for (const Index corner : t) {
      if (corner == p || corner == q) return {};
    }
    const Vec3& from = surface_.vertices[p];
    const Vec3 way = surface_.vertices[q] - from;
    const Vec3 a = surface_.vertices[t[0]] - from, b = surface_.vertices[t[1]] - from,
               c = surface_.vertices[t[2]] - from;
    const Vec3 normal = (b - a).cross(c - a);
    // Rounding of the products, of the lengths that they are made of.
    const double size = std::max({way.norm(), a.norm(), b.norm(), c.norm()});
    const double least = 1e-12 * size * size * size;
    const double start = -normal.dot(a), end = start + normal.dot(way);
    if (!((start > least && end < -least) || (start < -least && end > least))) return {};
    const double u = triple(way, b, c), v = triple(way, c, a), w = triple(way, a, b);
    const bool inside = (u > least && v > least && w > least) || (u < -least && v < -least && w < -least);
    if (!inside) return {};
    return from + start / (start - end) * way;
  }

  const Surface& surface_;
  BoxTree tree_;
  std::vector<Eigen::AlignedBox3d> boxes_;  // [nodes]
};

}  // namespace

std::optional<SurfaceCrossing> find_crossing(const Surface& surface) {
  return Search(surface).find();
}

}  // namespace phymul
