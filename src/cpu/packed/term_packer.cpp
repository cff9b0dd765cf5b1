// SPDX-License-Identifier: MIT
#include "term_packer.h"

#include <Eigen/Geometry>
#include <algorithm>

#include "topology/neighbourhoods.h"

namespace phymul::cpu {
namespace {

/// Bases of particle i that no simplex has taken.
std::vector<Index> lone_bases(const TopologyTextures& t, const Simplices& simplices, Index i) {
  std::vector<Index> rows;
  const IndexTexel& at = t.index[i];
  for (Index b = at.first_base; b < at.first_base + at.base_count; ++b) {
    if (!simplices.base_taken[b]) rows.push_back(b);
  }
  return rows;
}

}  // namespace

std::vector<Index> TermPacker::work_of(const TopologyTextures& t) {
  const Simplices simplices = find_simplices(t);
  const bool enumerable = is_enumerable(t, simd::most_enumerated);
  std::vector<Index> work;
  for (Index i = 0; i < t.particle_count; ++i) {
    const Index springs = t.springs.empty() ? 0 : t.spring_of.size(i);
    const Index bases = enumerable && t.index[i].base_count > 0
                            ? t.index[i].neighbour_count
                            : static_cast<Index>(lone_bases(t, simplices, i).size());
    work.push_back(bases + springs);
  }
  return work;
}

TermPacker::TermPacker(const TopologyTextures& t, const std::optional<LatticeFrame>& frame, Index size,
                       std::size_t clusters, PackedBody& body)
    : t_(t),
      size_(size),
      body_(body),
      slots_(t.particle_count, body.lanes),
      shared_(find_simplices(t)),
      found_(find_hexahedra(t, shared_)),
      lattice_(found_, t.rest, frame, size, clusters, body),
      triples_(t, clusters, body),
      starts_(clusters) {
  volumes_ = by_cluster(
      t_.volumes, size_, clusters, [](const VolumeTexel& v) -> auto& { return v.vertex; }, shared_.volume_taken);
  cells_ = by_cluster(
      t_.cells, size_, clusters, [](const CellTexel& c) -> auto& { return c.vertex; }, taken_cells());
  simplices_ = by_cluster(
      shared_.all, size_, clusters, [](const Simplex& s) -> auto& { return s.vertex; }, found_.simplex_taken);
  slices_bases_ = !triples_.enumerates() && std::ranges::find(shared_.base_taken, false) != shared_.base_taken.end();
  body_.base_first.push_back(0);
  body_.spring_first.push_back(0);
}

void TermPacker::pack(int c) {
  Cluster& cluster = body_.clusters[c];
  const Index own = std::min(size_, t_.particle_count - cluster.first);
  slots_.begin(c, cluster, own);
  starts_[c] = {body_.base_first.size() - 1, body_.spring_first.size() - 1, body_.volumes.size(),
                body_.cells4.size(),         body_.cells6.size(),           body_.cells8.size(),
                body_.simplices.size(),      body_.cell_simplices.size()};
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
  cluster.job.cells4.count = pack_cells(c, 1, 4, body_.cells4);
  cluster.job.cells6.count = pack_cells(c, 5, 6, body_.cells6);
  cluster.job.cells8.count = pack_cells(c, 7, 8, body_.cells8);
  lattice_.pack(c, slots_);
  cluster.job.simplices.count = pack_simplices(c, false, body_.simplices);
  cluster.job.cell_simplices.count = pack_simplices(c, true, body_.cell_simplices);
  fill_idle_lanes(c);
  estimate_cost(c);
}

void TermPacker::pack_base_slice(const Cluster& cluster, int s, Index own) {
  LaneRows rows(body_.bases, simd::base_columns, body_.lanes);
  const Index first = cluster.first + s * body_.lanes;
  std::vector<std::vector<Index>> bases;
  Index longest = 0;
  for (Index i = first; i < std::min(first + body_.lanes, cluster.first + own); ++i) {
    bases.push_back(lone_bases(t_, shared_, i));
    longest = std::max(longest, static_cast<Index>(bases.back().size()));
  }
  rows.add(longest, 3);
  for (std::size_t lane = 0; lane < bases.size(); ++lane) {
    const Index owner = first + static_cast<Index>(lane);
    for (std::size_t k = 0; k < bases[lane].size(); ++k) {
      pack_base(bases[lane][k], owner, rows, static_cast<Index>(k), static_cast<int>(lane));
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

/// Cells whose number of corners is in [least, corners].
int TermPacker::pack_cells(int c, int least, int corners, Floats& to) {
  std::vector<Index> cells;
  for (const Index t : cells_[c]) {
    const auto& v = t_.cells[t].vertex;
    const auto n = std::count_if(v.begin(), v.end(), [](Index i) { return i != none; });
    if (n >= least && n <= corners) cells.push_back(t);
  }
  const SpreadLanes spread(cells.size(), body_.lanes);
  LaneRows rows(to, simd::cell_columns(corners), body_.lanes);
  rows.add(spread.rows(), corners);
  for (std::size_t k = 0; k < cells.size(); ++k) {
    const CellTexel& cell = t_.cells[cells[k]];
    const auto [row, lane] = spread.place(k);
    for (int v = 0; v < corners && cell.vertex[v] != none; ++v) {
      rows.offset(row, v, lane, slots_.offset_of(cell.vertex[v]));
      if (v > 0) rows.put(row, corners + 3 * (v - 1), lane, cell.gradient[v]);
    }
    rows.put(row, 4 * corners - 3, lane, cell.shape_stiffness);
    rows.put(row, 4 * corners - 2, lane, cell.volume_stiffness);
  }
  return spread.rows();
}

std::vector<bool> TermPacker::taken_cells() const {
  std::vector<bool> taken = shared_.cell_taken;
  for (std::size_t c = 0; c < taken.size(); ++c) taken[c] = taken[c] || found_.cell_taken[c];
  return taken;
}

int TermPacker::pack_simplices(int c, bool with_cell, Floats& to) {
  std::vector<Index> chosen;
  for (const Index s : simplices_[c]) {
    if ((shared_.all[s].cell != none) == with_cell) chosen.push_back(s);
  }
  const SpreadLanes spread(chosen.size(), body_.lanes);
  LaneRows rows(to, simd::simplex_columns, body_.lanes);
  rows.add(spread.rows(), 4);
  for (std::size_t k = 0; k < chosen.size(); ++k) {
    const Simplex& simplex = shared_.all[chosen[k]];
    const auto [row, lane] = spread.place(k);
    for (int v = 0; v < 4; ++v) rows.offset(row, v, lane, slots_.offset_of(simplex.vertex[v]));
    const auto constants = simplex_constants(t_, simplex);
    for (int m = 0; m < simplex_constant_count; ++m) rows.put(row, 4 + m, lane, constants[m]);
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
  fill_idle(body_.cells4, start.cell4, simd::cell_columns(4), 4, body_.lanes, idle);
  fill_idle(body_.cells6, start.cell6, simd::cell_columns(6), 6, body_.lanes, idle);
  fill_idle(body_.cells8, start.cell8, simd::cell_columns(8), 8, body_.lanes, idle);
  lattice_.fill_idle_lanes(c, idle);
  fill_idle(body_.simplices, start.simplex, simd::simplex_columns, 4, body_.lanes, idle);
  fill_idle(body_.cell_simplices, start.cell_simplex, simd::simplex_columns, 4, body_.lanes, idle);
}

void TermPacker::estimate_cost(int c) {
  Cluster& cluster = body_.clusters[c];
  const auto rows_since = [](const Offsets& first, std::size_t start) {
    return static_cast<double>(first.back() - first[start]);
  };
  const double base = body_.use == simd::BaseUse::attractor ? 25.0 : body_.use == simd::BaseUse::averaged ? 80.0 : 50.0;
  cluster.cost = base * rows_since(body_.base_first, starts_[c].base_slice) + triples_.cost(c) +
                 8.0 * rows_since(body_.spring_first, starts_[c].spring_slice) + 55.0 * cluster.job.volumes.count +
                 100.0 * (cluster.job.cells4.count + cluster.job.cells6.count + cluster.job.cells8.count) +
                 lattice_.cost(cluster.job) + 130.0 * cluster.job.simplices.count +
                 230.0 * cluster.job.cell_simplices.count + 20.0 * cluster.own / body_.lanes +
                 2.0 * static_cast<double>(cluster.halo.size());
}

void TermPacker::point_jobs() {
  for (std::size_t c = 0; c < body_.clusters.size(); ++c) {
    simd::Job& job = body_.clusters[c].job;
    const Start& start = starts_[c];
    job.exponent = narrow(t_.options.area_exponent);
    job.bases.first = body_.base_first.data() + start.base_slice;
    job.bases.rows = body_.bases.data();
    triples_.point(static_cast<int>(c), job);
    job.springs.first = body_.spring_first.data() + start.spring_slice;
    job.springs.rows = body_.springs.data();
    job.volumes.rows = body_.volumes.data() + start.volume;
    job.cells4.rows = body_.cells4.data() + start.cell4;
    job.cells6.rows = body_.cells6.data() + start.cell6;
    job.cells8.rows = body_.cells8.data() + start.cell8;
    lattice_.point(static_cast<int>(c), job);
    job.simplices.rows = body_.simplices.data() + start.simplex;
    job.cell_simplices.rows = body_.cell_simplices.data() + start.cell_simplex;
  }
}

}  // namespace phymul::cpu
