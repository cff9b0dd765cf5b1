// SPDX-License-Identifier: MIT
//
// Where a body differs from the shape that it was filled from.
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <unordered_map>
#include <utility>
#include <vector>

#include "base/place_text.h"
#include "base/union_find.h"
#include "filling.h"

namespace phymul {
namespace {

/// Spacings: a place that is one from the body is so near to a particle or to the middle of a face at the surface.
constexpr double between = 1.1;

using Cube = std::array<std::int64_t, 3>;

struct HashOfCube {
  std::size_t operator()(const Cube& cube) const {
    std::uint64_t sum = 0;
    for (const std::int64_t k : cube) sum = (sum ^ static_cast<std::uint64_t>(k)) * 0x9e3779b97f4a7c15;
    return sum ^ sum >> 32;
  }
};

Cube cube_at(const Vec3& x, double edge) {
  return {std::llround(x.x() / edge), std::llround(x.y() / edge), std::llround(x.z() / edge)};
}

/// Itself first.
std::array<Cube, 27> cubes_around(const Cube& cube) {
  std::array<Cube, 27> all;
  for (int k = 0; k < 27; ++k) all[k] = {cube[0] + k % 3 - 1, cube[1] + k / 3 % 3 - 1, cube[2] + k / 9 - 1};
  std::swap(all[0], all[13]);
  return all;
}

std::string shells_text(const Surface& surface) {
  UnionFind sets(surface.vertices.size());
  std::vector<char> is_used(surface.vertices.size(), 0);
  std::vector<std::pair<Index, Index>> edges;
  int joined = 0, crowded = 0;
  for (const auto& t : surface.triangles) {
    for (int k = 0; k < 3; ++k) {
      is_used[t[k]] = 1;
      joined += sets.join(t[0], t[k]) ? 1 : 0;
      edges.push_back(std::minmax(t[k], t[(k + 1) % 3]));
    }
  }
  std::ranges::sort(edges);
  for (std::size_t i = 2; i < edges.size(); ++i) {
    crowded += edges[i] == edges[i - 2] && (i == 2 || edges[i] != edges[i - 3]) ? 1 : 0;
  }
  const auto used = std::ranges::count(is_used, 1);
  const auto distinct = std::unique(edges.begin(), edges.end()) - edges.begin();
  return "shells: " + std::to_string(used - joined) +
         ", Euler number: " + std::to_string(used - distinct + std::ssize(surface.triangles)) +
         ", edges of more than two faces: " + std::to_string(crowded);
}

}  // namespace

std::string lost_parts(const std::function<void(const Contains&)>& sample, const Surface& skin,
                       const BodyOptions& options) {
  const double edge = between * options.spacing;
  std::unordered_map<Cube, VecList, HashOfCube> near;  // particles and middles
  for (const Vec3& x : skin.vertices) near[cube_at(x, edge)].push_back(x);
  for (const auto& [a, b, c] : skin.triangles) {
    const Vec3 x = (skin.vertices[a] + skin.vertices[b] + skin.vertices[c]) / 3.0;
    near[cube_at(x, edge)].push_back(x);
  }
  const auto is_lost = [&](const Vec3& x) {
    const double reach = options.spacing_at ? std::min(edge, between * options.spacing_at(x)) : edge;
    return std::ranges::none_of(cubes_around(cube_at(x, edge)), [&](const Cube& cube) {
      const auto found = near.find(cube);
      return found != near.end() &&
             std::ranges::any_of(found->second, [&](const Vec3& p) { return (p - x).norm() <= reach; });
    });
  };
  std::map<Cube, Eigen::AlignedBox3d> cubes;  // around lost samples in cubes of a grid
  sample([&](const Vec3& x) {
    if (is_lost(x)) cubes[cube_at(x, edge)].extend(x);
    return true;
  });
  std::vector<std::pair<double, std::string>> parts;
  while (!cubes.empty()) {  // a part: cubes that touch
    Eigen::AlignedBox3d box;
    for (std::vector<Cube> next{cubes.begin()->first}; !next.empty();) {
      const Cube cube = next.back();
      next.pop_back();
      const auto found = cubes.find(cube);
      if (found == cubes.end()) continue;
      box.extend(found->second);
      cubes.erase(found);
      for (const Cube& other : cubes_around(cube)) next.push_back(other);
    }
    const double length = box.diagonal().norm(), digit = 1e-2 * options.spacing;
    const Vec3 middle = digit * ((box.center() / digit).array().round() + 0.0);
    parts.emplace_back(-length, length_text(length) + " m around " + place_text(middle));
  }
  std::ranges::sort(parts);
  std::string text;
  for (std::size_t k = 0; k < std::min<std::size_t>(parts.size(), 5); ++k) text += (k ? ", " : "") + parts[k].second;
  if (parts.size() > 5) text += " and " + std::to_string(parts.size() - 5) + " more";
  return text;
}

std::string fused_note(const Surface& surface, const Surface& skin) {
  const std::string own = shells_text(skin), wanted = shells_text(surface);
  if (own == wanted) return {};
  return "walls, gaps or holes narrower than the spacing are fused, closed or torn: the body's surface has " + own +
         "; the surface it fills has " + wanted;
}

}  // namespace phymul
