// SPDX-License-Identifier: MIT
//
// What a step of the vector backend moves between memory and a core, for bodies that outgrow the caches. A cluster's
// copy of its displacements stays in the first cache and is not counted; a written line counts once, as its line is
// read (or claimed) before.
#include "packed_body.h"

namespace phymul::cpu {
namespace {

constexpr double quad_bytes = 16.0, triple_bytes = 12.0, word_bytes = 4.0;

double constants(const PackedBody& b) {
  double words = 0.0;
  for (const Floats* table :
       {&b.bases, &b.enumerated, &b.springs, &b.volumes, &b.walls, &b.give, &b.inverse_mass, &b.mass}) {
    words += static_cast<double>(table->size());
  }
  for (const Offsets* table : {&b.base_first, &b.spring_first, &b.enumerated_first, &b.enumerated_neighbours,
                               &b.enumerated_offsets, &b.own, &b.halo_first, &b.halo, &b.give_first}) {
    words += static_cast<double>(table->size());
  }
  const bool attracts = !(b.bases.empty() && b.enumerated.empty()) && b.use != simd::BaseUse::conservative;
  if (attracts) words += static_cast<double>(b.stiffness.size());
  return word_bytes * words;
}

}  // namespace

double PackedBody::bytes_a_step() const {
  double halo_slots = 0.0;
  for (const Cluster& cluster : clusters) halo_slots += static_cast<double>(cluster.halo.size());
  const double state = places * (2.0 * quad_bytes + 2.0 * triple_bytes);                 // u and v, read and written
  const double gathered = places * quad_bytes + halo_slots * (quad_bytes + word_bytes);  // u, with that of others
  const double forces = static_cast<double>(force_rows) * 2.0 * quad_bytes;  // written by clusters, read by the move
  const double pulls = gives() ? places * 2.0 * quad_bytes : 0.0;            // likewise
  return constants(*this) + state + gathered + forces + pulls + averages.bytes();
}

}  // namespace phymul::cpu
