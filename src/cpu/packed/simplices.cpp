// SPDX-License-Identifier: MIT
#include "simplices.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

namespace phymul::cpu {
namespace {

/// Least |w|^2 of a face relative to the fourth power of the longest edge: with three particles nearer to a line than
/// that, a face without a base would have no normal to compute with.
constexpr double least_face = 1e-8;

enum class Kind { base, volume, cell };

struct Member {
  std::array<Index, 4> key;  // sorted
  Kind kind;
  Index row;
  Index owner;  // bases only
};

void add_member(std::array<Index, 4> key, Kind kind, Index row, Index owner, std::vector<Member>& members) {
  std::ranges::sort(key);
  const bool four = key[0] != none && key[0] != key[1] && key[1] != key[2] && key[2] != key[3];
  if (four) members.push_back({key, kind, row, owner});
}

std::vector<Member> members_of(const TopologyTextures& t) {
  std::vector<Member> members;
  members.reserve(static_cast<std::size_t>(t.base_count) + t.volumes.size());
  for (Index i = 0; i < t.particle_count; ++i) {
    const IndexTexel& at = t.index[i];
    for (Index b = at.first_base; b < at.first_base + at.base_count; ++b) {
      const auto& v = t.bases[b].vertex;
      add_member({i, v[0], v[1], v[2]}, Kind::base, b, i, members);
    }
  }
  for (std::size_t v = 0; v < t.volumes.size(); ++v) {
    add_member(t.volumes[v].vertex, Kind::volume, static_cast<Index>(v), none, members);
  }
  for (std::size_t c = 0; c < t.cells.size(); ++c) {
    const auto& v = t.cells[c].vertex;
    if (v[4] == none) add_member({v[0], v[1], v[2], v[3]}, Kind::cell, static_cast<Index>(c), none, members);
  }
  std::ranges::sort(members, [](const Member& a, const Member& b) {
    return std::tie(a.key, a.kind, a.row) < std::tie(b.key, b.kind, b.row);
  });
  return members;
}

bool has_four_faces(const TopologyTextures& t, const std::array<Index, 4>& v) {
  double longest = 0.0, least = std::numeric_limits<double>::max();
  for (int skipped = 0; skipped < 4; ++skipped) {
    const Vec3& a = t.rest[v[(skipped + 1) % 4]];
    const Vec3 e1 = t.rest[v[(skipped + 2) % 4]] - a, e2 = t.rest[v[(skipped + 3) % 4]] - a;
    longest = std::max({longest, e1.squaredNorm(), e2.squaredNorm()});
    least = std::min(least, e1.cross(e2).squaredNorm());
  }
  return least > least_face * longest * longest;
}

bool is_flat(const TopologyTextures& t, const std::array<Index, 4>& v) {
  const Vec3 e1 = t.rest[v[1]] - t.rest[v[0]], e2 = t.rest[v[2]] - t.rest[v[0]], e3 = t.rest[v[3]] - t.rest[v[0]];
  return std::abs(e1.cross(e2).dot(e3)) <= 1e-6 * e1.cross(e2).norm() * e3.norm();
}

/// One of each kind, or nothing: the same base twice stays outside.
bool fits(const std::vector<Member>& members, std::size_t first, std::size_t last, Simplex& simplex) {
  // Sorted; simplex_constants carries the sign of that order.
  simplex.vertex = members[first].key;
  for (std::size_t m = first; m < last; ++m) {
    const Member& member = members[m];
    if (member.kind == Kind::base) {
      const auto k = std::ranges::find(simplex.vertex, member.owner) - simplex.vertex.begin();
      if (simplex.base[k] != none) return false;
      simplex.base[k] = member.row;
    } else {
      Index& row = member.kind == Kind::volume ? simplex.volume : simplex.cell;
      if (row != none) return false;
      row = member.row;
    }
  }
  return true;
}

/// Of the base over the face opposite vertex k, whose normal by the vertices' order is W; others: the face's vertices
/// but 0.
void add_base(const TopologyTextures& t, const Simplex& simplex, int k, const Vec3& W, const std::vector<int>& others,
              double*& to) {
  const Index row = simplex.base[k];
  const double length = W.norm();
  double share = 0.0, height = 0.0;
  std::array<double, 4> lambda{};
  if (row != none) {
    const BaseTexel& base = t.bases[row];
    const Vec3& a = t.rest[base.vertex[0]];
    const Vec3 w = (t.rest[base.vertex[1]] - a).cross(t.rest[base.vertex[2]] - a);
    share = t.stiffness[simplex.vertex[k]] * t.weight[row];
    height = std::copysign(base.beta, base.beta * w.dot(W)) / length;
    for (int corner = 0; corner < 3; ++corner) {
      lambda[std::ranges::find(simplex.vertex, base.vertex[corner]) - simplex.vertex.begin()] = t.lambda[row][corner];
    }
  }
  *to++ = share;
  *to++ = height;
  *to++ = 1.0 / (length * length);
  for (const int v : others) *to++ = lambda[v];
}

}  // namespace

std::array<double, simplex_constant_count> simplex_constants(const TopologyTextures& t, const Simplex& simplex) {
  const auto& v = simplex.vertex;
  const Vec3 E1 = t.rest[v[1]] - t.rest[v[0]], E2 = t.rest[v[2]] - t.rest[v[0]], E3 = t.rest[v[3]] - t.rest[v[0]];
  const Vec3 C1 = E2.cross(E3), C2 = E3.cross(E1), C3 = E1.cross(E2);
  std::array<double, simplex_constant_count> constants{};
  double* to = constants.data();
  for (const Vec3& E : {E1, E2, E3}) to = std::copy_n(E.data(), 3, to);
  add_base(t, simplex, 1, C1, {2, 3}, to);
  add_base(t, simplex, 2, C2, {1, 3}, to);
  add_base(t, simplex, 3, C3, {1, 2}, to);
  add_base(t, simplex, 0, C1 + C2 + C3, {1, 2, 3}, to);
  const bool solid = simplex.volume != none || simplex.cell != none;
  *to++ = solid ? 1.0 / E1.dot(C1) : 0.0;
  *to++ = simplex.volume == none ? 0.0 : t.volumes[simplex.volume].stiffness;
  *to++ = simplex.cell == none ? 0.0 : t.cells[simplex.cell].shape_stiffness;
  *to++ = simplex.cell == none ? 0.0 : t.cells[simplex.cell].volume_stiffness;
  return constants;
}

Simplices find_simplices(const TopologyTextures& t) {
  Simplices found;
  found.base_taken.assign(static_cast<std::size_t>(t.base_count), false);
  found.volume_taken.assign(t.volumes.size(), false);
  found.cell_taken.assign(t.cells.size(), false);
  const bool plain = t.dimension == 3 && t.options.reaction == Reaction::conservative && t.rest_area.empty();
  if (!plain || t.base_count == 0) return found;
  const std::vector<Member> members = members_of(t);
  for (std::size_t first = 0, last = 0; first < members.size(); first = last) {
    while (last < members.size() && members[last].key == members[first].key) ++last;
    Simplex simplex;
    if (last - first < 2 || !fits(members, first, last, simplex) || !has_four_faces(t, simplex.vertex)) continue;
    if ((simplex.volume != none || simplex.cell != none) && is_flat(t, simplex.vertex)) continue;
    found.all.push_back(simplex);
    for (const Index b : simplex.base) {
      if (b != none) found.base_taken[b] = true;
    }
    if (simplex.volume != none) found.volume_taken[simplex.volume] = true;
    if (simplex.cell != none) found.cell_taken[simplex.cell] = true;
  }
  return found;
}

}  // namespace phymul::cpu
