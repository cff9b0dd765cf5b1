// SPDX-License-Identifier: MIT
//
// What a scene holds besides loads: volumes that are kept, and contacts.
#include <phymul/error.h>
#include <phymul/scene.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "base/decimal.h"
#include "model/closed_surface.h"
#include "model/group.h"
#include "model/outer_faces.h"
#include "scene_items.h"

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

void require_volume(double volume, const std::string& label,
                    const char* and_more = " and triangles counter-clockwise seen from outside") {
  if (volume > 0.0 && std::isfinite(volume)) return;
  throw Error(label + "expected a volume above 0, in m^3," + and_more + "; got " + to_decimal(volume));
}

void require_fluid(const Fluid& fluid, const std::string& label) {
  const auto require = [&](bool holds, const char* expected, double value) {
    if (!holds || !std::isfinite(value)) throw Error(label + "expected " + expected + ", got " + to_decimal(value));
  };
  require(fluid.outer_pressure > 0.0, "Fluid::outer_pressure above 0 Pa", fluid.outer_pressure);
  require(fluid.exponent >= 1.0, "Fluid::exponent of 1 or more", fluid.exponent);
  require(fluid.conductance >= 0.0, "Fluid::conductance of 0 m^3/(Pa s) or more", fluid.conductance);
  require(true, "a finite Fluid::outlet_pressure, Pa", fluid.outlet_pressure);
  if (fluid.law != FluidLaw::curve) return;
  if (fluid.curve.size() < 2) throw Error(label + "expected a Fluid::curve of two points or more");
  for (std::size_t k = 0; k < fluid.curve.size(); ++k) {
    const auto [r, p] = fluid.curve[k];
    const double before = k > 0 ? fluid.curve[k - 1][0] : 0.0;
    if (r > before && std::isfinite(r) && std::isfinite(p) && (k == 0 || p < fluid.curve[k - 1][1])) continue;
    throw Error(label + "expected points of Fluid::curve with rising ratios above 0 and falling pressures, got (" +
                to_decimal(r) + ", " + to_decimal(p) + ") as point " + std::to_string(k));
  }
}

/// `all`: volume constraints that there are.
void require_opening(const VolumeConstraint& own, const Fluid& fluid, const std::vector<VolumeConstraint>& all,
                     const std::string& label) {
  if (fluid.opens_into.empty()) return;
  if (fluid.opens_into == own.name) throw Error(label + "expected another volume in Fluid::opens_into, got its own");
  if (std::ranges::find(all, fluid.opens_into, &VolumeConstraint::name) == all.end()) {
    throw Error(ErrorCode::unknown_name, label + "Fluid::opens_into is \"" + fluid.opens_into +
                                             "\", which is no volume constraint of the scene; add that one first, or "
                                             "open this one later, by set_fluid");
  }
  if (fluid.outlet_pressure == 0.0) return;
  throw Error(label + "expected a Fluid::outlet_pressure of 0 with Fluid::opens_into, whose pressure is behind the " +
              "opening; got " + to_decimal(fluid.outlet_pressure));
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
  require_volume(surface.volume, label(surface));
  if (enclosed_volume(surface.triangles, model.rest) < -1e-6 * surface.volume) {
    throw Error(label(surface) +
                "expected triangles counter-clockwise seen from outside; at rest they are wound inward");
  }
  require_fluid(surface.fluid, label(surface));
  require_opening(surface, surface.fluid, others, label(surface));
  std::vector<char> own(model.rest.size(), 0);
  for (const std::array<Index, 3>& t : surface.triangles) {
    for (const Index i : t) own[i] = 1;
  }
  for (const VolumeConstraint& other : others) {
    if (other.name == surface.name) throw Error(label(surface) + "the name \"" + surface.name + "\" is in use");
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

/// A triangle that had a cell, and has none that is left, opens its volume. Lids of tubes never had one. Where a cell
/// was cut its parts have copies in place of its particles. Where the cut was undone copies have no mass.
void Scene::find_open_volumes() {
  open_volumes_.assign(volume_constraints_.size(), 0);
  if (open_volumes_.empty()) return;
  struct Side {
    std::array<Index, 3> corner;
    std::size_t volume;
    std::array<Index, 3> origin{};
    bool has_cell = false, had_cell = false;
  };
  std::vector<Index> origin(model_->rest.size());
  std::iota(origin.begin(), origin.end(), 0);
  for (const BodyCut::Copy& copy : copies_) origin[copy.particle] = origin[copy.of];
  std::vector<Side> sides;
  for (std::size_t row = 0; row < volume_constraints_.size(); ++row) {
    for (const auto& [a, b, c] : volume_constraints_[row].triangles) {
      sides.push_back({{a, b, c}, row, {origin[a], origin[b], origin[c]}});
    }
  }
  const auto first = [](const Side& side) { return side.origin[0]; };
  std::ranges::sort(sides, {}, first);
  for (const Cell& cell : model_->cells) {
    for (const Index i : cell.particles) {
      for (Side& side : std::ranges::equal_range(sides, origin[i], {}, first)) {
        const auto has = [&](Index corner) {
          return std::ranges::find(cell.particles, corner) != cell.particles.end();
        };
        const auto had = [&](Index corner) {
          return std::ranges::any_of(cell.particles, [&](Index own) { return origin[own] == corner; });
        };
        side.has_cell = side.has_cell || (cell.share > 0.0 && std::ranges::all_of(side.corner, has));
        side.had_cell = side.had_cell || std::ranges::all_of(side.origin, had);
      }
    }
  }
  for (const Side& side : sides) {
    const bool gone = std::ranges::any_of(side.corner, [&](Index i) { return model_->mass[i] == 0.0; });
    if (gone || (side.had_cell && !side.has_cell)) open_volumes_[side.volume] = 1;
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
  if (surface.name.empty()) surface.name = default_name("volume", next_volume_, volume_constraints_);
  require_sound(surface, *model_, volume_constraints_);
  ++next_volume_;
  surface.changes = ++volume_changes_;
  volume_constraints_.push_back(std::move(surface));
  if (body_version_ > 0) find_open_volumes();  // as it may be in a recording's scene
  ++version_;
  return *this;
}

VolumeConstraint& Scene::volume_named(std::string_view name) {
  return item_named(volume_constraints_, "volume constraint", name);
}

Scene& Scene::set_volume(std::string_view name, double volume) {
  VolumeConstraint& own = volume_named(name);
  require_volume(volume, "set_volume: \"" + own.name + "\": ", "");
  own.volume = volume;
  own.changes = ++volume_changes_;
  ++version_;
  return *this;
}

Scene& Scene::set_fluid(std::string_view name, Fluid fluid) {
  VolumeConstraint& own = volume_named(name);
  require_fluid(fluid, "set_fluid: \"" + own.name + "\": ");
  require_opening(own, fluid, volume_constraints_, "set_fluid: \"" + own.name + "\": ");
  own.fluid = std::move(fluid);
  ++version_;
  return *this;
}

Scene& Scene::remove_volume(std::string_view name) {
  const auto row = &volume_named(name) - volume_constraints_.data();
  for (const VolumeConstraint& other : volume_constraints_) {
    if (other.fluid.opens_into != name) continue;
    throw Error("remove_volume: \"" + other.name + "\" opens into \"" + other.fluid.opens_into +
                "\"; first close it or remove it: set_fluid, remove_volume");
  }
  volume_constraints_.erase(volume_constraints_.begin() + row);
  if (row < static_cast<std::ptrdiff_t>(open_volumes_.size())) open_volumes_.erase(open_volumes_.begin() + row);
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
