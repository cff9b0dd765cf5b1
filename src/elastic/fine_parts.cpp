// SPDX-License-Identifier: MIT
#include "fine_parts.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <utility>

#include "base/union_find.h"
#include "energy_density.h"

namespace phymul {
namespace {

/// Spacing of the grid over that of the rest. Below 1 the step falls; at 1.4 motions of a duct are off by twice as
/// much.
constexpr double grid_over_spacing = 1.0;
/// Inertia over the ratio of the rates that it hides. More hardly lengthens the step.
constexpr double inertia_over_ratio = 1.5;
/// Share of a smooth motion's inertia that may be added: its frequency falls by half of that.
constexpr double most_added = 2e-3;
/// Pieces with fewer particles have no motions that a grid could tell apart.
constexpr int least_particles = 8;
/// Of the solution with Q.
constexpr int most_turns = 300;
constexpr double rounding = 1e-12;
/// Weights are multiples of it, so that neither they nor their sums are rounded in single precision.
constexpr double weight_unit = 0x1p-20;
/// Steps of the search over rates.
constexpr double finer = 1.25;

/// 1/s^2 over the modulus of a domain's own material: stiffness over mass of each particle when all others are held.
std::vector<double> own_rates(const TopologyTextures& t) {
  std::vector<double> rate(t.rest.size(), 0.0);
  for (Index d = 0; d < static_cast<Index>(t.domains.size()); ++d) {
    const auto [mu, lambda] = lame_at_rest<double>(t.energy_of(d));
    const double inverse_volume = t.domains[d].inverse_volume;
    const Index i = t.domains[d].particle;
    Vec3 own = Vec3::Zero();
    const auto add = [&](Index offset, const Vec3& area) {
      if (offset == 0) return;
      rate[t.domains[d + offset].particle] += inverse_volume * area.squaredNorm();
      own += area;
    };
    for (const LinkTexel& link : t.links_of(d)) {
      add(link.offset, link.area);
      rate[i] += link.stiffness / (lambda + 2.0 * mu);
    }
    for (const SurfaceLinkTexel& link : t.surface_links_of(d)) add(link.offset, link.area);
    rate[i] += inverse_volume * own.squaredNorm();
  }
  for (std::size_t i = 0; i < rate.size(); ++i) rate[i] = t.mass[i] > 0.0 ? rate[i] / t.mass[i] : 0.0;
  return rate;
}

std::vector<double> spacings(const TopologyTextures& t) {
  std::vector<double> spacing(t.rest.size(), 0.0);
  for (const DomainTexel& domain : t.domains) spacing[domain.particle] += 1.0 / domain.inverse_volume;
  for (double& h : spacing) h = std::pow(h, 1.0 / t.dimension);
  return spacing;
}

/// Particles whose rate is above `rate`, by the smallest number of those that they hang together with; none: not in a
/// part.
std::vector<Index> pieces_above(const TopologyTextures& t, const std::vector<double>& own,
                                const std::vector<bool>& excluded, double rate) {
  const auto in = [&](Index i) { return own[i] > rate && (excluded.empty() || !excluded[i]); };
  UnionFind joined(own.size());
  for (Index d = 0; d < static_cast<Index>(t.domains.size()); ++d) {
    if (!in(t.domains[d].particle)) continue;
    for (const LinkTexel& link : t.links_of(d)) {
      const Index other = t.domains[d + link.offset].particle;
      if (in(other)) joined.join(t.domains[d].particle, other);
    }
  }
  std::vector<Index> piece(own.size(), none);
  std::vector<int> count(own.size(), 0);
  for (Index i = 0; i < t.particle_count; ++i) {
    if (in(i)) ++count[piece[i] = joined.root(i)];
  }
  for (Index& root : piece) {
    if (root != none && count[root] < least_particles) root = none;
  }
  return piece;
}

/// Each piece has nodes of its own. Within a cube of the grid, corners are those of the tetrahedron of Kuhn's six that
/// a particle is in.
void interpolate(const TopologyTextures& t, const std::vector<Index>& piece, double spacing, FineParts& parts) {
  std::map<std::array<Index, 4>, Index> node_at;
  for (const Index i : parts.particle) {
    std::array<Index, 4> at{0, 0, 0, piece[i]};
    Vec3 rest = Vec3::Zero();
    for (int axis = 0; axis < 3; ++axis) {
      const double place = (t.rest[i][axis] - t.rest[piece[i]][axis]) / spacing;
      at[axis] = static_cast<Index>(std::floor(place));
      rest[axis] = std::round((place - std::floor(place)) / weight_unit) * weight_unit;
    }
    std::array<int, 3> axes{0, 1, 2};
    std::ranges::stable_sort(axes, [&](int a, int b) { return rest[a] > rest[b]; });
    std::array<FineParts::Entry, 4>& corners = parts.corners.emplace_back();
    double left = 1.0;
    for (int k = 0; k < 4; ++k) {
      const double next = k < 3 ? rest[axes[k]] : 0.0;
      const Index node = node_at.try_emplace(at, static_cast<Index>(node_at.size())).first->second;
      parts.node_mass.resize(node_at.size(), 0.0);
      corners[k] = {node, static_cast<float>(left - next)};
      parts.node_mass[node] += t.mass[i] * (left - next);
      left = next;
      if (k < 3) ++at[axes[k]];
    }
    parts.mass.push_back(t.mass[i]);
  }
  // A corner of weight 0 may be a node that nothing else has.
  for (double& mass : parts.node_mass) mass = mass > 0.0 ? mass : 1.0;
  parts.first.assign(parts.nodes() + 1, 0);
  for (const auto& corners : parts.corners) {
    for (const FineParts::Entry& corner : corners) ++parts.first[corner.row + 1];
  }
  std::partial_sum(parts.first.begin(), parts.first.end(), parts.first.begin());
  parts.entries.resize(static_cast<std::size_t>(parts.first.back()));
  std::vector<Index> at = parts.first;
  for (std::size_t r = 0; r < parts.corners.size(); ++r) {
    for (const auto& [node, weight] : parts.corners[r]) parts.entries[at[node]++] = {static_cast<Index>(r), weight};
  }
}

/// The largest share of inertia that the linear and quadratic functions of the coordinates get.
double added_inertia(const TopologyTextures& t, const FineParts& parts) {
  Vec3 centre = Vec3::Zero();
  double all = 0.0;
  for (std::size_t i = 0; i < t.rest.size(); ++i) {
    centre += t.mass[i] * t.rest[i];
    all += t.mass[i];
  }
  centre /= all;
  double largest = 0.0;
  VecList f(parts.particle.size()), change(f.size()), nodes(parts.nodes());
  for (int kind = 0; kind < 3; ++kind) {
    const auto function = [&](Index i) -> Vec3 {
      const Vec3 x = t.rest[i] - centre;
      return kind == 0 ? x : x.cwiseProduct(kind == 1 ? x : Vec3(x.y(), x.z(), x.x()));
    };
    Vec3 whole = Vec3::Zero(), added = Vec3::Zero();
    for (Index i = 0; i < t.particle_count; ++i) whole += t.mass[i] * function(i).cwiseAbs2();
    for (std::size_t r = 0; r < f.size(); ++r) f[r] = parts.mass[r] * function(parts.particle[r]);
    parts.changes<Vec3>(f, change, nodes);
    for (std::size_t r = 0; r < f.size(); ++r) added -= function(parts.particle[r]).cwiseProduct(change[r]);
    for (int axis = 0; axis < 3; ++axis) {
      if (whole[axis] > 0.0) largest = std::max(largest, added[axis] / whole[axis]);
    }
  }
  return largest;
}

}  // namespace

double FineParts::added_energy(std::span<const Vec3> v, std::span<const Vec3> next, std::span<const Vec3> free) const {
  // Q y = v by conjugate gradients in the inner product of the masses.
  const std::size_t n = particle.size();
  VecList y(n, Vec3::Zero()), residual(v.begin(), v.end()), way, force(n), image(n), at_nodes(nodes());
  const auto product = [&](std::span<const Vec3> a, std::span<const Vec3> b) {
    double sum = 0.0;
    for (std::size_t r = 0; r < n; ++r) sum += mass[r] * a[r].dot(b[r]);
    return sum;
  };
  for (std::size_t r = 0; r < n; ++r) residual[r] = residual[r].cwiseProduct(free[r]);
  way = residual;
  const double first_square = product(residual, residual);
  double square = first_square;
  for (int turn = 0; turn < most_turns && square > rounding * rounding * first_square; ++turn) {
    for (std::size_t r = 0; r < n; ++r) force[r] = mass[r] * way[r];
    changes<Vec3>(force, image, at_nodes);
    for (std::size_t r = 0; r < n; ++r) image[r] = (image[r] / mass[r] + way[r]).cwiseProduct(free[r]);
    const double length = square / product(way, image);
    for (std::size_t r = 0; r < n; ++r) {
      y[r] += length * way[r];
      residual[r] -= length * image[r];
    }
    const double before = std::exchange(square, product(residual, residual));
    for (std::size_t r = 0; r < n; ++r) way[r] = residual[r] + square / before * way[r];
  }
  for (std::size_t r = 0; r < n; ++r) y[r] -= v[r].cwiseProduct(free[r]);
  return 0.5 * product(y, next);
}

FineParts choose_fine_parts(const TopologyTextures& t, const std::vector<bool>& excluded) {
  const std::vector<double> own = own_rates(t), spacing = spacings(t);
  const double most = std::ranges::max(own);
  double least = most;
  for (const double rate : own) {
    if (rate > 0.0) least = std::min(least, rate);
  }
  double least_cost = (1.0 - least_gain) * std::sqrt(most);
  FineParts best;
  for (double rate = most / finer; rate > least; rate /= finer) {
    const std::vector<Index> piece = pieces_above(t, own, excluded, rate);
    FineParts parts;
    double rest = 0.0;
    for (Index i = 0; i < t.particle_count; ++i) {
      if (piece[i] == none) {
        rest = std::max(rest, own[i]);
      } else {
        parts.particle.push_back(i);
      }
    }
    const double cost = (1.0 + parts.cost(t.particle_count)) * std::sqrt(rest);
    if (parts.empty() || rest == 0.0 || cost >= least_cost) continue;
    double grid = 0.0;
    for (const Index i : parts.particle) grid = std::max(grid, spacing[i] * std::sqrt(own[i] / rest));
    parts.inertia = inertia_over_ratio * most / rest;
    interpolate(t, piece, grid_over_spacing * grid, parts);
    if (added_inertia(t, parts) > most_added) continue;
    least_cost = cost;
    best = std::move(parts);
  }
  return best;
}

}  // namespace phymul
