// SPDX-License-Identifier: MIT
//
// What a scene holds besides loads: volumes that are kept, and contacts.
#include <phymul/error.h>
#include <phymul/scene.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>

#include "base/decimal.h"
#include "model/enclosed_volume.h"
#include "model/group.h"
#include "model/require_indices.h"
#include "model/surface_facets.h"

namespace phymul {
namespace {

std::string label(const VolumeConstraint& surface) {
  return surface.applied_to.empty() ? "constrain_volume: " : "constrain_volume on \"" + surface.applied_to + "\": ";
}

/// Faces between these cells and others are surface too.
VolumeConstraint surface_of(const Model& cells, std::string_view group) {
  VolumeConstraint surface{outward_triangles(cells), 0.0, std::string(group)};
  surface.volume = enclosed_volume(surface.triangles, cells.rest);
  return surface;
}

/// Each edge is passed as often one way as the other.
void require_closed(const VolumeConstraint& surface, const Model& model) {
  std::map<std::array<Index, 2>, int> balance;
  for (const std::array<Index, 3>& t : surface.triangles) {
    for (int k = 0; k < 3; ++k) {
      const Index a = t[k], b = t[(k + 1) % 3];
      balance[{std::min(a, b), std::max(a, b)}] += a < b ? 1 : -1;
    }
  }
  for (const auto& [edge, sum] : balance) {
    if (sum == 0) continue;
    const auto name = [&](Index i) { return std::to_string(model.file_index(i)); };
    throw Error(label(surface) + "expected a closed surface, but its edge from particle " + name(edge[0]) + " to " +
                name(edge[1]) + " is open (or its two triangles are wound against each other); add the missing facets");
  }
}

void require_sound(const VolumeConstraint& surface, const Model& model, const std::vector<VolumeConstraint>& others) {
  if (model.dimension != 3) throw Error(label(surface) + "expected a three-dimensional model");
  if (surface.triangles.empty()) {
    throw Error(label(surface) + "expected particles whose cells have a surface (volume cells, triangles or quads)");
  }
  for (const std::array<Index, 3>& t : surface.triangles) {
    require_indices(t, model.rest.size(), "particles", [&] { return label(surface); });
  }
  require_closed(surface, model);
  if (!(surface.volume > 0.0) || !std::isfinite(surface.volume)) {
    throw Error(label(surface) + "expected a volume above 0, in m^3, and triangles counter-clockwise seen from " +
                "outside; got " + to_decimal(surface.volume));
  }
  std::vector<char> own(model.rest.size(), 0);
  for (const std::array<Index, 3>& t : surface.triangles) {
    for (const Index i : t) own[i] = 1;
  }
  for (const VolumeConstraint& other : others) {
    for (const std::array<Index, 3>& t : other.triangles) {
      for (const Index i : t) {
        if (!own[i]) continue;
        throw Error(label(surface) + "particle " + std::to_string(i) +
                    " belongs to another surface whose volume is kept; keep the volume of bodies that share none");
      }
    }
  }
}

}  // namespace

/// A triangle at no cell that is left opens its volume.
void Scene::find_open_volumes() {
  open_volumes_.assign(volume_constraints_.size(), 0);
  struct Side {
    std::array<Index, 3> corner;
    std::size_t volume;
    bool has_cell = false;
  };
  std::vector<Side> sides;
  for (std::size_t row = 0; row < volume_constraints_.size(); ++row) {
    for (const auto& triangle : volume_constraints_[row].triangles) sides.push_back({triangle, row});
  }
  if (sides.empty()) return;
  std::ranges::sort(sides, {}, [](const Side& side) { return side.corner[0]; });
  for (const Cell& cell : model_->cells) {
    if (cell.share == 0.0) continue;
    for (const Index i : cell.particles) {
      for (Side& side : std::ranges::equal_range(sides, i, {}, [](const Side& own) { return own.corner[0]; })) {
        side.has_cell = side.has_cell || std::ranges::all_of(side.corner, [&](Index corner) {
                          return std::ranges::find(cell.particles, corner) != cell.particles.end();
                        });
      }
    }
  }
  for (const Side& side : sides) {
    if (!side.has_cell) open_volumes_[side.volume] = 1;
  }
}

bool Scene::any_volume_open() const {
  return std::ranges::any_of(open_volumes_, [](char open) { return open != 0; });
}

Scene& Scene::constrain_volume() & {
  return constrain_volume(surface_of(*model_, ""));
}

Scene& Scene::constrain_volume(std::string_view group) & {
  return constrain_volume(surface_of(part_of(*model_, group), group));
}

Scene& Scene::constrain_volume(VolumeConstraint surface) & {
  require_sound(surface, *model_, volume_constraints_);
  volume_constraints_.push_back(std::move(surface));
  ++version_;
  return *this;
}

Scene& Scene::contacts(const ContactOptions& options) & {
  if (model_->dimension != 3) throw Error("contacts: expected a three-dimensional model");
  if (!(options.friction >= 0.0) || !std::isfinite(options.friction)) {
    throw Error("contacts: expected a finite coefficient of friction of 0 or more, got " +
                to_decimal(options.friction));
  }
  if (!(options.margin >= 0.0) || !std::isfinite(options.margin)) {
    throw Error("contacts: expected a finite margin in m (0: from the spacing), got " + to_decimal(options.margin));
  }
  if (options.rounds < 1) throw Error("contacts: expected 1 round or more, got " + std::to_string(options.rounds));
  contacts_ = options;
  ++version_;
  return *this;
}

Scene& Scene::no_contacts() {
  contacts_.reset();
  ++version_;
  return *this;
}

}  // namespace phymul
