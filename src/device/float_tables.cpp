// SPDX-License-Identifier: MIT
#include "float_tables.h"

#include <phymul/error.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>
#include <string>

#include "float_range.h"
#include "topology/transpose.h"

namespace phymul {
namespace {

void pack_law(const WallTexel& wall, std::vector<Float4>& law) {
  law.push_back(texel(wall.tangent[0], wall.shear));
  law.push_back(texel(wall.tangent[1], wall.compliance));
  for (std::size_t ab = 0; ab < 3; ++ab) law.push_back(texel(wall.second[ab], wall.bending[ab]));
  const auto twist = [&](std::size_t vertex) { return wall.hessian[vertex][2]; };
  for (std::size_t k = 1; k < 6; ++k) {
    law.push_back(texel({wall.gradient[k][0], wall.gradient[k][1], wall.hessian[k][0]}, wall.hessian[k][1]));
  }
  law.push_back(texel({twist(1), twist(2), twist(3)}, twist(4)));
  law.push_back(texel({twist(5), wall.bending[3], wall.bending[4]}, wall.bending[5]));
}

constexpr std::size_t most_entries = static_cast<std::size_t>(std::numeric_limits<std::int32_t>::max());

void require_entries(std::size_t rows, std::size_t entries_a_row, const char* table) {
  if (rows <= most_entries / entries_a_row) return;
  throw Error(ErrorCode::not_supported,
              "the float table of " + std::string(table) + " has " + std::to_string(rows) + " rows; " +
                  std::to_string(most_entries / entries_a_row) +
                  " fit 32-bit entries. Use fewer particles or a sparser base selection, or the backend \"reference\"");
}

std::int32_t narrow_bits(double value) {
  return bits_of(narrow(value));
}

void pack_particles(const TopologyTextures& from, FloatTables& to) {
  for (Index i = 0; i < from.particle_count; ++i) {
    to.particle.push_back({narrow(from.mass[i] > 0.0 ? 1.0 / from.mass[i] : 0.0),
                           narrow(from.stiffness.empty() ? 0.0 : from.stiffness[i]), narrow(from.mass[i]), 0.0f});
    const IndexTexel& at = from.index[i];
    to.index.push_back({at.neighbour_count, at.first_neighbour, at.base_count, at.first_base});
  }
}

void pack_base(const TopologyTextures& from, Index owner, Index t, FloatTables& to) {
  const BaseTexel& base = from.bases[t];
  const bool plane = from.dimension == 2;
  const Vec3& at = from.rest[base.vertex[0]];
  const Vec3 E1 = from.rest[base.vertex[1]] - at;
  const Vec3 E2 = plane ? Vec3(Vec3::Zero()) : Vec3(from.rest[base.vertex[2]] - at);
  require_base_in_range(plane ? E1.squaredNorm() : E1.cross(E2).squaredNorm(), owner);
  const bool conservative = from.options.reaction == Reaction::conservative;
  to.base.push_back({base.vertex[0], base.vertex[1], base.vertex[2], narrow_bits(base.beta)});
  to.base_e1.push_back(texel(E1, from.lambda[t][1]));
  to.base_e2.push_back(texel(E2, plane ? 0.0 : from.lambda[t][2]));
  to.base_share.push_back({owner, narrow_bits(conservative ? from.stiffness[owner] * from.weight[t] : from.weight[t])});
}

void pack_bases(const TopologyTextures& from, FloatTables& to) {
  require_entries(static_cast<std::size_t>(from.base_count), 4, "bases");
  to.base_count = from.base_count;
  for (Index i = 0; i < from.particle_count; ++i) {
    const IndexTexel& at = from.index[i];
    for (Index t = at.first_base; t < at.first_base + at.base_count; ++t) pack_base(from, i, t, to);
  }
}

void pack_neighbours(const TopologyTextures& from, FloatTables& to) {
  to.neighbour.assign(from.neighbours.begin(), from.neighbours.begin() + from.neighbour_count);
  if (to.layout == FloatLayout::table) {
    for (Index r = 0; r < from.neighbour_count; ++r) to.alpha.push_back(narrow(from.alpha[r]));
    return;
  }
  for (Index i = 0; i < from.particle_count; ++i) {
    const IndexTexel& at = from.index[i];
    for (Index r = at.first_neighbour; r < at.first_neighbour + at.neighbour_count; ++r) {
      to.edge_alpha.push_back(texel(from.rest[from.neighbours[r]] - from.rest[i], from.alpha[r]));
    }
  }
}

void require_enumerable(const TopologyTextures& from) {
  if (can_enumerate(from)) return;
  throw Error(
      ErrorCode::not_supported,
      "bases can be enumerated from the neighbours only in 3-D with BaseSelection::all and Reaction::full, shared or "
      "barycentric; take BaseLayout::table or automatic, or change the topology's options");
}

/// beta w of all triples j < k < l of particle i's neighbour rows. BaseSelection::all keeps that order and leaves out
/// triples without a plane.
void pack_heights_of(const TopologyTextures& from, Index i, FloatTables& to) {
  const IndexTexel& at = from.index[i];
  const Index* n = from.neighbours.data() + at.first_neighbour;
  Index t = at.first_base;
  const Index end = at.first_base + at.base_count;
  std::size_t filled = 0;
  for (Index j = 0; j < at.neighbour_count; ++j) {
    for (Index k = j + 1; k < at.neighbour_count; ++k) {
      for (Index l = k + 1; l < at.neighbour_count; ++l) {
        if (filled % 4 == 0) to.height.push_back({0.0f, 0.0f, 0.0f, 0.0f});
        const bool is_base = t < end && from.bases[t].vertex == std::array<Index, 3>{n[j], n[k], n[l]};
        if (is_base) {
          const Vec3 E1 = from.rest[n[k]] - from.rest[n[j]], E2 = from.rest[n[l]] - from.rest[n[j]];
          require_base_in_range(E1.cross(E2).squaredNorm(), i);
          to.height.back()[filled % 4] = narrow(from.weight[t] * from.bases[t].beta);
          ++t;
        }
        ++filled;
      }
    }
  }
  if (t != end) throw Error("bases of particle " + std::to_string(i) + " are not triples of its neighbours in order");
}

void pack_heights(const TopologyTextures& from, FloatTables& to) {
  for (Index i = 0; i < from.particle_count; ++i) {
    require_entries(to.height.size(), 4, "heights");
    to.first_height.push_back(static_cast<std::int32_t>(to.height.size()));
    if (from.index[i].base_count > 0) pack_heights_of(from, i, to);
  }
  require_entries(to.height.size(), 4, "heights");
}

void pack_shares(const TopologyTextures& from, FloatTables& to) {
  for (const Index row : from.neighbour_of.entry) {
    const Index owner = from.neighbour_owner[row];
    const double share = from.options.reaction == Reaction::full     ? 1.0
                         : from.options.reaction == Reaction::shared ? 1.0 / from.index[owner].neighbour_count
                                                                     : from.alpha[row];
    to.share.push_back({owner, narrow_bits(share)});
  }
  for (const Index entry : from.base_of.entry) to.reaction.push_back(entry / 3 * 4 + entry % 3);
}

void pack_volumes(const TopologyTextures& from, FloatTables& to) {
  to.volume_count = static_cast<Index>(from.volumes.size());
  for (const VolumeTexel& term : from.volumes) {
    const Vec3& at = from.rest[term.vertex[0]];
    const auto edge = [&](std::size_t corner) {
      return term.vertex[corner] == none ? Vec3(Vec3::Zero()) : Vec3(from.rest[term.vertex[corner]] - at);
    };
    to.volume.push_back(term.vertex);
    to.volume_e1.push_back(texel(edge(1), term.inverse_rest_volume / (from.dimension == 2 ? 2.0 : 6.0)));
    to.volume_e2.push_back(texel(edge(2), term.stiffness));
    to.volume_e3.push_back(texel(edge(3), 0.0));
  }
  to.volume_entry = from.volume_of.entry;
}

void pack_springs(const TopologyTextures& from, FloatTables& to) {
  for (const Index entry : from.spring_of.entry) {
    const SpringTexel& spring = from.springs[static_cast<std::size_t>(entry / 2)];
    const Index self = spring.end[static_cast<std::size_t>(entry % 2)];
    const Index other = spring.end[static_cast<std::size_t>(1 - entry % 2)];
    to.spring_other.push_back(other);
    to.spring.push_back(texel(from.rest[other] - from.rest[self], spring.stiffness));
  }
}

void pack_lists(const TopologyTextures& from, FloatTables& to) {
  const auto row = [](const RaggedList& list, Index i) { return list.entry.empty() ? 0 : list.offset[i]; };
  const RaggedList& reaction = from.neighbour_of.entry.empty() ? from.base_of : from.neighbour_of;
  for (Index i = 0; i <= from.particle_count; ++i) {
    to.lists.push_back({row(reaction, i), row(from.volume_of, i), row(from.spring_of, i), row(to.walls.entries, i)});
  }
}

/// Adds those of Law::particle_averaged: the links of a domain and its seven directions, and what is gathered from
/// them and from walls.
void count_domain_turns(const FloatDomains& domains, const FloatWalls& walls, Index particles, LoopTurns& most) {
  for (Index i = 0; i < std::min(particles, domains.count()); ++i) {
    std::int64_t gathered = walls.count() > 0 ? walls.entries.size(i) : 0;
    for (Index d = i; d != none; d = domains.range[d][3]) {
      const std::int64_t links = domains.range[d][2] - domains.range[d][0];
      most.own = std::max(most.own, links + 7);
      gathered += links + 1;
    }
    most.gathered = std::max(most.gathered, gathered);
  }
}

/// Upper bounds: of triples that three nested loops count, all turns of all three.
LoopTurns count_turns(const TopologyTextures& from, const FloatWalls& walls, FloatLayout layout) {
  LoopTurns most;
  const bool conservative = from.options.reaction == Reaction::conservative;  // gathers its own bases; no attractor
  const auto length = [](const RaggedList& list, Index i) {
    return list.entry.empty() ? std::int64_t{0} : std::int64_t{list.offset[i + 1]} - list.offset[i];
  };
  for (Index i = 0; i < from.particle_count; ++i) {
    const std::int64_t n = from.index[i].neighbour_count, bases = from.index[i].base_count;
    const std::int64_t triples = n * (n - 1) / 2 * (n - 2) / 3;
    const std::int64_t attractor = layout == FloatLayout::enumerated ? 2 * n + n * n / 2 + triples : n + bases;
    const std::int64_t own = conservative ? 0 : attractor;
    const std::int64_t gathered = (conservative ? bases : 0) + length(from.neighbour_of, i) + length(from.base_of, i) +
                                  length(from.volume_of, i) + length(from.spring_of, i) + length(walls.entries, i);
    most = {std::max(most.own, own), std::max(most.gathered, gathered)};
  }
  return most;
}

/// Bytes that the two layouts do not share; see FloatTables.
bool enumerated_is_smaller(const TopologyTextures& topology) {
  double triples = 0.0;
  for (const IndexTexel& at : topology.index) {
    const double n = at.neighbour_count;
    triples += n * (n - 1.0) * (n - 2.0) / 6.0;
  }
  const double table = sizeof(Int4) + 2 * sizeof(Float4) + sizeof(Int2);
  return triples * sizeof(float) + topology.neighbour_count * (sizeof(Float4) - sizeof(float)) <
         topology.base_count * table;
}

}  // namespace

FloatWalls pack_walls(const TopologyTextures& topology) {
  FloatWalls to;
  std::vector<const WallTexel*> walls;
  for (const WallTexel& wall : topology.walls) {
    if (wall.shear != 0.0) walls.push_back(&wall);
  }
  if (walls.empty()) return to;
  for (const WallTexel* const wall : walls) {
    std::array<Index, 6> v = wall->vertex;
    std::ranges::replace(v, none, v[0]);
    to.vertex.push_back({v[0], v[1], v[2], v[3]});
    to.vertex.push_back({v[4], v[5], none, none});
    pack_law(*wall, to.law);
  }
  to.entries = transpose(topology.particle_count, to.count(), 8, [&](Index row, Index corner) {
    return corner < 6 ? walls[row]->vertex[static_cast<std::size_t>(corner)] : none;
  });
  return to;
}

FloatEntries::FloatEntries(const FloatTables& tables) : rows(tables.reaction) {
  const auto append = [this](const std::vector<std::int32_t>& list) {
    const std::size_t start = rows.size();
    rows.insert(rows.end(), list.begin(), list.end());
    if (rows.size() > most_entries) {
      throw Error(ErrorCode::not_supported, "the lists of who meets which term have " + std::to_string(rows.size()) +
                                                " rows together; a shader counts to 2147483647");
    }
    return static_cast<int>(start);
  };
  volume_start = append(tables.volume_entry);
  spring_start = append(tables.spring_other);
  wall_start = append(tables.walls.entries.entry);
}

bool can_enumerate(const TopologyTextures& topology) {
  const TopologyOptions& o = topology.options;
  const bool shares =
      o.reaction == Reaction::full || o.reaction == Reaction::shared || o.reaction == Reaction::barycentric;
  return topology.dimension == 3 && o.law == Law::shape_memory && o.bases == BaseSelection::all && shares;
}

FloatTables pack_floats(const TopologyTextures& topology, FloatLayout layout) {
  FloatTables tables;
  tables.options = topology.options;
  tables.layout = layout;
  tables.dimension = topology.dimension;
  tables.particle_count = topology.particle_count;
  pack_particles(topology, tables);
  if (layout == FloatLayout::enumerated) require_enumerable(topology);
  if (topology.base_count > 0) {
    if (layout == FloatLayout::table) pack_bases(topology, tables);
    if (layout == FloatLayout::enumerated) pack_heights(topology, tables);
    if (topology.options.reaction != Reaction::conservative) pack_neighbours(topology, tables);
  }
  pack_shares(topology, tables);
  pack_volumes(topology, tables);
  pack_springs(topology, tables);
  tables.domains = pack_domains(topology);
  require_entries(topology.walls.size(), FloatWalls::law_texels, "walls");
  tables.walls = pack_walls(topology);
  pack_lists(topology, tables);
  tables.turns = count_turns(topology, tables.walls, layout);
  count_domain_turns(tables.domains, tables.walls, tables.particle_count, tables.turns);
  return tables;
}

FloatLayout choose_layout(BaseLayout wish, const TopologyTextures& topology) {
  if (wish == BaseLayout::enumerated) return FloatLayout::enumerated;  // pack_floats refuses what cannot be
  const bool automatic = wish == BaseLayout::automatic;
  return automatic && topology.base_count > 0 && can_enumerate(topology) && enumerated_is_smaller(topology)
             ? FloatLayout::enumerated
             : FloatLayout::table;
}

}  // namespace phymul
