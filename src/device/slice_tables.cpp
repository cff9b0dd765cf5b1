// SPDX-License-Identifier: MIT
#include "slice_tables.h"

#include <phymul/error.h>

#include <algorithm>
#include <limits>
#include <string>
#include <utility>

#include "topology/locality_order.h"

namespace phymul {
namespace {

/// Particles whose order follows their own rows: few enough to lie near each other, enough that sorting leaves a
/// hundredth or so of padding. What others give back to a particle is another number than what it has itself where
/// bases are chosen one by one (irregular bodies); so in each few slices that have about as many rows of their own, the
/// gathered entries decide: 11 % of padding in all, where either sort alone leaves 27 to 58 %.
constexpr Index window = 4096, gathered_window = 256;

constexpr std::int64_t most_rows = std::numeric_limits<std::int32_t>::max();

/// Where FloatTables keeps one kind of rows: particle i's first one and their number.
struct Rows {
  Index first = 0, count = 0;
};

/// The lists of one particle in FloatTables.
class RowsOf {
 public:
  explicit RowsOf(const FloatTables& tables) : t_(tables) {}

  Rows neighbours(Index i) const { return {t_.index[i][1], t_.neighbour.empty() ? 0 : t_.index[i][0]}; }
  Rows bases(Index i) const { return {t_.index[i][3], t_.base.empty() ? 0 : t_.index[i][2]}; }
  Rows heights(Index i) const {
    if (t_.height.empty()) return {};
    const auto end = i + 1 < t_.particle_count ? t_.first_height[i + 1] : static_cast<Index>(t_.height.size());
    return {t_.first_height[i], end - t_.first_height[i]};
  }
  Rows list(Index i, std::size_t kind) const { return {t_.lists[i][kind], t_.lists[i + 1][kind] - t_.lists[i][kind]}; }

  Index links(Index i) const {
    Index count = 0;
    if (t_.domains.range.empty()) return count;
    for (Index d = i; d != none; d = t_.domains.range[d][3]) count += t_.domains.range[d][2] - t_.domains.range[d][0];
    return count;
  }

  Index own(Index i) const { return bases(i).count + heights(i).count + list(i, 2).count + links(i); }
  Index gathered(Index i) const { return list(i, 0).count + list(i, 1).count + list(i, 3).count; }

 private:
  const FloatTables& t_;
};

/// Lays lists side by side, slice by slice, and moves tables there.
class Interleaving {
 public:
  /// rows_of(i): the list of particle i in the tables as they come; `entries` of a row are numbered in 32 bits.
  template <class RowsOfParticle>
  Interleaving(const SliceTables& to, const char* name, std::int64_t entries, const RowsOfParticle& rows_of)
      : Interleaving(to.order, to.slice, name, entries, rows_of) {}

  /// Of something else than particles; order: as SliceTables::order.
  template <class RowsOfOne>
  Interleaving(const std::vector<Index>& order, int slice, const char* name, std::int64_t entries,
               const RowsOfOne& rows_of)
      : slice_(slice) {
    first_.reserve(order.size());
    range_.reserve(order.size());
    for (std::size_t place = 0; place < order.size(); place += static_cast<std::size_t>(slice_)) {
      Index longest = 0;
      for (Index lane = 0; lane < slice_; ++lane) {
        const Index i = order[place + static_cast<std::size_t>(lane)];
        const Rows rows = i == none ? Rows{} : rows_of(i);
        const std::int64_t end = rows_ + lane + std::int64_t{rows.count} * slice_;
        longest = std::max(longest, rows.count);
        require(name, end, entries);
        first_.push_back(rows.first);
        range_.push_back({static_cast<std::int32_t>(rows_ + lane), static_cast<std::int32_t>(end)});
      }
      rows_ += std::int64_t{longest} * slice_;
    }
    require(name, rows_, entries);
  }

  /// Gives up the list it took, once no more tables follow.
  std::vector<Int2> take_ranges() { return rows_ > 0 ? std::move(range_) : std::vector<Int2>{}; }
  Index rows() const { return static_cast<Index>(rows_); }

  /// visit(row here, row there) in order of place and, within a place, of its list.
  template <class Visit>
  void each(const Visit& visit) const {
    for (std::size_t place = 0; place < range_.size(); ++place) {
      Index from = first_[place];
      for (Index row = range_[place][0]; row < range_[place][1]; row += slice_) visit(row, from++);
    }
  }

  template <class Row>
  void move(std::vector<Row>& table, const Row& padding) const {
    if (table.empty()) return;
    std::vector<Row> moved(static_cast<std::size_t>(rows_), padding);
    each([&](Index row, Index from) { moved[row] = table[from]; });
    table = std::move(moved);
  }

 private:
  void require(const char* name, std::int64_t rows, std::int64_t entries) const {
    if (rows <= (most_rows - slice_) / entries) return;
    throw Error(
        ErrorCode::not_supported,
        "the sliced table of " + std::string(name) + " has " + std::to_string(rows) + " rows or more with slices of " +
            std::to_string(slice_) + " lanes; " + std::to_string((most_rows - slice_) / entries) +
            " fit 32-bit entries. Use fewer particles or a sparser base selection, or the backend \"reference\"");
  }

  std::int32_t slice_;
  std::int64_t rows_ = 0;
  std::vector<Index> first_;  // [places] in the table as it came
  std::vector<Int2> range_;   // [places]
};

constexpr Float4 no_floats{};

void assign_places(const TopologyTextures& topology, SliceTables& to) {
  const RowsOf rows_of(to.rows);
  const Index n = to.rows.particle_count;
  if (std::int64_t{n} + to.slice > most_rows) {
    throw Error(ErrorCode::not_supported, std::to_string(n) + " particles in slices of " + std::to_string(to.slice) +
                                              " do not fit " + std::to_string(most_rows) +
                                              " places. Use fewer particles");
  }
  std::vector<Index> own, gathered;
  for (Index i = 0; i < n; ++i) {
    own.push_back(rows_of.own(i));
    gathered.push_back(rows_of.gathered(i));
  }
  to.order = locality_order(topology.rest, own, window);
  sort_windows(to.order, gathered, gathered_window);
  to.place_of.resize(to.order.size());
  for (Index place = 0; place < n; ++place) to.place_of[to.order[place]] = place;
  to.order.resize(static_cast<std::size_t>((n + to.slice - 1) / to.slice * to.slice), none);
}

void rename(Index& particle, const SliceTables& to) {
  if (particle != none) particle = to.place_of[particle];
}

void move_particles(SliceTables& to) {
  std::vector<Float4> moved;
  moved.reserve(to.order.size());
  for (const Index i : to.order) moved.push_back(i == none ? no_floats : to.rows.particle[i]);
  to.rows.particle = std::move(moved);
}

void move_neighbours(SliceTables& to) {
  FloatTables& t = to.rows;
  if (t.neighbour.empty()) return;
  Interleaving lanes(to, "neighbours", 1, [rows_of = RowsOf(t)](Index i) { return rows_of.neighbours(i); });
  for (Index& j : t.neighbour) rename(j, to);
  lanes.move(t.neighbour, none);
  lanes.move(t.alpha, 0.0f);
  lanes.move(t.edge_alpha, no_floats);
  to.neighbours = lanes.take_ranges();
}

void move_heights(SliceTables& to) {
  if (to.rows.height.empty()) return;
  Interleaving lanes(to, "heights", 1, [rows_of = RowsOf(to.rows)](Index i) { return rows_of.heights(i); });
  lanes.move(to.rows.height, no_floats);
  to.heights = lanes.take_ranges();
}

/// Result: new row of each old one, for the reactions' entries.
std::vector<Index> move_bases(SliceTables& to) {
  FloatTables& t = to.rows;
  if (t.base.empty()) return {};
  Interleaving lanes(to, "bases", 4, [rows_of = RowsOf(t)](Index i) { return rows_of.bases(i); });
  std::vector<Index> row_of(t.reaction.empty() ? 0 : t.base.size());
  if (!row_of.empty()) lanes.each([&](Index row, Index from) { row_of[from] = row; });
  for (Int4& base : t.base) {
    for (std::size_t corner = 0; corner < 3; ++corner) rename(base[corner], to);
  }
  for (Int2& share : t.base_share) rename(share[0], to);
  lanes.move(t.base, Int4{none, none, none, 0});
  lanes.move(t.base_e1, no_floats);
  lanes.move(t.base_e2, no_floats);
  lanes.move(t.base_share, Int2{none, 0});
  t.base_count = lanes.rows();
  to.bases = lanes.take_ranges();
  return row_of;
}

/// Rows of `width` texels in a new order.
template <class Row>
void permute(std::vector<Row>& table, const std::vector<Index>& order, std::size_t width = 1) {
  std::vector<Row> moved;
  moved.reserve(table.size());
  for (const Index row : order) {
    const auto first = table.begin() + static_cast<std::ptrdiff_t>(static_cast<std::size_t>(row) * width);
    moved.insert(moved.end(), first, first + static_cast<std::ptrdiff_t>(width));
  }
  table = std::move(moved);
}

std::vector<Index> inverse(const std::vector<Index>& order) {
  std::vector<Index> row_of(order.size());
  for (std::size_t row = 0; row < order.size(); ++row) row_of[order[row]] = static_cast<Index>(row);
  return row_of;
}

std::vector<Index> move_volumes(SliceTables& to) {
  FloatTables& t = to.rows;
  for (Int4& volume : t.volume) {
    for (Index& v : volume) rename(v, to);
  }
  const std::vector<Index> order = order_by_least_vertex(
      t.volume_count, 4, [&](Index row, Index corner) { return t.volume[row][static_cast<std::size_t>(corner)]; });
  permute(t.volume, order);
  permute(t.volume_e1, order);
  permute(t.volume_e2, order);
  permute(t.volume_e3, order);
  return inverse(order);
}

std::vector<Index> move_walls(SliceTables& to) {
  FloatWalls& t = to.rows.walls;
  for (Int4& vertices : t.vertex) {
    for (Index& v : vertices) rename(v, to);
  }
  const std::vector<Index> order = order_by_least_vertex(t.count(), 6, [&](Index row, Index corner) {
    return t.vertex[2 * row + corner / 4][static_cast<std::size_t>(corner % 4)];
  });
  permute(t.vertex, order, 2);
  permute(t.law, order, FloatWalls::law_texels);
  return inverse(order);
}

/// Lists of entries row * corners + corner. `kind`: which of FloatTables::lists bounds them.
void move_entries(SliceTables& to, const char* name, std::size_t kind, const std::vector<Index>& row_of, Index corners,
                  std::vector<std::int32_t>& entries, std::vector<Int2>& ranges) {
  if (entries.empty()) return;
  Interleaving lanes(to, name, 1, [&, rows_of = RowsOf(to.rows)](Index i) { return rows_of.list(i, kind); });
  for (std::int32_t& entry : entries) entry = row_of[entry / corners] * corners + entry % corners;
  lanes.move(entries, none);
  ranges = lanes.take_ranges();
}

void move_shares(SliceTables& to) {
  if (to.rows.share.empty()) return;
  Interleaving lanes(to, "shares", 1, [rows_of = RowsOf(to.rows)](Index i) { return rows_of.list(i, 0); });
  for (Int2& share : to.rows.share) rename(share[0], to);
  lanes.move(to.rows.share, Int2{none, 0});
  to.reactions = lanes.take_ranges();
}

void move_springs(SliceTables& to) {
  FloatTables& t = to.rows;
  if (t.spring.empty()) return;
  Interleaving lanes(to, "springs", 1, [rows_of = RowsOf(t)](Index i) { return rows_of.list(i, 2); });
  for (Index& other : t.spring_other) rename(other, to);
  lanes.move(t.spring_other, none);
  lanes.move(t.spring, no_floats);
  to.springs = lanes.take_ranges();
}

/// Old number of each new one.
std::vector<Index> order_of_domains(const SliceTables& to) {
  const FloatDomains& domains = to.rows.domains;
  std::vector<Index> order = to.order;
  for (const Index i : to.order) {
    if (i == none) continue;
    for (Index d = domains.range[i][3]; d != none; d = domains.range[d][3]) order.push_back(d);
  }
  const auto slice = static_cast<std::size_t>(to.slice);
  order.resize((order.size() + slice - 1) / slice * slice, none);
  return order;
}

void move_domains(SliceTables& to) {
  FloatDomains& t = to.rows.domains;
  if (t.range.empty()) return;
  const std::vector<Index> order = order_of_domains(to);
  std::vector<Index> number_of(t.range.size());
  for (std::size_t k = 0; k < order.size(); ++k) {
    if (order[k] != none) number_of[order[k]] = static_cast<Index>(k);
  }
  Interleaving lanes(order, to.slice, "links", 1, [&](Index d) {
    return Rows{t.range[d][0], t.range[d][2] - t.range[d][0]};
  });
  for (Index& e : t.neighbour) e = number_of[e];
  lanes.move(t.neighbour, none);
  lanes.move(t.link, no_floats);
  const std::vector<Int2> rows = lanes.take_ranges();
  FloatDomains moved;
  for (std::size_t k = 0; k < order.size(); ++k) {
    const Index d = order[k];
    moved.range.push_back({none, none, none, none});
    for (Index row = 0; row < t.law_texels; ++row) {
      moved.law.push_back(d == none ? no_floats : t.law[t.law_texels * d + row]);
    }
    if (!t.owner.empty()) moved.owner.push_back(d == none ? none : to.place_of[t.owner[d]]);
    moved.source.push_back(d == none ? none : t.source[d]);
    moved.material.push_back(d == none ? none : t.material[d]);
    if (d == none) continue;
    const Int4& range = t.range[d];
    const Index next = range[3] == none ? none : number_of[range[3]];
    moved.range.back() = {rows[k][0], rows[k][0] + (range[1] - range[0]) * to.slice, rows[k][1], next};
  }
  t.range = std::move(moved.range);
  t.law = std::move(moved.law);
  t.owner = std::move(moved.owner);
  t.source = std::move(moved.source);
  t.material = std::move(moved.material);
}

}  // namespace

SliceTables pack_slices(FloatTables tables, const TopologyTextures& topology, int slice) {
  if (slice < 1 || slice > 1024) throw Error("a slice has 1 to 1024 lanes, not " + std::to_string(slice));
  SliceTables to;
  to.slice = slice;
  to.rows = std::move(tables);
  FloatTables& t = to.rows;
  assign_places(topology, to);
  move_particles(to);
  move_neighbours(to);
  move_heights(to);
  move_entries(to, "reactions", 0, move_bases(to), 4, t.reaction, to.reactions);
  move_shares(to);
  move_entries(to, "volumes", 1, move_volumes(to), 4, t.volume_entry, to.volumes);
  move_springs(to);
  move_entries(to, "walls", 3, move_walls(to), 8, t.walls.entries.entry, to.walls);
  move_domains(to);
  for (auto* spent : {&t.index, &t.lists}) std::vector<Int4>().swap(*spent);
  std::vector<std::int32_t>().swap(t.first_height);
  std::vector<Index>().swap(t.walls.entries.offset);
  return to;
}

}  // namespace phymul
