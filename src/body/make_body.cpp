// SPDX-License-Identifier: MIT
//
// Bodies of one region: what is asked of their shapes. Where a body differs from the shape that it was filled from.
#include <phymul/body.h>
#include <phymul/error.h>
#include <phymul/surface.h>
#include <phymul/surface_patch.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <unordered_map>
#include <utility>
#include <vector>

#include "base/box_tree.h"
#include "base/decimal.h"
#include "base/union_find.h"
#include "filling.h"
#include "interior.h"
#include "model/closed_surface.h"

namespace phymul {

SpacingField fine_near(const Vec3& place, double radius, double fine, double coarse, double growth) {
  const auto refuse = [](const std::string& what) { throw Error("fine_near: expected " + what); };
  if (!place.allFinite()) refuse("a finite place, got " + place_text(place));
  for (const auto& [name, value] : {std::pair{"radius", radius}, {"growth", growth}}) {
    if (value > 0.0 && std::isfinite(value)) continue;
    refuse(std::string("a ") + name + " above 0, got " + length_text(value));
  }
  if (!(fine > 0.0 && fine <= coarse && std::isfinite(coarse))) {
    refuse("0 < fine <= coarse, both in m, got " + length_text(fine) + " and " + length_text(coarse));
  }
  return [=](const Vec3& x) { return std::min(coarse, fine + growth * std::max(0.0, (x - place).norm() - radius)); };
}

Model make_body(const Surface& surface, const BodyOptions& options, BodyReport* report) {
  Surface mended = surface;
  mend_surface(mended);
  const Eigen::AlignedBox3d box = bounding_box(mended.vertices);
  const CentredLattice lattice = lattice_over(box.min(), box.max(), options);
  const double volume = enclosed_volume(mended.triangles, mended.vertices);
  BodyReport own;
  Model model = filled_body(
      SurfaceInterior(mended, lattice), lattice, [&](bool) { return volume; }, options, own);
  const Surface skin{model.rest, surface_triangles(model), {}};
  const auto sample = [&](const Contains& see) { sample_surface(mended, 0.5 * options.spacing, see); };
  const std::string lost = lost_parts(sample, skin, options), fused = fused_note(mended, skin);
  require_volume(own, options, [&] { return lost.empty() ? fused : lost; });
  if (report) *report = own;
  const auto note = [&](const std::string& what) {
    model.notes.push_back("make_body: " + what + "; take a smaller spacing than " + length_text(options.spacing) +
                          " m, or a finer one there (BodyOptions::spacing_at, fine_near)");
  };
  if (!lost.empty()) note("the body lacks parts of the surface, farther than a spacing from it: " + lost);
  if (!fused.empty()) note(fused);
  model.notes.insert(model.notes.begin(), mended.notes.begin(), mended.notes.end());
  return model;
}

Model make_body(const Solid& solid, const BodyOptions& options, BodyReport* report) {
  if (!solid.distance) refuse_body("the solid has no distance function");
  if (!solid.low.allFinite() || !solid.high.allFinite() || !(solid.low.array() < solid.high.array()).all()) {
    refuse_body("expected a finite box with low below high, got " + place_text(solid.low) + " to " +
                place_text(solid.high));
  }
  const CentredLattice lattice = lattice_over(solid.low, solid.high, options);
  const SolidInterior interior(solid);
  BodyReport own;
  Model model = filled_body(
      interior, lattice, [&](bool is_graded) { return interior.volume(lattice, is_graded); }, options, own);
  require_volume(own, options, {});
  if (report) *report = own;
  return model;
}

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
