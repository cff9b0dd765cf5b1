// SPDX-License-Identifier: MIT
#include "interior.h"

#include <phymul/error.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <ranges>

#include "base/decimal.h"

namespace phymul {

double SolidInterior::at(const Vec3& x) const {
  const double value = clipped_distance(solid_, x);
  if (std::isnan(value)) throw Error("make_body: the solid's distance is not a number at " + place_text(x));
  return value;
}

std::vector<char> PlaceInterior::inside(const CentredLattice& lattice) const {
  std::vector<char> in(lattice.points());
  for (std::size_t i = 0; i < in.size(); ++i) in[i] = contains(lattice.place(static_cast<Index>(i)));
  return in;
}

std::vector<char> PlaceInterior::inside(const VecList& places) const {
  std::vector<char> in(places.size());
  std::ranges::transform(places, in.begin(), [&](const Vec3& x) { return contains(x); });
  return in;
}

double SolidInterior::exit(const Vec3& in, const Vec3& out) const {
  return root_between([&](double share) { return at(share == 1.0 ? out : Vec3(in + share * (out - in))); });
}

double SolidInterior::volume(const CentredLattice& lattice, bool is_graded) const {
  const auto& n = lattice.count;
  // Parts of a graded lattice are finer than this one: there lines are as dense as a few samples allow.
  const double fine = is_graded ? std::cbrt(3e5 / (1.0 * n[0] * n[1] * n[2])) : 0.0;
  const int parts = static_cast<int>(std::clamp(fine, 4.0, 32.0));
  const double step = lattice.edge / parts;
  // Lines in rows and columns would see the sides of a box as steps: each row is shifted, and each column.
  const auto shift = [](int row) { return std::fmod(row * std::numbers::phi, 1.0); };
  double length = 0.0;  // of all lines inside, in steps
  for (int k = 0; k < parts * n[2]; ++k) {
    for (int j = 0; j < parts * n[1]; ++j) {
      const Vec3 start(-0.5, j + shift(k), k + shift(j));
      Vec3 last = lattice.origin + step * start;
      bool was_inside = false;  // the first and last points lie outside the solid's box
      for (int i = 0; i < parts * n[0]; ++i) {
        const Vec3 x = lattice.origin + step * (start + (i + 1) * Vec3::UnitX());
        const bool is_inside = at(x) < 0.0;
        if (is_inside && was_inside) length += 1.0;
        if (is_inside != was_inside) length += is_inside ? exit(x, last) : exit(last, x);
        was_inside = is_inside;
        last = x;
      }
    }
  }
  return length * step * step * step;
}

namespace {

Eigen::AlignedBox3d box_of(const std::array<Vec3, 3>& t) {
  return Eigen::AlignedBox3d(t[0]).extend(t[1]).extend(t[2]);
}

std::array<Vec3, 3> triangle_of(const Surface& surface, Index triangle) {
  const auto& [a, b, c] = surface.triangles[triangle];
  return {surface.vertices[a], surface.vertices[b], surface.vertices[c]};
}

/// Seen along x, does the edge p, q lie beside (y, z) on the side of larger y? The ends in one order for all triangles.
bool is_beside(const Vec3& p, const Vec3& q, double y, double z) {
  if ((p.z() > z) == (q.z() > z)) return false;
  return y < p.y() + (z - p.z()) / (q.z() - p.z()) * (q.y() - p.y());
}

/// A row of the lattice along x crosses the surface here.
struct RowCrossing {
  Index row;
  double x;
  int enter;
  bool is_sharp;  // rounding cannot have moved it far
};

[[noreturn]] void refuse_overlap(const Vec3& place) {
  throw Error(ErrorCode::invalid_model,
              "surface: shells overlap at " + place_text(place) +
                  "; expected a surface that does not cross itself: remesh it, or join its shells by a boolean union");
}

bool is_sharp(const std::array<Vec3, 3>& t) {
  const Vec3 normal = (t[1] - t[0]).cross(t[2] - t[0]);
  return std::abs(normal.x()) > 1e-3 * normal.norm();
}

/// Calls f(row, first, last) for each stretch of a row inside, x from `first` to `last`. place(row): of its start.
/// Throws Error where shells overlap by more than `most_overlap`, m.
template <class Place, class Function>
void each_stretch(std::vector<RowCrossing>& crossings, double most_overlap, const Place& place, const Function& f) {
  std::ranges::sort(
      crossings, [](const RowCrossing& a, const RowCrossing& b) { return a.row != b.row ? a.row < b.row : a.x < b.x; });
  for (std::size_t from = 0, to = 0; from < crossings.size(); from = to) {
    const Index row = crossings[from].row;
    bool all_sharp = true;
    for (; to < crossings.size() && crossings[to].row == row; ++to) all_sharp = all_sharp && crossings[to].is_sharp;
    int times = 0;  // inside
    for (std::size_t c = from; c + 1 < to; ++c) {
      times += crossings[c].enter;
      if (times == 0) continue;
      const double first = crossings[c].x, last = crossings[c + 1].x;
      // Shells that touch may overlap by rounding.
      if (times != 1 && all_sharp && last - first > most_overlap) {
        const Vec3 at = place(row);
        refuse_overlap({0.5 * (first + last), at.y(), at.z()});
      }
      f(row, first, last);
    }
  }
}

}  // namespace

std::optional<Passage> passage(const VecList& vertices, const std::array<Index, 3>& triangle, double y, double z) {
  int enter = 0;
  for (int e = 0; e < 3; ++e) {
    const Index from = triangle[e], to = triangle[(e + 1) % 3];
    const Vec3 &low = vertices[std::min(from, to)], &high = vertices[std::max(from, to)];
    if (is_beside(low, high, y, z)) enter += vertices[from].z() > z ? 1 : -1;
  }
  if (enter == 0) return {};
  const Vec3 &a = vertices[triangle[0]], &b = vertices[triangle[1]], &c = vertices[triangle[2]];
  const Vec3 normal = (b - a).cross(c - a);
  const double low = std::min({a.x(), b.x(), c.x()}), high = std::max({a.x(), b.x(), c.x()});
  const double up = normal.y() * (y - a.y()) + normal.z() * (z - a.z());
  const double x = normal.x() != 0.0 ? a.x() - up / normal.x() : 0.5 * (low + high);
  return Passage{std::clamp(x, low, high), enter};
}

SurfaceInterior::SurfaceInterior(const Surface& surface, const CentredLattice& lattice)
    : surface_(surface), lattice_(lattice) {
  sort_into_cubes();
}

std::array<int, 3> SurfaceInterior::cube_at(const Vec3& x) const {
  const Vec3 at = (x - lattice_.origin) / lattice_.edge;
  std::array<int, 3> cube{};
  for (int k = 0; k < 3; ++k) cube[k] = std::clamp(static_cast<int>(std::floor(at[k])), 0, lattice_.count[k] - 1);
  return cube;
}

std::size_t SurfaceInterior::row_of(int i, int j, int k) const {
  return (static_cast<std::size_t>(k) * lattice_.count[1] + j) * lattice_.count[0] + i;
}

void SurfaceInterior::sort_into_cubes() {
  struct Entry {
    std::size_t cube;
    Index triangle;
  };
  std::vector<Entry> entries;
  const Vec3 rim = Vec3::Constant(1e-6 * lattice_.edge);
  for (Index row = 0; row < static_cast<Index>(surface_.triangles.size()); ++row) {
    const auto t = triangle_of(surface_, row);
    const Eigen::AlignedBox3d box = box_of(t);
    const std::array<int, 3> low = cube_at(box.min() - rim), high = cube_at(box.max() + rim);
    const Vec3 normal = (t[1] - t[0]).cross(t[2] - t[0]).normalized();  // zero if it has no area
    const double reach = (0.5 + 1e-6) * lattice_.edge * normal.lpNorm<1>();
    for (int k = low[2]; k <= high[2]; ++k) {
      for (int j = low[1]; j <= high[1]; ++j) {
        for (int i = low[0]; i <= high[0]; ++i) {
          const Vec3 middle = lattice_.origin + lattice_.edge * Vec3(i + 0.5, j + 0.5, k + 0.5);
          if (std::abs(normal.dot(middle - t[0])) <= reach) entries.push_back({row_of(i, j, k), row});
        }
      }
    }
  }
  of_cube_.assign(lattice_.points() / 2 + 1, 0);
  for (const Entry& e : entries) ++of_cube_[e.cube + 1];
  for (std::size_t i = 1; i < of_cube_.size(); ++i) of_cube_[i] += of_cube_[i - 1];
  triangles_.resize(entries.size());
  std::vector<Index> next(of_cube_.begin(), of_cube_.end() - 1);
  for (const Entry& e : entries) triangles_[next[e.cube]++] = e.triangle;
}

std::vector<char> SurfaceInterior::inside(const CentredLattice& lattice) const {
  const auto& n = lattice.count;
  std::vector<char> in(lattice.points(), 0);
  for (const bool middles : {false, true}) {
    const double half = middles ? 0.5 : 0.0;
    const auto at = [&](int axis, int i) { return lattice.origin[axis] + lattice.edge * (i + half); };
    const auto row_near = [&](int axis, double x) {
      return std::clamp(static_cast<int>(std::floor((x - lattice.origin[axis]) / lattice.edge - half)), -1, n[axis]);
    };
    std::vector<RowCrossing> crossings;
    for (Index triangle = 0; triangle < static_cast<Index>(surface_.triangles.size()); ++triangle) {
      const auto t = triangle_of(surface_, triangle);
      const Eigen::AlignedBox3d box = box_of(t);
      const bool sharp = is_sharp(t);
      const int first_j = std::max(row_near(1, box.min().y()), 0),
                last_j = std::min(row_near(1, box.max().y()) + 1, n[1] - 1);
      const int first_k = std::max(row_near(2, box.min().z()), 0),
                last_k = std::min(row_near(2, box.max().z()) + 1, n[2] - 1);
      for (int k = first_k; k <= last_k; ++k) {
        const double z = at(2, k);
        for (int j = first_j; j <= last_j; ++j) {
          const auto met = passage(surface_.vertices, surface_.triangles[triangle], at(1, j), z);
          if (met) crossings.push_back({static_cast<Index>(k) * n[1] + j, met->x, met->enter, sharp});
        }
      }
    }
    const auto place = [&](Index row) { return Vec3(0.0, at(1, row % n[1]), at(2, row / n[1])); };
    each_stretch(crossings, 0.01 * lattice.edge, place, [&](Index row, double first, double last) {
      const int j = row % n[1], k = row / n[1];
      for (int i = std::max(row_near(0, first), 0); i < n[0] && at(0, i) < last; ++i) {
        if (at(0, i) >= first) in[middles ? lattice.middle(i, j, k) : lattice.corner(i, j, k)] = 1;
      }
    });
  }
  return in;
}

std::vector<char> SurfaceInterior::inside(const VecList& places) const {
  const auto before = [](double a, double b, bool otherwise) { return a != b ? a < b : otherwise; };
  std::vector<Index> order(places.size());  // by z, y and x
  std::iota(order.begin(), order.end(), 0);
  std::ranges::sort(order, [&](Index i, Index j) {
    const Vec3 &a = places[i], &b = places[j];
    return before(a.z(), b.z(), before(a.y(), b.y(), a.x() < b.x()));
  });
  std::vector<Index> rows, layers;  // first of each in `order`, in `rows`
  for (Index k = 0; k < static_cast<Index>(order.size()); ++k) {
    const Vec3 &own = places[order[k]], &last = places[order[std::max(k - 1, 0)]];
    const bool is_layer = k == 0 || own.z() != last.z();
    if (is_layer) layers.push_back(static_cast<Index>(rows.size()));
    if (is_layer || own.y() != last.y()) rows.push_back(k);
  }
  layers.push_back(static_cast<Index>(rows.size()));
  rows.push_back(static_cast<Index>(order.size()));
  const auto start = [&](Index row) -> const Vec3& { return places[order[rows[row]]]; };

  std::vector<RowCrossing> crossings;
  for (const auto& triangle : surface_.triangles) {
    const std::array<Vec3, 3> t{surface_.vertices[triangle[0]], surface_.vertices[triangle[1]],
                                surface_.vertices[triangle[2]]};
    const Eigen::AlignedBox3d box = box_of(t);
    const auto first_layer = std::partition_point(layers.begin(), layers.end() - 1,
                                                  [&](Index row) { return start(row).z() < box.min().z(); });
    for (auto layer = first_layer; layer != layers.end() - 1 && start(*layer).z() <= box.max().z(); ++layer) {
      const auto in_layer = std::views::iota(*layer, layer[1]);
      for (Index row = *std::ranges::partition_point(in_layer, [&](Index r) { return start(r).y() < box.min().y(); });
           row < layer[1] && start(row).y() <= box.max().y(); ++row) {
        const auto met = passage(surface_.vertices, triangle, start(row).y(), start(row).z());
        if (met) crossings.push_back({row, met->x, met->enter, is_sharp(t)});
      }
    }
  }
  std::vector<char> in(places.size(), 0);
  each_stretch(crossings, 0.01 * lattice_.edge, start, [&](Index row, double first, double last) {
    for (Index k = rows[row]; k < rows[row + 1]; ++k) {
      const double x = places[order[k]].x();
      if (x >= first && x < last) in[order[k]] = 1;
    }
  });
  return in;
}

/// The sides on which the line passes a triangle's edges are triple products, alike for both triangles of an edge. If
/// rounding at one of the ends hides the crossing, the triangle that is missed least counts.
double SurfaceInterior::exit(const Vec3& in, const Vec3& out) const {
  const Vec3 way = out - in;
  double first = std::numeric_limits<double>::infinity(), least_miss = first, at_least_miss = 0.5;
  const std::array<int, 3> low = cube_at(in.cwiseMin(out)), high = cube_at(in.cwiseMax(out));
  for (int k = low[2]; k <= high[2]; ++k) {
    for (int j = low[1]; j <= high[1]; ++j) {
      for (int i = low[0]; i <= high[0]; ++i) {
        const std::size_t cube = row_of(i, j, k);
        for (Index item = of_cube_[cube]; item < of_cube_[cube + 1]; ++item) {
          const auto t = triangle_of(surface_, triangles_[item]);
          const Vec3 a = t[0] - in, b = t[1] - in, c = t[2] - in;
          const std::array<double, 3> side{way.dot(b.cross(c)), way.dot(c.cross(a)), way.dot(a.cross(b))};
          const double sum = side[0] + side[1] + side[2];
          if (sum == 0.0) continue;
          const double share = (side[0] * a + side[1] * b + side[2] * c).dot(way) / (sum * way.squaredNorm());
          const double past = std::max(-share, share - 1.0);
          const double beside = -std::min({side[0] / sum, side[1] / sum, side[2] / sum});
          const double miss = std::max({past, beside, 0.0});
          if (miss == 0.0) {
            first = std::min(first, share);
          } else if (miss < least_miss) {
            least_miss = miss;
            at_least_miss = share;
          }
        }
      }
    }
  }
  return std::clamp(std::isfinite(first) ? first : at_least_miss, 0.0, 1.0);
}

}  // namespace phymul
