// SPDX-License-Identifier: MIT
#include "closed_surface.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

namespace phymul {
namespace {

Vec3 twice_area(const std::array<Index, 3>& t, std::span<const Vec3> position) {
  const Vec3& a = position[t[0]];
  return (position[t[1]] - a).cross(position[t[2]] - a);
}

}  // namespace

std::pair<double, double> growing_branch(const std::array<double, 3>& c) {
  constexpr double infinite = std::numeric_limits<double>::infinity();
  const double a = 3.0 * c[2], b = c[1], under = b * b - a * c[0];  // halved form: a s^2 + 2 b s + c1
  std::pair<double, double> ends{-infinite, infinite};
  if (under < 0.0) return ends;
  const double q = -(b + std::copysign(std::sqrt(under), b));
  for (const double zero : {q / a, c[0] / q}) {
    if (!std::isfinite(zero)) continue;
    if (zero < 0.0) ends.first = std::max(ends.first, zero);
    if (zero > 0.0) ends.second = std::min(ends.second, zero);
  }
  return ends;
}

double enclosed_volume(Triangles triangles, std::span<const Vec3> position) {
  if (triangles.empty()) return 0.0;
  const Vec3 origin = position[triangles.front()[0]];
  double sum = 0.0;
  for (const std::array<Index, 3>& t : triangles) {
    const Vec3 a = position[t[0]] - origin, b = position[t[1]] - origin, c = position[t[2]] - origin;
    sum += a.dot(b.cross(c));
  }
  return sum / 6.0;
}

void volume_gradient(Triangles triangles, std::span<const Vec3> position, std::span<Vec3> gradient) {
  std::fill(gradient.begin(), gradient.end(), Vec3::Zero());
  if (triangles.empty()) return;
  // b x c differs from the triangle's own vector by a x (b - c), whose sum around a corner of a closed surface is 0.
  for (const std::array<Index, 3>& t : triangles) {
    const Vec3 share = twice_area(t, position) / 6.0;
    for (const Index corner : t) gradient[corner] += share;
  }
}

std::array<double, 3> volume_along(Triangles triangles, std::span<const Vec3> position, std::span<const Vec3> along) {
  std::array<double, 3> c{0.0, 0.0, 0.0};
  if (triangles.empty()) return c;
  const Vec3 origin = position[triangles.front()[0]];
  for (const std::array<Index, 3>& t : triangles) {
    // d . dV/dx(x), x . dV/dx(d) and V(d), with the gradient as above.
    const Vec3 middle = (position[t[0]] + position[t[1]] + position[t[2]]) - 3.0 * origin;
    const Vec3 across = twice_area(t, along);
    c[0] += (along[t[0]] + along[t[1]] + along[t[2]]).dot(twice_area(t, position));
    c[1] += middle.dot(across);
    c[2] += along[t[0]].dot(across);
  }
  for (double& value : c) value /= 6.0;
  return c;
}

namespace {

constexpr BoxTree::Shape by_fours{.leaf_size = 4};

}  // namespace

VecList middles_of(std::span<const Vec3> place, std::span<const Triangle> triangles) {
  VecList all;
  for (const auto& [a, b, c] : triangles) all.push_back((place[a] + place[b] + place[c]) / 3.0);
  return all;
}

std::array<Index, 2> open_edge(std::span<const Triangle> triangles) {
  std::map<std::pair<Index, Index>, int> count;  // of directed edges
  for (const Triangle& t : triangles) {
    for (int k = 0; k < 3; ++k) ++count[{t[k], t[(k + 1) % 3]}];
  }
  for (const auto& [edge, times] : count) {
    const auto back = count.find({edge.second, edge.first});
    if (times != 1 || back == count.end() || back->second != 1) return {edge.first, edge.second};
  }
  return {-1, -1};
}

Index flat_triangle(std::span<const Vec3> place, std::span<const Triangle> triangles) {
  for (std::size_t row = 0; row < triangles.size(); ++row) {
    const auto& [a, b, c] = triangles[row];
    const Vec3 along = place[b] - place[a], across = place[c] - place[a];
    const double longest = std::max({along.squaredNorm(), across.squaredNorm(), (across - along).squaredNorm()});
    if (!(along.cross(across).norm() > 1e-9 * longest)) return static_cast<Index>(row);
  }
  return -1;
}

ClosestTriangle::ClosestTriangle(std::span<const Vec3> place, std::span<const Triangle> triangles)
    : place_(place.begin(), place.end()),
      corner_normal_(place.size(), Vec3::Zero()),
      tree_(middles_of(place, triangles), by_fours) {
  for (const Index row : tree_.items) triangle_.push_back(triangles[row]);
  for (const BoxTree::Node& node : tree_.nodes) {
    Eigen::AlignedBox3d& box = boxes_.emplace_back();
    for (Index item = node.first; item < node.end; ++item) {
      for (const Index p : triangle_[item]) box.extend(place_[p]);
    }
  }
  std::map<std::pair<Index, Index>, Vec3> across;
  for (const Triangle& t : triangle_) {
    const Vec3 normal = (place_[t[1]] - place_[t[0]]).cross(place_[t[2]] - place_[t[0]]).normalized();
    face_normal_.push_back(normal);
    for (int k = 0; k < 3; ++k) {
      const Vec3 a = place_[t[(k + 1) % 3]] - place_[t[k]], b = place_[t[(k + 2) % 3]] - place_[t[k]];
      corner_normal_[t[k]] += std::atan2(a.cross(b).norm(), a.dot(b)) * normal;
      across[{t[k], t[(k + 1) % 3]}] = normal;
    }
  }
  for (std::size_t i = 0; i < triangle_.size(); ++i) {
    std::array<Vec3, 3>& edges = edge_normal_.emplace_back();
    for (int k = 0; k < 3; ++k) {
      edges[k] = face_normal_[i] + across.at({triangle_[i][(k + 1) % 3], triangle_[i][k]});
    }
  }
}

/// By the regions of C. Ericson, "Real-Time Collision Detection", Morgan Kaufmann 2005, section 5.1.5.
void ClosestTriangle::look_at(Index triangle, const Vec3& x, Nearest& nearest) const {
  const Triangle& t = triangle_[triangle];
  const Vec3 &a = place_[t[0]], &b = place_[t[1]], &c = place_[t[2]];
  const auto take = [&](const Vec3& at, const Vec3& normal) {
    const Vec3 way = x - at;
    if (way.squaredNorm() < nearest.squared) nearest = {way.squaredNorm(), way, normal};
  };
  const Vec3 ab = b - a, ac = c - a, ax = x - a, bx = x - b, cx = x - c;
  const double d1 = ab.dot(ax), d2 = ac.dot(ax), d3 = ab.dot(bx), d4 = ac.dot(bx), d5 = ab.dot(cx), d6 = ac.dot(cx);
  if (d1 <= 0.0 && d2 <= 0.0) return take(a, corner_normal_[t[0]]);
  if (d3 >= 0.0 && d4 <= d3) return take(b, corner_normal_[t[1]]);
  if (d6 >= 0.0 && d5 <= d6) return take(c, corner_normal_[t[2]]);
  const double vc = d1 * d4 - d3 * d2, vb = d5 * d2 - d1 * d6, va = d3 * d6 - d5 * d4;
  if (vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0) return take(a + d1 / (d1 - d3) * ab, edge_normal_[triangle][0]);
  if (vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0) return take(a + d2 / (d2 - d6) * ac, edge_normal_[triangle][2]);
  if (va <= 0.0 && d4 >= d3 && d5 >= d6) {
    return take(b + (d4 - d3) / ((d4 - d3) + (d5 - d6)) * (c - b), edge_normal_[triangle][1]);
  }
  take(a + (vb * ab + vc * ac) / (va + vb + vc), face_normal_[triangle]);
}

void ClosestTriangle::visit(Index own, const Vec3& x, Nearest& nearest) const {
  const auto distance = [&](Index node) { return boxes_[node].squaredExteriorDistance(x); };
  if (distance(own) >= nearest.squared) return;
  const BoxTree::Node& node = tree_.nodes[own];
  if (node.is_leaf) {
    for (Index item = node.first; item < node.end; ++item) look_at(item, x, nearest);
    return;
  }
  const Index left = own + 1, right = tree_.nodes[left].next;
  const bool left_first = distance(left) <= distance(right);
  visit(left_first ? left : right, x, nearest);
  visit(left_first ? right : left, x, nearest);
}

double ClosestTriangle::signed_distance(const Vec3& x) const {
  Nearest nearest{std::numeric_limits<double>::infinity(), Vec3::Zero(), Vec3::Zero()};
  visit(0, x, nearest);
  const double distance = std::sqrt(nearest.squared);
  return nearest.way.dot(nearest.normal) < 0.0 ? -distance : distance;
}

}  // namespace phymul
