// SPDX-License-Identifier: MIT
#include "base_layout.h"

namespace phymul {
namespace {

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

FloatLayout choose_layout(BaseLayout wish, const TopologyTextures& topology) {
  if (wish == BaseLayout::enumerated) return FloatLayout::enumerated;  // pack_floats refuses what cannot be
  const bool automatic = wish == BaseLayout::automatic;
  return automatic && topology.base_count > 0 && can_enumerate(topology) && enumerated_is_smaller(topology)
             ? FloatLayout::enumerated
             : FloatLayout::table;
}

}  // namespace phymul
