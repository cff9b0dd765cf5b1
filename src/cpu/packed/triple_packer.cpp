// SPDX-License-Identifier: MIT
#include "term_packer.h"

#include <phymul/error.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "topology/neighbourhoods.h"

namespace phymul::cpu {
namespace {

/// Share of the root of a base's |w| below which its height is the rounding of 0: constants of particles that see the
/// same are then the same to the last bit.
constexpr double no_height = 0x1p-32;

/// By how much more than by normals a particle's force may be rounded where its triples go by lengths.
constexpr double most_rounding = 3.0;

std::string_view bytes_of(const Floats& floats, std::size_t first, std::size_t count) {
  return {reinterpret_cast<const char*>(floats.data() + first), count * sizeof(float)};
}

}  // namespace

TriplePacker::TriplePacker(const TopologyTextures& t, std::size_t clusters, PackedBody& body)
    : t_(t), body_(body), enumerates_(is_enumerable(t, simd::most_enumerated)), starts_(clusters) {}

void TriplePacker::pack(int c, Slots& slots) {
  if (!enumerates_) return;
  Cluster& cluster = body_.clusters[c];
  starts_[c] = {body_.enumerated_first.size(), body_.enumerated_offsets.size()};
  const int slices = cluster.own / body_.lanes;
  for (int s = 0; s < slices; ++s) {
    const Index first = cluster.first + s * body_.lanes;
    pack_slice(first, std::min({first + body_.lanes, cluster.first + slots.own_particles()}), slots);
  }
  cluster.job.enumerated.count = slices;
}

/// Particles [first, end). A lane with fewer neighbours than the slice has itself in their place: what stands for
/// nothing would seem to be torn away where the body moves.
void TriplePacker::pack_slice(Index first, Index end, Slots& slots) {
  std::vector<Triples> triples;
  Index count = 0;
  for (Index i = first; i < end; ++i) {
    triples.push_back(triples_of(t_, i));
    count = std::max(count, static_cast<Index>(triples.back().neighbour.size()));
  }
  const int lanes = body_.lanes;
  const std::size_t constants = body_.enumerated.size(), offsets = body_.enumerated_offsets.size();
  body_.enumerated_offsets.resize(offsets + static_cast<std::size_t>(count) * lanes, unclaimed);
  LaneRows edges(body_.enumerated, simd::neighbour_columns, lanes);
  edges.add(count, 0);
  const bool pushes = body_.use != simd::BaseUse::attractor;
  for (std::size_t lane = 0; lane < triples.size(); ++lane) {
    const Triples& of = triples[lane];
    const Index owner = first + static_cast<Index>(lane);
    for (Index k = 0; k < count; ++k) {
      const bool real = k < static_cast<Index>(of.neighbour.size());
      const Index other = real ? of.neighbour[k] : owner;
      body_.enumerated_offsets[offsets + static_cast<std::size_t>(k) * lanes + lane] = slots.offset_of(other, pushes);
      if (!real) continue;
      edges.put(k, 0, static_cast<int>(lane), Vec3(t_.rest[other] - t_.rest[owner]));
      edges.put(k, 3, static_cast<int>(lane), of.alpha[k]);
    }
  }
  LaneRows pairs(body_.enumerated, 1, lanes);
  const std::size_t first_pair = body_.enumerated.size();
  pairs.add(count * (count - 1) / 2, 0);
  LaneRows rows(body_.enumerated, 2, lanes);
  const std::size_t first_triple = body_.enumerated.size();
  rows.add(count * (count - 1) * (count - 2) / 6, 0);
  Index row = 0;
  for (Index j = 0; j < count; ++j) {
    for (Index k = j + 1; k < count; ++k) {
      for (Index l = k + 1; l < count; ++l, ++row) {
        for (std::size_t lane = 0; lane < triples.size(); ++lane) {
          pack_triple(triples[lane], j, k, l, rows, row, static_cast<int>(lane));
        }
      }
    }
  }
  sum_heights(count, constants, first_pair, first_triple);
  const bool thin = std::ranges::any_of(triples, [this](const Triples& of) { return is_thin(of); });
  const std::size_t place = share_constants(constants);
  if (place / lanes > std::numeric_limits<std::int32_t>::max()) {
    throw Error(
        "the body has too many bases for 32-bit rows of constants; the backend \"reference\" has no such limit");
  }
  body_.enumerated_neighbours.push_back(count + (place == constants ? 0 : simd::known_constants) +
                                        (thin ? simd::thin_triples : 0));
  body_.enumerated_first.push_back(static_cast<std::int32_t>(place / lanes));
}

/// Whether small angles between the edges from triples' first neighbours, sin^2 = |w|^2 / (|e1|^2 |e2|^2), round the
/// sum of all triples much more by lengths (1 / sin^2) than by normals (1 / sin).
bool TriplePacker::is_thin(const Triples& of) const {
  const auto n = static_cast<Index>(of.neighbour.size());
  double lengths = 0.0, normals = 0.0;
  for (Index j = 0; j < n; ++j) {
    for (Index k = j + 1; k < n; ++k) {
      for (Index l = k + 1; l < n; ++l) {
        const Index row = of.base[triple_row(n, j, k, l)];
        if (row == none) continue;
        const Vec3& at = t_.rest[of.neighbour[j]];
        const Vec3 e1 = t_.rest[of.neighbour[k]] - at, e2 = t_.rest[of.neighbour[l]] - at;
        const double sine_squared = e1.cross(e2).squaredNorm() / (e1.squaredNorm() * e2.squaredNorm());
        const double height = t_.weight[row] * std::abs(t_.bases[row].beta);
        lengths += height / sine_squared;
        normals += height / std::sqrt(sine_squared);
      }
    }
  }
  return lengths > most_rounding * normals;
}

void TriplePacker::pack_triple(const Triples& of, Index j, Index k, Index l, LaneRows& rows, Index row,
                               int lane) const {
  const auto n = static_cast<Index>(of.neighbour.size());
  if (l >= n) return;
  const auto base_row = of.base[triple_row(n, j, k, l)];
  if (base_row == none) return;
  const BaseTexel& base = t_.bases[base_row];
  const auto normal = [this](Index a, Index b, Index c) {
    return Vec3((t_.rest[b] - t_.rest[a]).cross(t_.rest[c] - t_.rest[a]));
  };
  const Vec3 w = normal(of.neighbour[j], of.neighbour[k], of.neighbour[l]);
  const bool turned = w.dot(normal(base.vertex[0], base.vertex[1], base.vertex[2])) < 0.0;
  const bool flat = std::abs(base.beta) < no_height * std::sqrt(w.norm());
  const double height = flat ? 0.0 : t_.weight[base_row] * base.beta / w.norm();
  rows.put(row, 0, lane, turned ? -height : height);
  rows.put(row, 1, lane, 2.0 / w.squaredNorm());
}

/// w = x_j x x_k + x_k x x_l - x_j x x_l of every triple: the cross product of a pair has the heights of all its
/// triples, each as it is rounded there. From numbers as they are packed, so that particles that see the same get the
/// same to the last bit.
void TriplePacker::sum_heights(Index count, std::size_t edges, std::size_t pairs, std::size_t triples) {
  const auto lanes = static_cast<std::size_t>(body_.lanes);
  Floats& rows = body_.enumerated;
  const auto pair = [&](Index k, Index l) { return static_cast<std::size_t>(simd::pairs_of(count, k) + l); };
  for (std::size_t lane = 0; lane < lanes; ++lane) {
    const auto edge = [&](Index k, std::size_t column) -> float& {
      return rows[edges + (static_cast<std::size_t>(k) * simd::neighbour_columns + column) * lanes + lane];
    };
    std::vector<double> sum(static_cast<std::size_t>(count * (count - 1) / 2));
    std::size_t row = triples + lane;
    for (Index j = 0; j < count; ++j) {
      for (Index k = j + 1; k < count; ++k) {
        for (Index l = k + 1; l < count; ++l, row += 2 * lanes) {
          const double height = rows[row];
          sum[pair(j, k)] += height;
          sum[pair(k, l)] += height;
          sum[pair(j, l)] -= height;
        }
      }
    }
    std::vector<Vec3> tilt(static_cast<std::size_t>(count), Vec3::Zero());
    for (Index k = 0; k < count; ++k) {
      for (Index l = k + 1; l < count; ++l) {
        const std::size_t p = pair(k, l);
        const double height = 2.0 * sum[p];
        tilt[k] += height * Vec3(edge(l, 0), edge(l, 1), edge(l, 2));
        tilt[l] -= height * Vec3(edge(k, 0), edge(k, 1), edge(k, 2));
        rows[pairs + p * lanes + lane] = narrow(2.0 * height);
      }
    }
    for (Index k = 0; k < count; ++k) {
      for (int axis = 0; axis < 3; ++axis) edge(k, 4 + static_cast<std::size_t>(axis)) = narrow(tilt[k][axis]);
    }
  }
}

/// Where the constants from `first` on begin: earlier ones that are the same, or themselves.
std::size_t TriplePacker::share_constants(std::size_t first) {
  const std::size_t count = body_.enumerated.size() - first;
  const std::string_view bytes = bytes_of(body_.enumerated, first, count);
  const std::size_t hash = std::hash<std::string_view>()(bytes);
  const auto [begin, end] = known_.equal_range(hash);
  for (auto known = begin; known != end; ++known) {
    if (known->second + count <= first && bytes_of(body_.enumerated, known->second, count) == bytes) {
      body_.enumerated.resize(first);
      return known->second;
    }
  }
  known_.emplace(hash, first);
  return first;
}

void TriplePacker::fill_idle_lanes(int c, std::int32_t idle) {
  if (!enumerates_) return;
  Offsets& offsets = body_.enumerated_offsets;
  std::replace(offsets.begin() + static_cast<std::ptrdiff_t>(starts_[c].offset), offsets.end(), unclaimed, idle);
}

void TriplePacker::point(int c, simd::Job& job) const {
  if (!enumerates_) return;
  job.enumerated.first = body_.enumerated_first.data() + starts_[c].slice;
  job.enumerated.neighbours = body_.enumerated_neighbours.data() + starts_[c].slice;
  job.enumerated.offsets = body_.enumerated_offsets.data() + starts_[c].offset;
  job.enumerated.rows = body_.enumerated.data();
}

double TriplePacker::cost(int c) const {
  if (!enumerates_) return 0.0;
  const double a_triple = body_.use == simd::BaseUse::averaged ? 8.0 : 4.0;
  double cost = 0.0;
  for (std::size_t s = starts_[c].slice; s < body_.enumerated_neighbours.size(); ++s) {
    const double n = body_.enumerated_neighbours[s] & simd::neighbour_count;
    cost += 12.0 * n + 4.0 * n * n + a_triple * n * (n - 1.0) * (n - 2.0) / 6.0;
  }
  return cost;
}

}  // namespace phymul::cpu
