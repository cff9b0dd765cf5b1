// SPDX-License-Identifier: MIT
#include "term_packer.h"

#include <Eigen/Geometry>
#include <algorithm>

#include "topology/neighbourhoods.h"

namespace phymul::cpu {
std::vector<Index> TermPacker::work_of(const TopologyTextures& t) {
  const bool enumerable = is_enumerable(t, simd::most_enumerated);
  std::vector<Index> work;
  for (Index i = 0; i < t.particle_count; ++i) {
    const Index springs = t.springs.empty() ? 0 : t.spring_of.size(i);
    const Index bases = enumerable && t.index[i].base_count > 0 ? t.index[i].neighbour_count : t.index[i].base_count;
    work.push_back(bases + springs);
  }
  return work;
}

TermPacker::TermPacker(const TopologyTextures& t, Index size, std::size_t clusters, PackedBody& body)
    : t_(t),
      size_(size),
      body_(body),
      slots_(t.particle_count, body.lanes),
      triples_(t, clusters, body),
      starts_(clusters) {
  volumes_ = by_cluster(
      t_.volumes, size_, clusters, [](const VolumeTexel& v) -> auto& { return v.vertex; });
  walls_ = by_cluster(
      t_.walls, size_, clusters, [](const WallTexel& w) -> auto& { return w.vertex; });
  slices_bases_ = !triples_.enumerates() && t_.base_count > 0;
  body_.base_first.push_back(0);
  body_.spring_first.push_back(0);
}

void TermPacker::pack(int c) {
  Cluster& cluster = body_.clusters[c];
  const Index own = std::min(size_, t_.particle_count - cluster.first);
  slots_.begin(c, cluster, own);
  starts_[c] = {body_.base_first.size() - 1, body_.spring_first.size() - 1, body_.volumes.size(), body_.walls.size()};
  const int slices = cluster.own / body_.lanes;
  if (slices_bases_) {
    for (int s = 0; s < slices; ++s) pack_base_slice(cluster, s, own);
    cluster.job.bases.count = slices;
  }
  triples_.pack(c, slots_);
  if (!t_.springs.empty()) {
    for (int s = 0; s < slices; ++s) pack_spring_slice(cluster, s, own);
    cluster.job.springs.count = slices;
  }
  cluster.job.volumes.count = pack_volumes(c);
  cluster.job.walls.count = pack_walls(c);
  fill_idle_lanes(c);
  estimate_cost(c);
}

void TermPacker::pack_base_slice(const Cluster& cluster, int s, Index own) {
  LaneRows rows(body_.bases, simd::base_columns, body_.lanes);
  const Index first = cluster.first + s * body_.lanes;
  const Index end = std::min(first + body_.lanes, cluster.first + own);
  Index longest = 0;
  for (Index i = first; i < end; ++i) longest = std::max(longest, t_.index[i].base_count);
  rows.add(longest, 3);
  for (Index i = first; i < end; ++i) {
    for (Index k = 0; k < t_.index[i].base_count; ++k) {
      pack_base(t_.index[i].first_base + k, i, rows, k, static_cast<int>(i - first));
    }
  }
  body_.base_first.push_back(body_.base_first.back() + longest);
}

void TermPacker::pack_base(Index t, Index owner, LaneRows& rows, Index row, int lane) {
  const BaseTexel& base = t_.bases[t];
  const int vertices = body_.plane ? 2 : 3;
  for (int k = 0; k < vertices; ++k)
    rows.offset(row, k, lane, slots_.offset_of(base.vertex[k], body_.use != simd::BaseUse::attractor));
  const Vec3& at = t_.rest[base.vertex[0]];
  const Vec3 E1 = t_.rest[base.vertex[1]] - at;
  const Vec3 E2 = body_.plane ? Vec3(Vec3::Zero()) : Vec3(t_.rest[base.vertex[2]] - at);
  const double length = body_.plane ? E1.norm() : E1.cross(E2).norm();
  const double share = body_.use == simd::BaseUse::conservative ? t_.stiffness[owner] * t_.weight[t] : t_.weight[t];
  rows.put(row, 3, lane, E1);
  rows.put(row, 6, lane, E2);
  rows.put(row, 9, lane, t_.lambda[t][1]);
  rows.put(row, 10, lane, body_.plane ? 0.0 : t_.lambda[t][2]);
  rows.put(row, 11, lane, base.beta / length);
  rows.put(row, 12, lane, 1.0 / (length * length));
  rows.put(row, 13, lane, share);
}

void TermPacker::pack_spring_slice(const Cluster& cluster, int s, Index own) {
  LaneRows rows(body_.springs, simd::spring_columns, body_.lanes);
  const Index first = cluster.first + s * body_.lanes;
  Index longest = 0;
  for (int lane = 0; lane < body_.lanes; ++lane) {
    if (s * body_.lanes + lane < own) longest = std::max(longest, t_.spring_of.size(first + lane));
  }
  rows.add(longest, 1);
  for (int lane = 0; lane < body_.lanes && s * body_.lanes + lane < own; ++lane) {
    const Index i = first + lane;
    Index row = 0;
    for (const Index* entry = t_.spring_of.begin(i); entry != t_.spring_of.end(i); ++entry, ++row) {
      const SpringTexel& spring = t_.springs[*entry / 2];
      const Index other = spring.end[1 - *entry % 2];
      const Vec3 R = t_.rest[other] - t_.rest[i];
      rows.offset(row, 0, lane, slots_.offset_of(other, false));
      rows.put(row, 1, lane, R);
      rows.put(row, 4, lane, R == Vec3::Zero() ? 0.0 : 1.0 / R.squaredNorm());
      rows.put(row, 5, lane, spring.stiffness);
    }
  }
  body_.spring_first.push_back(body_.spring_first.back() + longest);
}

int TermPacker::pack_volumes(int c) {
  const SpreadLanes spread(volumes_[c].size(), body_.lanes);
  LaneRows rows(body_.volumes, simd::volume_columns, body_.lanes);
  rows.add(spread.rows(), 4);
  for (std::size_t k = 0; k < volumes_[c].size(); ++k) {
    const VolumeTexel& term = t_.volumes[volumes_[c][k]];
    const auto [row, lane] = spread.place(k);
    for (int v = 0; v < 4; ++v) {
      if (term.vertex[v] == none) continue;
      rows.offset(row, v, lane, slots_.offset_of(term.vertex[v]));
      if (v > 0) rows.put(row, 3 * v + 1, lane, Vec3(t_.rest[term.vertex[v]] - t_.rest[term.vertex[0]]));
    }
    rows.put(row, 13, lane, term.inverse_rest_volume / (body_.plane ? 2.0 : 6.0));
    rows.put(row, 14, lane, term.stiffness);
  }
  return spread.rows();
}

int TermPacker::pack_walls(int c) {
  const SpreadLanes spread(walls_[c].size(), body_.lanes);
  LaneRows rows(body_.walls, simd::wall_columns, body_.lanes);
  rows.add(spread.rows(), 6);
  for (std::size_t k = 0; k < walls_[c].size(); ++k) {
    const WallTexel& wall = t_.walls[walls_[c][k]];
    const auto [row, lane] = spread.place(k);
    const auto put = [&, row = row, lane = lane](int column, double value) { rows.put(row, column, lane, value); };
    for (int v = 0; v < 6; ++v) {
      if (wall.vertex[v] != none) rows.offset(row, v, lane, slots_.offset_of(wall.vertex[v]));
    }
    for (int a = 0; a < 2; ++a) rows.put(row, 6 + 3 * a, lane, wall.tangent[a]);
    for (int ab = 0; ab < 3; ++ab) rows.put(row, 12 + 3 * ab, lane, wall.second[ab]);
    for (int v = 1; v < 6; ++v) {
      for (int a = 0; a < 2; ++a) put(21 + 2 * (v - 1) + a, wall.gradient[v][a]);
      for (int ab = 0; ab < 3; ++ab) put(31 + 3 * (v - 1) + ab, wall.hessian[v][ab]);
    }
    for (int m = 0; m < 6; ++m) put(46 + m, wall.bending[m]);
    put(52, wall.shear);
    put(53, wall.compliance);
  }
  return spread.rows();
}

/// Lanes without a term point at the slot that stands for nothing, whose number is known only now.
void TermPacker::fill_idle_lanes(int c) {
  const std::int32_t idle = 16 * (body_.clusters[c].slots() - 1);
  const Start& start = starts_[c];
  const auto from_slice = [&](const Offsets& first, std::size_t slice, int columns) {
    return static_cast<std::size_t>(first[slice]) * columns * body_.lanes;
  };
  fill_idle(body_.bases, from_slice(body_.base_first, start.base_slice, simd::base_columns), simd::base_columns,
            body_.plane ? 2 : 3, body_.lanes, idle);
  triples_.fill_idle_lanes(c, idle);
  fill_idle(body_.springs, from_slice(body_.spring_first, start.spring_slice, simd::spring_columns),
            simd::spring_columns, 1, body_.lanes, idle);
  fill_idle(body_.volumes, start.volume, simd::volume_columns, 4, body_.lanes, idle);
  fill_idle(body_.walls, start.wall, simd::wall_columns, 6, body_.lanes, idle);
}

void TermPacker::estimate_cost(int c) {
  Cluster& cluster = body_.clusters[c];
  const auto rows_since = [](const Offsets& first, std::size_t start) {
    return static_cast<double>(first.back() - first[start]);
  };
  const double base = body_.use == simd::BaseUse::attractor ? 25.0 : body_.use == simd::BaseUse::averaged ? 80.0 : 50.0;
  cluster.cost = base * rows_since(body_.base_first, starts_[c].base_slice) + triples_.cost(c) +
                 8.0 * rows_since(body_.spring_first, starts_[c].spring_slice) + 55.0 * cluster.job.volumes.count +
                 200.0 * cluster.job.walls.count + 20.0 * cluster.own / body_.lanes +
                 2.0 * static_cast<double>(cluster.halo.size());
}

void TermPacker::point_jobs() {
  for (std::size_t c = 0; c < body_.clusters.size(); ++c) {
    simd::Job& job = body_.clusters[c].job;
    const Start& start = starts_[c];
    job.bases.first = body_.base_first.data() + start.base_slice;
    job.bases.rows = body_.bases.data();
    triples_.point(static_cast<int>(c), job);
    job.springs.first = body_.spring_first.data() + start.spring_slice;
    job.springs.rows = body_.springs.data();
    job.volumes.rows = body_.volumes.data() + start.volume;
    job.walls.rows = body_.walls.data() + start.wall;
  }
}

}  // namespace phymul::cpu
