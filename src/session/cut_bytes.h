// SPDX-License-Identifier: MIT
//
// Cuts of a body in files.
#pragma once

#include <phymul/body_cut.h>

#include "base/checked_file.h"

namespace phymul {

template <class Bytes, class Part>
void part_field(Bytes& bytes, Part& part) {
  for (auto& i : part.particles) bytes.field(i, "a particle of a cut cell");
  bytes.field(part.share, "a share");
  bytes.list(part.cuts, 32, "a number of cuts", [&](auto& cut) {
    for (auto& value : cut) bytes.field(value, "a distance from a cut");
  });
}

/// Throws Error for bytes that are not so many cuts. Whether they are of the body, its fingerprint tells.
template <class Bytes, class Cut>
void cut_field(Bytes& bytes, Cut& cut) {
  bytes.list(cut.changed, 68, "a number of changed cells", [&](auto& change) {
    bytes.field(change.row, "a cell");
    part_field(bytes, change.before);
    part_field(bytes, change.after);
  });
  bytes.list(cut.added, 36, "a number of added cells", [&](auto& added) {
    bytes.field(added.of, "a cell");
    part_field(bytes, added.part);
  });
  bytes.list(cut.copies, 9, "a number of copies", [&](auto& copy) {
    bytes.field(copy.particle, "a copy");
    bytes.field(copy.of, "a copied particle");
    bytes.field(copy.shared, "whether a copy lies on the cut");
  });
  bytes.list(cut.masses, 20, "a number of masses", [&](auto& mass) {
    bytes.field(mass.particle, "a particle");
    bytes.field(mass.before, "a mass");
    bytes.field(mass.after, "a mass");
  });
}

inline void cuts_field(ByteWriter& bytes, const BodyCuts& cuts) {
  bytes.list(cuts, 32, "", [&](const auto& cut) { cut_field(bytes, *cut); });
}
inline void cuts_field(ByteReader& bytes, BodyCuts& cuts) {
  bytes.list(cuts, 32, "a number of cuts", [&](auto& cut) {
    BodyCut read;
    cut_field(bytes, read);
    cut = std::make_shared<const BodyCut>(std::move(read));
  });
}

}  // namespace phymul
