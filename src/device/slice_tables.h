// SPDX-License-Identifier: MIT
//
// SliceTables: the constants of FloatTables, bit for bit, laid out for devices whose neighbouring lanes read
// neighbouring memory and wait for the longest of them (sliced ELLPACK).
//
// Particles get places: along a Morton curve through the rest shape, so that neighbours lie near each other, and within
// windows of it by their numbers of rows, so that lanes side by side have about as many. Places 0 ... N - 1 are the
// particles; the last slice is filled up with places that are nobody's.
//
// Every list of a particle is interleaved with those of the others in its slice: entry e of lane l of slice s is row
// start[s] + e * slice + l. A particle's list has a range {first, end}, end = first + count * slice, and is walked by
//   for (row = first; row < end; row += slice)
// A slice is as long as its longest lane. Rows beyond a lane's own end are padding: no range holds them, numbers of
// places and rows in them are `none`, everything else 0. A pass that runs over all rows must pass over those.
//
// The order within a particle's list is that of FloatTables, so that a sum over it has the same bits. A particle with
// no row of `bases` or `heights` has no attractor, whatever its neighbours.
#pragma once

#include <vector>

#include "float_tables.h"

namespace phymul {

struct SliceTables {
  int slice = 0;  ///< lanes

  /// The constants by place and row: every member means what it does in FloatTables, but
  ///   - `index`, `lists`, `first_height` and walls.entries.offset are empty; the ranges below say where a particle's
  ///     rows are
  ///   - particle numbers are places; entries (t * 4 + corner and so on) name the rows here
  ///   - `particle` has a texel per place; rows per neighbour, per base and of the lists are padded, and base_count
  ///     counts padded rows; particle_count is N. Volumes and walls are not padded, and stand in the order of
  ///     their first place.
  ///   - domains are numbered by place, and further ones of a particle follow behind the last place, by place again;
  ///     their links are interleaved as other lists are, and their ranges count with that stride
  FloatTables rows;

  // Ranges, [places] each, empty where the list is.
  std::vector<Int2> neighbours;  ///< of neighbour, alpha, edge_alpha
  std::vector<Int2> heights;     ///< of height: texels of four heights, in the order of the triples
  std::vector<Int2> bases;       ///< of base, base_e1, base_e2, base_share: the particle's own
  std::vector<Int2> reactions;   ///< of share or reaction
  std::vector<Int2> volumes;     ///< of volume_entry
  std::vector<Int2> springs;     ///< of spring_other, spring
  std::vector<Int2> walls;       ///< of walls.entries.entry

  std::vector<Index> order;     ///< [places] row of the model; `none` where the place is nobody's
  std::vector<Index> place_of;  ///< [N] place of a row of the model

  Index place_count() const { return static_cast<Index>(order.size()); }  ///< a multiple of `slice`
};

/// Takes tables packed from `topology`. Needs memory for one more copy of the largest table while it runs. Throws Error
/// where a padded table outgrows 32-bit rows or entries, with the sizes, and where slice is not 1 ... 1024.
SliceTables pack_slices(FloatTables tables, const TopologyTextures& topology, int slice = 32);

}  // namespace phymul
