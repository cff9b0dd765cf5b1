// SPDX-License-Identifier: MIT
#include "grid_packer.h"

#include <algorithm>
#include <utility>

#include "packed_rows.h"

namespace phymul::cpu {
namespace {

using Node = LatticeFrame::Node;

constexpr int all_octants = 0xff, high_octant = 0x80;
/// Lanes that must have a star: below, gathering is cheaper than idling.
constexpr double least_used = 0.6;

Index rounded_up(Index value, Index unit) {
  return (value + unit - 1) / unit * unit;
}

}  // namespace

GridPacker::GridPacker(BoxLattice& boxes, const VecList& rest, const std::optional<LatticeFrame>& frame, Index size,
                       std::size_t clusters, PackedBody& body)
    : rest_(rest), frame_(frame), body_(body), starts_(clusters) {
  if (!frame_ || boxes.stars.empty()) return;
  find_boxes(boxes);
  taken_.assign(boxes.stars.size(), false);
  std::vector<std::vector<Index>> stars(clusters);
  for (std::size_t s = 0; s < boxes.stars.size(); ++s) {
    stars[boxes.stars[s].centre / size].push_back(static_cast<Index>(s));
  }
  plans_.resize(clusters);
  double used = 0.0, lanes = 0.0;
  for (std::size_t c = 0; c < clusters; ++c) {
    plan(boxes, stars[c], plans_[c]);
    for (const Row& row : plans_[c].rows) {
      lanes += body_.lanes;
      used += static_cast<double>(body_.lanes - std::ranges::count(row.star, none));
    }
  }
  if (used < least_used * lanes || used == 0.0) {
    plans_.clear();
    return;
  }
  octants_.resize(clusters);
  for (std::size_t c = 0; c < clusters; ++c) {
    auto& rows = plans_[c].rows;
    std::ranges::stable_partition(rows, [&](const Row& row) { return is_whole(boxes, row); });
    for (const Row& row : rows) {
      for (const Index s : row.star) octants_[c].push_back(s == none ? 0 : boxes.stars[s].octants);
    }
  }
  take(boxes);
}

void GridPacker::find_boxes(const BoxLattice& boxes) {
  std::map<Index, std::vector<Index>> at;
  for (std::size_t b = 0; b < boxes.boxes.size(); ++b) at[boxes.boxes[b].vertex[0]].push_back(static_cast<Index>(b));
  for (const Star& star : boxes.stars) {
    box_of_.push_back(none);
    if ((star.octants & high_octant) == 0) continue;
    const auto found = std::ranges::find_if(at[star.centre], [&](Index b) {
      const auto& v = boxes.boxes[b].vertex;
      return boxes.boxes[b].shape == star.shape && v[1] == star.spoke[1] && v[2] == star.spoke[3] &&
             v[4] == star.spoke[5];
    });
    if (found != at[star.centre].end()) box_of_.back() = *found;
  }
}

/// Empty where the star does not stand on the lattice.
std::vector<GridPacker::Member> GridPacker::members_of(const BoxLattice& boxes, Index s) const {
  const Star& star = boxes.stars[s];
  const std::optional<Node> centre = frame_->node_of(rest_[star.centre]);
  if (!centre || ((star.octants & high_octant) != 0 && box_of_[s] == none)) return {};
  std::vector<Member> members{{star.centre, *centre}};
  for (int k = 0; k < 6; ++k) {
    if (star.spoke[k] == none) continue;
    members.push_back({star.spoke[k], *centre});
    members.back().node[k / 2] += k % 2 != 0 ? 1 : -1;
  }
  for (int corner = 0; corner < 8 && box_of_[s] != none; ++corner) {
    members.push_back({boxes.boxes[box_of_[s]].vertex[corner], *centre});
    for (int a = 0; a < 3; ++a) members.back().node[a] += corner >> a & 1;
  }
  for (const Member& m : members) {
    if (frame_->node_of(rest_[m.particle]) != m.node) return {};
  }
  return members;
}

std::map<int, GridPacker::Piece> GridPacker::pieces_of(const BoxLattice& boxes, const std::vector<Index>& stars) const {
  std::map<int, Piece> pieces;
  for (const Index s : stars) {
    const std::vector<Member> members = members_of(boxes, s);
    if (members.empty()) continue;
    Piece& piece = pieces[frame_->tile_of(members[0].node)];
    if (piece.stars.empty()) piece.low = piece.high = members[0].node;
    piece.stars.push_back(s);
    for (const Member& m : members) {
      for (int a = 0; a < 3; ++a) {
        piece.low[a] = std::min(piece.low[a], m.node[a]);
        piece.high[a] = std::max(piece.high[a], m.node[a]);
      }
    }
  }
  return pieces;
}

void GridPacker::plan(const BoxLattice& boxes, const std::vector<Index>& stars, Plan& to) {
  std::map<int, Piece> pieces = pieces_of(boxes, stars);
  const auto [line, side, last] = frame_->axes();
  int line_nodes = 1, side_nodes = 1;
  for (const auto& [tile, piece] : pieces) {
    line_nodes = std::max(line_nodes, piece.high[line] - piece.low[line] + 1);
    side_nodes = std::max(side_nodes, piece.high[side] - piece.low[side] + 1);
  }
  to.stride[line] = 1;
  to.stride[side] = line_nodes;
  to.stride[last] = line_nodes * side_nodes;
  std::map<int, std::map<std::int32_t, Index>> star_at;  // by shape
  for (auto& [tile, piece] : pieces) {
    piece.first = static_cast<std::int32_t>(to.particle.size());
    const Index nodes = to.stride[last] * (piece.high[last] - piece.low[last] + 1);
    to.particle.resize(to.particle.size() + rounded_up(nodes, body_.lanes), none);
    for (const Index s : piece.stars) {
      if (!enter(boxes, s, piece, to)) continue;
      const Node centre = *frame_->node_of(rest_[boxes.stars[s].centre]);
      std::int32_t node = piece.first;
      for (int a = 0; a < 3; ++a) node += (centre[a] - piece.low[a]) * to.stride[a];
      taken_[s] = star_at[boxes.stars[s].shape].try_emplace(node, s).second;
    }
  }
  for (const auto& [shape, at] : star_at) add_rows(shape, at, to);
}

/// Whether no other particle stands where the star needs its own.
bool GridPacker::enter(const BoxLattice& boxes, Index s, const Piece& piece, Plan& to) const {
  const std::vector<Member> members = members_of(boxes, s);
  const auto at = [&](const Member& m) -> Index& {
    std::int32_t node = piece.first;
    for (int a = 0; a < 3; ++a) node += (m.node[a] - piece.low[a]) * to.stride[a];
    return to.particle[node];
  };
  for (const Member& m : members) {
    if (at(m) != none && at(m) != m.particle) return false;
  }
  for (const Member& m : members) at(m) = m.particle;
  return true;
}

void GridPacker::add_rows(int shape, const std::map<std::int32_t, Index>& star_at, Plan& to) const {
  std::int32_t end = -1;
  for (const auto& [node, star] : star_at) {
    if (node >= end) {
      to.rows.push_back({node, shape, std::vector<Index>(static_cast<std::size_t>(body_.lanes), none)});
      end = node + body_.lanes;
    }
    to.rows.back().star[node - to.rows.back().node] = star;
  }
}

bool GridPacker::is_whole(const BoxLattice& boxes, const Row& row) const {
  return std::ranges::all_of(row.star, [&](Index s) { return s != none && boxes.stars[s].octants == all_octants; });
}

void GridPacker::take(BoxLattice& boxes) const {
  std::vector<bool> box_taken(boxes.boxes.size(), false);
  std::vector<Star> stars;
  for (std::size_t s = 0; s < boxes.stars.size(); ++s) {
    if (!taken_[s]) {
      stars.push_back(boxes.stars[s]);
    } else if (box_of_[s] != none) {
      box_taken[box_of_[s]] = true;
    }
  }
  std::vector<Hexahedron> others;
  for (std::size_t b = 0; b < boxes.boxes.size(); ++b) {
    if (!box_taken[b]) others.push_back(boxes.boxes[b]);
  }
  boxes.stars = std::move(stars);
  boxes.boxes = std::move(others);
}

void GridPacker::pack(int c, Slots& slots) {
  starts_[c] = {body_.grid_slot.size(), body_.grid_rows.size()};
  if (plans_.empty()) return;
  const Plan& plan = plans_[c];
  simd::Grid& grid = body_.clusters[c].job.grid;
  for (const Index i : plan.particle) body_.grid_slot.push_back(i == none ? unclaimed : slots.offset_of(i));
  const std::vector<std::int32_t>& octants = octants_[c];
  const auto lanes = static_cast<std::size_t>(body_.lanes);
  for (std::size_t r = 0; r < plan.rows.size(); ++r) {
    const auto begin = octants.begin() + static_cast<std::ptrdiff_t>(r * lanes), end = begin + body_.lanes;
    grid.whole += std::all_of(begin, end, [](std::int32_t o) { return o == all_octants; });
    const bool boxes = std::any_of(begin, end, [](std::int32_t o) { return (o & high_octant) != 0; });
    body_.grid_rows.push_back({plan.rows[r].node, plan.rows[r].shape, boxes});
    body_.grid_octants.insert(body_.grid_octants.end(), begin, end);
  }
  for (int a = 0; a < 3; ++a) grid.stride[a] = plan.stride[a];
  grid.nodes = static_cast<int>(plan.particle.size());
  grid.count = static_cast<int>(plan.rows.size());
  grid.margin = rounded_up(plan.stride[0] + plan.stride[1] + plan.stride[2] + body_.lanes, body_.lanes);
  grid.pitch = grid.nodes + 2 * grid.margin;
}

void GridPacker::fill_idle_lanes(int c, std::int32_t idle) {
  for (std::size_t k = starts_[c].slot; k < body_.grid_slot.size(); ++k) {
    if (body_.grid_slot[k] == unclaimed) body_.grid_slot[k] = idle;
  }
}

void GridPacker::point(int c, simd::Job& job) const {
  job.grid.slot = body_.grid_slot.data() + starts_[c].slot;
  job.grid.rows = body_.grid_rows.data() + starts_[c].row;
  job.grid.octants = body_.grid_octants.data() + starts_[c].row * static_cast<std::size_t>(body_.lanes);
}

double GridPacker::cost(const simd::Job& job) const {
  return 250.0 * job.grid.count + 10.0 * job.grid.nodes / body_.lanes;
}

}  // namespace phymul::cpu
