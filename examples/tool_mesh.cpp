// SPDX-License-Identifier: MIT
#include "tool_mesh.h"

#include <phymul/error.h>

#include <cmath>
#include <numbers>

namespace {

using phymul::Vec3;

constexpr int sectors = 48, arcs = 12;  // of a turn, of a quarter of one

/// A point of the outline that turns around z: distance from the axis, height, and the outward normal there.
struct Outline {
  double r, z, normal_r, normal_z;
};

class Builder {
 public:
  Builder(const phymul::ToolPose& pose, double around) : pose_(pose), around_(around) {}
  std::vector<ToolTriangle> triangles;

  void operator()(const phymul::Sphere& sphere) { turn(cap(sphere.radius, 0.0, -1), cap(sphere.radius, 0.0, 1)); }

  void operator()(const phymul::Capsule& capsule) {
    turn(cap(capsule.radius, 0.0, -1), cap(capsule.radius, capsule.length, 1));
  }

  /// A cone of six radii as its tip, the shaft, and a hub behind it.
  void operator()(const phymul::Needle& needle) {
    const double r = needle.radius, point = 6.0 * r, slope = 1.0 / std::hypot(1.0, 6.0), hub = 5.0 * r;
    const double end = needle.length, back = needle.length + 12.0 * r;
    turn({{0, 0, 6.0 * slope, -slope}, {r, point, 6.0 * slope, -slope}, {r, point, 1, 0}, {r, end, 1, 0}},
         {{r, end, 0, -1}, {hub, end, 0, -1}, {hub, end, 1, 0}, {hub, back, 1, 0}, {hub, back, 0, 1}, {0, back, 0, 1}});
  }

  /// A plate behind the edge, seen from both sides.
  void operator()(const phymul::Blade& blade) {
    constexpr int strips = 16;
    const double back = 0.5 * blade.width + std::max(0.0, blade.belly);
    // Arcs as parabolas through their ends and middle.
    const auto edge = [&](int k) {
      const double x = blade.width * (static_cast<double>(k) / strips - 0.5),
                   share = 4.0 * x * x / (blade.width * blade.width);
      return Vec3(x, -blade.bow * share, blade.belly * share);
    };
    for (int k = 0; k < strips; ++k) {
      const Vec3 a = edge(k), b = edge(k + 1), above_a(a.x(), a.y(), back), above_b(b.x(), b.y(), back);
      quad(a, b, above_b, above_a);
      quad(above_a, above_b, b, a);
    }
  }

  void operator()(const phymul::HalfSpace&) {
    const double a = around_;
    quad({-a, -a, 0}, {a, -a, 0}, {a, a, 0}, {-a, a, 0});
  }

  void operator()(const phymul::Box& box) {
    for (int axis = 0; axis < 3; ++axis) {
      const Vec3 u = box.half_size[(axis + 1) % 3] * Vec3::Unit((axis + 1) % 3),
                 v = box.half_size[(axis + 2) % 3] * Vec3::Unit((axis + 2) % 3);
      for (const double side : {-1.0, 1.0}) {
        const Vec3 n = side * box.half_size[axis] * Vec3::Unit(axis);
        quad(n - u - side * v, n + u - side * v, n + u + side * v, n - u + side * v);
      }
    }
  }

  void operator()(const std::shared_ptr<const phymul::DistanceGrid>&) {
    throw phymul::Error("triangles_of: expected a tool of a closed form, got a distance grid; draw its mesh instead");
  }

 private:
  using Profile = std::vector<Outline>;

  /// A quarter of a circle around (0, z): upward from its pole (side -1), or up to it (1).
  static Profile cap(double radius, double z, int side) {
    Profile profile;
    for (int k = 0; k <= arcs; ++k) {
      const double angle = 0.5 * std::numbers::pi * (side < 0 ? k - arcs : k) / arcs;
      const double c = std::cos(angle), s = std::sin(angle);
      profile.push_back({radius * c, z + radius * s, c, s});
    }
    return profile;
  }

  void turn(Profile profile, const Profile& more) {
    profile.insert(profile.end(), more.begin(), more.end());
    for (std::size_t k = 0; k + 1 < profile.size(); ++k) {
      for (int s = 0; s < sectors; ++s) {
        const double from = 2.0 * std::numbers::pi * s / sectors, to = 2.0 * std::numbers::pi * (s + 1) / sectors;
        ToolTriangle low, high;
        set(low, 0, profile[k], from);
        set(low, 1, profile[k], to);
        set(low, 2, profile[k + 1], to);
        set(high, 0, profile[k], from);
        set(high, 1, profile[k + 1], to);
        set(high, 2, profile[k + 1], from);
        triangles.push_back(low);
        triangles.push_back(high);
      }
    }
  }

  void set(ToolTriangle& triangle, int corner, const Outline& at, double angle) const {
    const double c = std::cos(angle), s = std::sin(angle);
    triangle.place[corner] = pose_.position + pose_.orientation * Vec3(at.r * c, at.r * s, at.z);
    triangle.normal[corner] = pose_.orientation * Vec3(at.normal_r * c, at.normal_r * s, at.normal_z);
  }

  void quad(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
    const Vec3 normal = pose_.orientation * (b - a).cross(c - a).normalized();
    const auto out = [&](const Vec3& x) { return Vec3(pose_.position + pose_.orientation * x); };
    triangles.push_back({{out(a), out(b), out(c)}, {normal, normal, normal}});
    triangles.push_back({{out(a), out(c), out(d)}, {normal, normal, normal}});
  }

  const phymul::ToolPose& pose_;
  const double around_;
};

}  // namespace

std::vector<ToolTriangle> triangles_of(const phymul::ToolShape& shape, const phymul::ToolPose& pose, double around) {
  Builder builder(pose, around);
  std::visit(builder, shape);
  return std::move(builder.triangles);
}
