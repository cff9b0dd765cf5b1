// SPDX-License-Identifier: MIT
#include "contact_points.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <utility>

#include "tool_shape.h"

namespace phymul {
namespace {

/// Along an edge of a triangle: the fewest, where the tool's radius is not known, and the most.
constexpr int fewest_parts = 3, usual_parts = 6, most_parts = 12;

using PointList = std::shared_ptr<const std::vector<ContactPoints::Shares>>;

/// The centres of the k^2 like parts of a triangle.
PointList centres(int k) {
  std::vector<ContactPoints::Shares> made;
  const auto add = [&](int a, int b, int c) { made.push_back({a / (3.0 * k), b / (3.0 * k), c / (3.0 * k)}); };
  for (int i = 0; i < k; ++i) {
    for (int j = 0; i + j < k; ++j) {
      add(3 * (k - i - j) - 2, 3 * i + 1, 3 * j + 1);
      if (i + j + 1 < k) add(3 * (k - i - j) - 4, 3 * i + 2, 3 * j + 2);
    }
  }
  return std::make_shared<const std::vector<ContactPoints::Shares>>(std::move(made));
}

const PointList& points_of_triangle(int k) {
  static const std::array<PointList, most_parts + 1> all = [] {
    std::array<PointList, most_parts + 1> made;
    for (int parts = fewest_parts; parts <= most_parts; ++parts) made[parts] = centres(parts);
    return made;
  }();
  return all[k];
}

void add_particle(ContactPoints& points, Index row) {
  static const PointList one =
      std::make_shared<const std::vector<ContactPoints::Shares>>(1, ContactPoints::Shares{1.0});
  points.patches.push_back({.corner = {row}, .corners = 1, .points = one, .area = 1.0});
}

/// Of a triangle whose corners are means of the particles of one cell.
void set_corners(ContactPoints::Patch& patch, const std::array<TissueVertex, 3>& corner) {
  patch.corners = 0;
  std::array<ContactPoints::Shares, 3> weights{};  // of the corners, by the patch's particles
  for (std::size_t c = 0; c < 3; ++c) {
    for (std::size_t v = 0; v < 4 && corner[c].particles[v] >= 0; ++v) {
      const auto known = patch.particles();
      const auto at = static_cast<std::size_t>(std::ranges::find(known, corner[c].particles[v]) - known.begin());
      if (at == known.size()) patch.corner[static_cast<std::size_t>(patch.corners++)] = corner[c].particles[v];
      weights[c][at] = corner[c].weights[v];
    }
  }
  patch.of_cut_cell = std::ranges::any_of(corner, [](const TissueVertex& at) { return at.particles[1] >= 0; });
  if (!patch.of_cut_cell) return;
  std::vector<ContactPoints::Shares> points;
  for (const ContactPoints::Shares& of_corners : *patch.points) {
    ContactPoints::Shares& made = points.emplace_back();
    for (std::size_t v = 0; v < 4; ++v) {
      for (std::size_t c = 0; c < 3; ++c) made[v] += of_corners[c] * weights[c][v];
    }
  }
  patch.points = std::make_shared<const std::vector<ContactPoints::Shares>>(std::move(points));
}

/// The shares of a triangle's second and third corner.
using Place = Eigen::Vector2d;

Vec3 shares(const Place& at) {
  return {1.0 - at[0] - at[1], at[0], at[1]};
}

/// A function that is linear in a triangle, by its values at the corners.
struct Linear {
  explicit Linear(const Vec3& at) : first(at[0]), by_second(at[1] - at[0]), by_third(at[2] - at[0]) {}
  double operator()(const Place& at) const { return first + by_second * at[0] + by_third * at[1]; }
  double first, by_second, by_third;
};

/// A convex part of a triangle.
struct Part {
  std::array<Place, 9> corner{Place(0, 0), Place(1, 0), Place(0, 1)};
  std::size_t count = 3;

  /// Cuts off where a function that has these values at the triangle's corners is negative.
  void keep_positive(const Vec3& values) {
    if (values.minCoeff() >= 0.0) return;
    const Linear value(values);
    std::array<Place, 9> kept;
    std::size_t n = 0;
    const auto keep = [&](const Place& at) {
      if (n < kept.size()) kept[n++] = at;  // more only where rounding crosses a plane that it lies in
    };
    double here = value(corner[0]);
    const double first = here;
    for (std::size_t k = 0; k < count; ++k) {
      const double next = k + 1 < count ? value(corner[k + 1]) : first;
      if (here >= 0.0) keep(corner[k]);
      if ((here < 0.0) != (next < 0.0)) keep(corner[k] + here / (here - next) * (corner[after(k)] - corner[k]));
      here = next;
    }
    corner = kept;
    count = n;
  }

  std::size_t after(std::size_t k) const { return k + 1 < count ? k + 1 : 0; }

  /// Of the triangle's area: that of the first corner with `k` and the one before.
  double share_of(std::size_t k) const {
    const Place one = corner[k - 1] - corner[0], other = corner[k] - corner[0];
    return std::abs(one[0] * other[1] - one[1] * other[0]);
  }
};

/// What follows from the patches.
void finish(ContactPoints& points, std::size_t particles) {
  for (const ContactPoints::Patch& patch : points.patches) points.most_points += patch.points->size();
  points.patch_first.assign(particles + 1, 0);
  const auto each = [&](auto visit) {
    for (std::size_t p = 0; p < points.patches.size(); ++p) {
      for (const Index row : points.patches[p].particles()) visit(p, row);
    }
  };
  each([&](std::size_t, Index row) { ++points.patch_first[row + 1]; });
  std::partial_sum(points.patch_first.begin(), points.patch_first.end(), points.patch_first.begin());
  points.patch_of.resize(points.patch_first.back());
  std::vector<std::size_t> at(points.patch_first.begin(), points.patch_first.end() - 1);
  each([&](std::size_t p, Index row) { points.patch_of[at[row]++] = static_cast<Index>(p); });
}

}  // namespace

ContactPoints make_contact_points(const ContactSurface& surface, double least_radius) {
  ContactPoints made;
  made.patches.reserve(surface.triangles.size());
  std::vector<char> has_triangles(surface.bodies, 0);
  for (const ContactSurface::Triangle& triangle : surface.triangles) {
    has_triangles[triangle.body] = 1;
    const auto& [one, other, third] = triangle.corner;
    const Vec3 &a = surface.rest[one], &b = surface.rest[other], &c = surface.rest[third];
    const double area = 0.5 * (b - a).cross(c - a).norm();
    if (!(area > 0.0)) continue;
    const double edge = std::max({(b - a).norm(), (c - b).norm(), (a - c).norm()});
    const double wanted = least_radius > 0.0 ? std::ceil(3.0 * edge / least_radius) : double{usual_parts};
    ContactPoints::Patch& patch = made.patches.emplace_back();
    patch.points = points_of_triangle(static_cast<int>(std::clamp<double>(wanted, fewest_parts, most_parts)));
    patch.area = area / static_cast<double>(patch.points->size());
    set_corners(patch, {surface.particles[one].at, surface.particles[other].at, surface.particles[third].at});
  }
  for (Index body = 0; body < surface.bodies; ++body) {
    if (has_triangles[body] != 0) continue;
    for (std::size_t row = 0; row < surface.body_of.size(); ++row) {
      if (surface.body_of[row] == body) add_particle(made, static_cast<Index>(row));
    }
  }
  finish(made, surface.body_of.size());
  return made;
}

namespace {

/// m: of the corners, below each face, by twice its axis, one more at the low end.
std::array<Vec3, 6> depths_in(const BoxPlanes& box, const std::array<Vec3, 3>& corner) {
  std::array<Vec3, 6> depth;
  for (int axis = 0; axis < 3; ++axis) {
    const Vec3 along(corner[0][axis], corner[1][axis], corner[2][axis]);
    depth[2 * axis] = Vec3::Constant(box.high[axis]) - along;
    depth[2 * axis + 1] = along - Vec3::Constant(box.low[axis]);
  }
  return depth;
}

/// Calls visit(face, part) for each part whose nearest surface is one face.
template <class Visit>
void for_each_part(const std::array<Vec3, 6>& depth, const Visit& visit) {
  double least = std::numeric_limits<double>::infinity();  // of what the triangle's corners are below a face at most
  for (const Vec3& own : depth) least = std::min(least, own.maxCoeff());
  if (least <= 0.0) return;
  std::array<std::size_t, 6> near;
  std::size_t count = 0;
  for (std::size_t face = 0; face < depth.size(); ++face) {
    if (depth[face].minCoeff() <= least) near[count++] = face;  // else another one is nearer all over
  }
  const auto faces = std::span(near).first(count);
  for (const std::size_t face : faces) {
    const Vec3& own = depth[face];
    const auto hides = [&](std::size_t other) {  // of two that are equally near all over the first is taken
      const Vec3 apart = depth[other] - own;
      return other != face && apart.maxCoeff() <= 0.0 && (other < face || apart.minCoeff() < 0.0);
    };
    if (std::ranges::any_of(faces, hides)) continue;
    Part part;
    part.keep_positive(own);
    for (const std::size_t other : faces) {
      if (other != face) part.keep_positive(depth[other] - own);
    }
    if (part.count >= 3) visit(face, part);
  }
}

}  // namespace

DepthInBox depth_in(const BoxPlanes& box, const std::array<Vec3, 3>& corner, double area) {
  const std::array<Vec3, 6> depth = depths_in(box, corner);
  DepthInBox sum;
  for_each_part(depth, [&](std::size_t face, const Part& part) {
    const Linear value(depth[face]);
    double whole = 0.0;
    Place load(0, 0);
    const double first = value(part.corner[0]);
    double before = value(part.corner[1]);
    for (std::size_t k = 2; k < part.count; ++k) {
      const double here = value(part.corner[k]), all = first + before + here;
      const double twelfth = area / 12.0 * part.share_of(k);
      const double a = twelfth * (first + all), b = twelfth * (before + all), c = twelfth * (here + all);
      load = load + a * part.corner[0] + b * part.corner[k - 1] + c * part.corner[k];
      whole += a + b + c;
      before = here;
    }
    const Vec3 own(whole - load[0] - load[1], load[0], load[1]);
    sum.push.row(static_cast<Eigen::Index>(face / 2)) += (face % 2 == 0 ? own : Vec3(-own)).transpose();
    sum.load += own;
    sum.square += own.dot(depth[face]);
    sum.whole += whole;
  });
  return sum;
}

void integrate_depth(const BoxPlanes& box, const std::array<Vec3, 3>& corner, double area,
                     const std::function<void(const DepthPoint&)>& visit) {
  const std::array<Vec3, 6> depth = depths_in(box, corner);
  const auto add_line = [&](int face, int other, const Place& from, const Place& to) {
    const Vec3 apart = depth[static_cast<std::size_t>(face)] - depth[static_cast<std::size_t>(other)];
    const Linear value(apart);
    const double steep = std::hypot(value.by_second, value.by_third);
    const double around = 1e-9 * apart.cwiseAbs().maxCoeff();
    if (!(steep > 0.0) || std::abs(value(from)) > around || std::abs(value(to)) > around) return;
    if (from == to) return;
    const Place way = to - from;
    // Two points of Gauss; half, because the other face's part has the line too.
    for (const double at : {0.5 - std::sqrt(1.0 / 12.0), 0.5 + std::sqrt(1.0 / 12.0)}) {
      const Vec3 share = shares(from + at * way);
      visit({.share = {share[0], share[1], share[2]},
             .depth = depth[static_cast<std::size_t>(face)].dot(share),
             .face = face,
             .other_face = other,
             .line_weight = 0.5 * area * way.norm() / steep});
    }
  };
  const auto add = [&](std::size_t face, const Part& part) {
    const int own = static_cast<int>(face);
    for (std::size_t k = 2; k < part.count; ++k) {
      const std::array<Place, 3> at{part.corner[0], part.corner[k - 1], part.corner[k]};
      const double third = area / 3.0 * part.share_of(k);
      if (third == 0.0) continue;
      for (std::size_t side = 0; side < 3; ++side) {
        const Vec3 share = shares(0.5 * (at[side] + at[(side + 1) % 3]));
        visit({.share = {share[0], share[1], share[2]}, .weight = third, .depth = depth[face].dot(share), .face = own});
      }
    }
    for (int other = 0; other < 6; ++other) {
      for (std::size_t k = 0; other != own && k < part.count; ++k) {
        add_line(own, other, part.corner[k], part.corner[part.after(k)]);
      }
    }
  };
  for_each_part(depth, add);
}

ContactPoints make_contact_points(const ContactSurface& surface, const Tool& tool) {
  const std::optional<double> radius = least_radius(tool.shape);
  const bool known = !radius || *radius > 0.0;  // not of a DistanceGrid
  return make_contact_points(surface,
                             !known ? 0.0 : radius.value_or(std::numeric_limits<double>::infinity()) + tool.margin);
}

ContactPoints make_particle_points(const Model& model) {
  ContactPoints made;
  for (Index row = 0; row < model.particle_count(); ++row) add_particle(made, row);
  finish(made, model.rest.size());
  return made;
}

}  // namespace phymul
