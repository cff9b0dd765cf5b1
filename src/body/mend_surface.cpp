// SPDX-License-Identifier: MIT
//
// Checks that a surface bounds a body, and mends what has one right answer.
#include <phymul/body.h>
#include <phymul/error.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>

#include "base/decimal.h"
#include "interior.h"
#include "model/cell_geometry.h"
#include "model/closed_surface.h"
#include "model/duplicates.h"
#include "surface_crossings.h"

namespace phymul {
namespace {

using Triangle = std::array<Index, 3>;

[[noreturn]] void refuse_surface(const std::string& what) {
  throw Error(ErrorCode::invalid_model, "surface: " + what);
}

class Mending {
 public:
  explicit Mending(Surface surface) : surface_(std::move(surface)) {
    check_numbers();
    check_size();
    merge_vertices();
    drop_triangles();
    find_edges();
    wind_alike();
    turn_outward();
    check_balance();
    if (const auto crossing = find_crossing(surface_)) {
      refuse_surface(
          "triangles " + std::to_string(crossing->triangles[0]) + " and " + std::to_string(crossing->triangles[1]) +
          " cross each other at " + place_text(crossing->place) +
          "; expected a surface that does not cross itself: remesh it, or join its shells by a boolean union");
    }
    note_size();
  }

  Surface take() { return std::move(surface_); }

 private:
  /// A triangle has the edge from `low` to `high`, or the other way round.
  struct Side {
    Index low, high, triangle;
    bool forward;

    bool is_along(const Side& other) const { return low == other.low && high == other.high; }
  };

  /// What a surface that was mended before says already is not said again.
  void note(const std::string& what) {
    const auto is_same = [&](const std::string& said) { return said.ends_with("surface: " + what); };
    if (std::ranges::none_of(surface_.notes, is_same)) surface_.notes.push_back("surface: " + what);
  }
  std::string of_all(std::size_t count) const {
    return std::to_string(count) + " of " + std::to_string(surface_.triangles.size()) + " triangles";
  }

  void check_numbers() const {
    if (surface_.triangles.empty()) refuse_surface("expected triangles, got none");
    for (std::size_t i = 0; i < surface_.vertices.size(); ++i) {
      if (!surface_.vertices[i].allFinite()) {
        refuse_surface("expected finite coordinates, got " + place_text(surface_.vertices[i]) + " at vertex " +
                       std::to_string(i));
      }
    }
    const auto count = static_cast<Index>(surface_.vertices.size());
    for (std::size_t i = 0; i < surface_.triangles.size(); ++i) {
      for (const Index p : surface_.triangles[i]) {
        if (p >= 0 && p < count) continue;
        refuse_surface("triangle " + std::to_string(i) + " has vertex " + std::to_string(p) + " of " +
                       std::to_string(count));
      }
    }
  }

  void check_size() const {
    if (const Vec3 sides = sides_of_box(); !sides.allFinite()) {
      refuse_surface("expected a finite size, got sides of " + place_text(sides) + " m; check the unit of its file");
    }
  }

  Vec3 sides_of_box() const {
    Eigen::AlignedBox3d box;
    for (const Triangle& t : surface_.triangles) {
      for (const Index p : t) box.extend(surface_.vertices[p]);
    }
    return box.sizes();
  }

  void merge_vertices() {
    const Repeats repeats = repeated_points(surface_.vertices, 1e-6 * sides_of_box().maxCoeff());
    std::vector<Index> row(surface_.vertices.size());
    std::iota(row.begin(), row.end(), 0);
    for (const auto& [repeat, original] : repeats) row[repeat] = original;
    for (Triangle& t : surface_.triangles) {
      for (Index& p : t) p = row[p];
    }
  }

  /// Of triangles with the same corners one stays, or none where as many are wound one way as the other: that is a wall
  /// between shells that touch.
  void drop_repeats() {
    struct Named {
      Triangle corners;  // in ascending order
      Index triangle;
      int way;  // 1 or -1
    };
    std::vector<Named> all;
    for (std::size_t i = 0; i < surface_.triangles.size(); ++i) {
      Triangle t = surface_.triangles[i];
      std::ranges::rotate(t, std::ranges::min_element(t));
      const int way = t[1] < t[2] ? 1 : -1;
      std::ranges::sort(t);
      all.push_back({t, static_cast<Index>(i), way});
    }
    std::ranges::sort(all, [](const Named& a, const Named& b) {
      return std::tie(a.corners, a.triangle) < std::tie(b.corners, b.triangle);
    });
    std::vector<char> stays(all.size(), 1);
    for (std::size_t from = 0, to = 0; from < all.size(); from = to) {
      int sum = 0;
      for (; to < all.size() && all[to].corners == all[from].corners; ++to) sum += all[to].way;
      for (std::size_t k = from; k < to; ++k) {
        const bool is_right = all[k].way * sum > 0;
        stays[all[k].triangle] = is_right;
        if (is_right) sum = 0;  // the others go
      }
    }
    std::vector<Triangle> left;
    for (std::size_t i = 0; i < stays.size(); ++i) {
      if (stays[i]) left.push_back(surface_.triangles[i]);
    }
    if (left.size() == stays.size()) return;
    if (left.empty())
      refuse_surface("all of its " + std::to_string(stays.size()) + " triangles cover each other, back to back");
    note(of_all(stays.size() - left.size()) + " repeated another, or lay back to back with it, and were dropped");
    surface_.triangles = std::move(left);
  }

  void drop_triangles() {
    const std::size_t before = surface_.triangles.size();
    std::erase_if(surface_.triangles, [](const Triangle& t) { return t[0] == t[1] || t[1] == t[2] || t[2] == t[0]; });
    const std::size_t dropped = before - surface_.triangles.size();
    if (surface_.triangles.empty())
      refuse_surface("all of its " + std::to_string(before) + " triangles are without area");
    if (dropped > 0)
      note(std::to_string(dropped) + " of " + std::to_string(before) +
           " triangles had two corners in one place and were dropped");
    drop_repeats();
    std::vector<Index> row(surface_.vertices.size(), -1);
    VecList used;
    for (Triangle& t : surface_.triangles) {
      for (Index& p : t) {
        if (row[p] < 0) {
          row[p] = static_cast<Index>(used.size());
          used.push_back(surface_.vertices[p]);
        }
        p = row[p];
      }
    }
    surface_.vertices = std::move(used);
  }

  void find_edges() {
    for (std::size_t i = 0; i < surface_.triangles.size(); ++i) {
      const Triangle& t = surface_.triangles[i];
      for (int k = 0; k < 3; ++k) {
        const Index a = t[k], b = t[(k + 1) % 3];
        sides_.push_back({std::min(a, b), std::max(a, b), static_cast<Index>(i), a < b});
      }
    }
    std::ranges::sort(sides_, [](const Side& a, const Side& b) {
      return std::tie(a.low, a.high, a.triangle) < std::tie(b.low, b.high, b.triangle);
    });
    std::size_t open = 0;
    Side first{};
    for_each_edge([&](std::size_t from, std::size_t to) {
      if (to - from != 1) return;  // check_balance() sees where inner walls end
      if (open++ == 0) first = sides_[from];
    });
    if (open == 0) return;
    refuse_surface("expected a closed surface, got " + std::to_string(open) + " open edge" + (open > 1 ? "s" : "") +
                   ", the first from " + edge_text(first) + "; close the holes, for example with a mesh editor");
  }

  std::string edge_text(const Side& side) const {
    return place_text(surface_.vertices[side.low]) + " to " + place_text(surface_.vertices[side.high]);
  }

  /// Ranges of sides_ with the same ends.
  template <class Action>
  void for_each_edge(Action action) const {
    for (std::size_t from = 0, to = 0; from < sides_.size(); from = to) {
      for (to = from + 1; to < sides_.size() && sides_[to].is_along(sides_[from]);) ++to;
      action(from, to);
    }
  }

  /// Shells are what edges of two triangles connect. Each is wound as its first triangle.
  void wind_alike() {
    struct Link {
      Index triangle, side;
      bool turned;
    };
    const std::size_t count = surface_.triangles.size();
    std::vector<std::vector<Link>> links(count);
    for_each_edge([&](std::size_t from, std::size_t to) {
      if (to - from != 2) return;
      const Side &a = sides_[from], &b = sides_[from + 1];
      const bool turned = a.forward == b.forward;
      links[a.triangle].push_back({b.triangle, static_cast<Index>(from), turned});
      links[b.triangle].push_back({a.triangle, static_cast<Index>(from), turned});
    });
    shell_.assign(count, -1);
    turned_.assign(count, 0);
    std::vector<Index> next;
    for (std::size_t seed = 0; seed < count; ++seed) {
      if (shell_[seed] >= 0) continue;
      shell_[seed] = shells_;
      next.assign(1, static_cast<Index>(seed));
      while (!next.empty()) {
        const Index own = next.back();
        next.pop_back();
        for (const Link& link : links[own]) {
          const char turned = turned_[own] ^ static_cast<char>(link.turned);
          if (shell_[link.triangle] < 0) {
            shell_[link.triangle] = shells_;
            turned_[link.triangle] = turned;
            next.push_back(link.triangle);
          } else if (turned_[link.triangle] != turned) {
            refuse_surface(
                "expected a surface with an inside and an outside, got one that comes back to the edge from " +
                edge_text(sides_[link.side]) + " on its other side");
          }
        }
      }
      ++shells_;
    }
    for (std::size_t i = 0; i < count; ++i) {
      if (turned_[i]) std::swap(surface_.triangles[i][1], surface_.triangles[i][2]);
    }
  }

  /// Is x inside the shell? By the triangles that a line along x passes.
  bool is_within(const Vec3& x, const std::vector<Triangle>& shell) const {
    bool within = false;
    for (const Triangle& t : shell) {
      const auto met = passage(surface_.vertices, t, x.y(), x.z());
      within ^= met && met->x > x.x();
    }
    return within;
  }

  /// A little inside of the shell, behind its largest triangle: on it another shell may lie. `inward`: its triangles
  /// face its inside.
  Vec3 place_inside(const std::vector<Triangle>& shell, bool inward) const {
    const auto area_of = [&](const Triangle& t) { return area_vector(t, surface_.vertices); };
    const Triangle& t = *std::ranges::max_element(shell, {}, [&](const Triangle& of) { return area_of(of).norm(); });
    const Vec3 area = area_of(t);
    const Vec3 middle = (surface_.vertices[t[0]] + surface_.vertices[t[1]] + surface_.vertices[t[2]]) / 3.0;
    return middle + (inward ? 1e-5 : -1e-5) / std::sqrt(area.norm()) * area;
  }

  /// A shell inside an odd number of others bounds a cavity. Shells do not cross, so that one place says where it is.
  /// A shell that encloses nothing has no outside, and stays as it is.
  void turn_outward() {
    std::vector<std::vector<Triangle>> shells(static_cast<std::size_t>(shells_));
    for (std::size_t i = 0; i < surface_.triangles.size(); ++i) shells[shell_[i]].push_back(surface_.triangles[i]);
    std::vector<Eigen::AlignedBox3d> boxes(shells.size());
    for (std::size_t i = 0; i < surface_.triangles.size(); ++i) {
      for (const Index p : surface_.triangles[i]) boxes[shell_[i]].extend(surface_.vertices[p]);
    }
    std::vector<char> inward(shells.size());
    for (std::size_t own = 0; own < shells.size(); ++own) {
      const Triangle& t = shells[own].front();
      const double volume = enclosed_volume(shells[own], surface_.vertices);
      const double length = boxes[own].diagonal().norm();
      if (std::abs(volume) <= 1e-12 * length * length * length) {  // rounding, whose sign says nothing
        note(std::to_string(shells[own].size()) + " triangles, the first at " + place_text(surface_.vertices[t[0]]) +
             ", lie on each other and enclose nothing");
        continue;
      }
      const Vec3 place = place_inside(shells[own], volume < 0.0);
      bool is_cavity = false;
      for (std::size_t other = 0; other < shells.size(); ++other) {
        if (other != own && boxes[other].contains(place)) is_cavity ^= is_within(place, shells[other]);
      }
      inward[own] = (volume < 0.0) != is_cavity;
    }
    std::size_t turned = 0;
    for (std::size_t i = 0; i < surface_.triangles.size(); ++i) {
      if (inward[shell_[i]]) {
        std::swap(surface_.triangles[i][1], surface_.triangles[i][2]);
        turned_[i] ^= 1;
      }
      turned += turned_[i] != 0;
    }
    if (turned == surface_.triangles.size()) {
      note("it was inside out; all triangles were turned");
    } else if (turned > 0) {
      note(of_all(turned) + " were clockwise seen from outside and were turned");
    }
  }

  /// Where more than two triangles meet at an edge, as many must pass it one way as the other.
  void check_balance() const {
    for_each_edge([&](std::size_t from, std::size_t to) {
      int forward = 0;
      for (std::size_t k = from; k < to; ++k)
        forward += sides_[k].forward != (turned_[sides_[k].triangle] != 0) ? 1 : -1;
      if (forward == 0) return;
      refuse_surface(std::to_string(to - from) + " triangles meet at the edge from " + edge_text(sides_[from]) +
                     " and do not bound an inside there; expected two triangles at each edge: remove inner walls");
    });
  }

  void note_size() {
    const Vec3 sides = sides_of_box();
    const double size = sides.maxCoeff();
    if (size >= 1e-3 && size <= 1.0) return;
    std::string what = "its longest side is " + length_text(size) + " m, and no organ's is";
    if (size > 1.0 && size <= 1000.0) what += "; if the file is in millimetres, read it with 0.001 metres per unit";
    if (size < 1e-3) what += "; check the metres per unit of its file";
    note(what);
  }

  Surface surface_;
  std::vector<Side> sides_;   // sorted by their ends
  std::vector<Index> shell_;  // [triangles]
  std::vector<char> turned_;  // [triangles] 1: not as it was given
  Index shells_ = 0;
};

}  // namespace

void mend_surface(Surface& surface) {
  surface = Mending(surface).take();
}

}  // namespace phymul
