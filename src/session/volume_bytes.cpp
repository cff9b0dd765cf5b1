// SPDX-License-Identifier: MIT
#include "scene_bytes.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "wire_codes.h"

namespace phymul {
namespace {

// What a thing is made of, for a ByteWriter and a thing that is const, or a ByteReader and one that is not.

template <class Bytes, class Kept>
void volume_fields(Bytes& bytes, Kept& all) {
  bytes.list(all, 20, "a number of kept volumes", [&](auto& surface) {
    bytes.field(surface.volume, "a volume");
    bytes.field(surface.applied_to, "a group's name");
    bytes.list(surface.triangles, 12, "a number of triangles", [&](auto& triangle) {
      for (auto& i : triangle) bytes.field(i, "a particle");
    });
  });
}

void fluid_law_fields(ByteWriter& out, const Fluid& fluid) {
  const bool opens = !fluid.opens_into.empty();
  code(out, static_cast<FluidLaw>(static_cast<int>(fluid.law) + (opens ? into_another : 0)), "");
  if (opens) out.text(fluid.opens_into);
}

void fluid_law_fields(ByteReader& in, Fluid& fluid) {
  code(in, fluid.law, "a law of a fluid");
  if (static_cast<int>(fluid.law) < into_another) return;
  fluid.law = static_cast<FluidLaw>(static_cast<int>(fluid.law) - into_another);
  fluid.opens_into = in.text("a volume's name");
}

/// What volume_fields() has not, of which files were written before constraints had it.
template <class Bytes, class Constraint>
void fluid_fields_of(Bytes& bytes, Constraint& kept) {
  bytes.field(kept.name, "a name");
  fluid_law_fields(bytes, kept.fluid);
  for (auto* value :
       {&kept.fluid.outer_pressure, &kept.fluid.exponent, &kept.fluid.conductance, &kept.fluid.outlet_pressure}) {
    bytes.field(*value, "a constant of a fluid");
  }
  bytes.list(kept.fluid.curve, 16, "a number of points", [&](auto& point) {
    for (auto& value : point) bytes.field(value, "a point of a curve");
  });
}

/// A volume in a change: of one that stays no triangles.
struct VolumeChange {
  std::vector<VolumeConstraint> kept{1};
  bool is_new = true, is_set = false;
};

template <class Bytes, class Change>
void change_fields(Bytes& bytes, Change& change) {
  bytes.field(change.is_new, "whether a volume is new");
  bytes.field(change.is_set, "whether a volume is set");
  volume_fields(bytes, change.kept);
  for (auto& kept : change.kept) fluid_fields_of(bytes, kept);
}

}  // namespace

void put_volumes(ByteWriter& out, const Scene& scene, std::span<const VolumeConstraint> before) {
  std::vector<VolumeChange> all;
  // A replay keeps the order of the volumes that it has, and appends new ones: so does this list. A volume that was
  // removed and constrained again counts as new.
  auto first = before.begin();
  for (const VolumeConstraint& kept : scene.volume_constraints()) {
    const auto known = std::find_if(first, before.end(), [&](const auto& other) { return other.name == kept.name; });
    VolumeChange& change = all.emplace_back();
    change.kept = {kept};
    change.is_new = known == before.end() || known->triangles != kept.triangles;
    change.is_set = !change.is_new && known->changes != kept.changes;
    first = change.is_new ? before.end() : known + 1;
    if (!change.is_new) change.kept.front().triangles.clear();
  }
  out.list(std::as_const(all), 0, "", [&](const VolumeChange& change) { change_fields(out, change); });
}

void take_volumes(ByteReader& in, Scene& scene) {
  std::vector<VolumeChange> all;
  in.list(all, 30, "a number of volumes", [&](VolumeChange& change) { change_fields(in, change); });
  std::vector<std::string> gone;
  // None opens into another until all are there.
  for (const VolumeConstraint& known : scene.volume_constraints()) {
    if (known.fluid.opens_into.empty()) continue;
    Fluid closed = known.fluid;
    closed.opens_into.clear();
    scene.set_fluid(known.name, std::move(closed));
  }
  for (const VolumeConstraint& known : scene.volume_constraints()) {
    const bool stays = std::ranges::any_of(all, [&](const VolumeChange& change) {
      return !change.is_new && change.kept.size() == 1 && change.kept.front().name == known.name;
    });
    if (!stays) gone.push_back(known.name);
  }
  for (const std::string& name : gone) scene.remove_volume(name);
  std::vector<std::pair<std::string, Fluid>> fluids;
  for (VolumeChange& change : all) {
    if (change.kept.size() != 1) in.fail("expected one volume at a time; the file is damaged");
    VolumeConstraint& kept = change.kept.front();
    fluids.emplace_back(kept.name, std::exchange(kept.fluid, {}));
    if (change.is_new) {
      scene.constrain_volume(std::move(kept));
    } else if (change.is_set) {
      scene.set_volume(kept.name, kept.volume);
    }
  }
  for (auto& [name, fluid] : fluids) scene.set_fluid(name, std::move(fluid));
}

void take_old_volumes(ByteReader& in, Scene& scene) {
  std::vector<VolumeConstraint> kept;
  volume_fields(in, kept);
  for (VolumeConstraint& surface : kept) scene.constrain_volume(std::move(surface));
}

}  // namespace phymul
