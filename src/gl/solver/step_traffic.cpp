// SPDX-License-Identifier: MIT
#include "step_traffic.h"

namespace phymul::gl {
namespace {

constexpr double texel = 16.0;  // bytes: four floats or integers, the form of state, forces and terms

template <class T>
double bytes_of(const std::vector<T>& table) {
  return static_cast<double>(table.size() * sizeof(T));
}

double base_constants(const FloatTables& t) {
  return bytes_of(t.base) + bytes_of(t.base_e1) + bytes_of(t.base_e2);
}

/// Reads displacements and who is whose neighbour, writes F.
double attractor_pass(const FloatTables& t, double particles) {
  const double bases = t.layout == FloatLayout::enumerated
                           ? bytes_of(t.edge_alpha) + bytes_of(t.first_height) + bytes_of(t.height)
                           : bytes_of(t.alpha) + base_constants(t);
  return bytes_of(t.index) + bytes_of(t.neighbour) + bases + 2.0 * texel * particles;
}

/// Reads displacements (averaged: and F), writes a force for each corner.
double bases_pass(const FloatTables& t, double particles, double corners) {
  const double read = t.has_attractors() ? 2.0 : 1.0;
  return base_constants(t) + bytes_of(t.base_share) + read * texel * particles + corners * texel * t.base_count;
}

double volumes_pass(const FloatTables& t, double particles) {
  const double constants = bytes_of(t.volume) + bytes_of(t.volume_e1) + bytes_of(t.volume_e2) + bytes_of(t.volume_e3);
  return constants + texel * particles + 4.0 * texel * t.volume_count;
}

double cells_pass(const FloatTables& t, double particles) {
  return bytes_of(t.cell_vertex) + bytes_of(t.cell_gradient) + bytes_of(t.cell_stiffness) + texel * particles +
         3.0 * texel * t.cell_count;
}

}  // namespace

double bytes_a_step(const FloatTables& t) {
  const double particles = t.particle_count;
  const bool base_terms =
      t.base_count > 0 && (t.options.reaction == Reaction::conservative || t.options.reaction == Reaction::averaged);
  const double corners = t.options.reaction == Reaction::conservative ? 4.0 : 3.0;
  // The pass that sums and moves: state read and written, lists, and all that the others wrote.
  double bytes = 4.0 * texel * particles + bytes_of(t.particle) + bytes_of(t.lists) + bytes_of(t.reaction) +
                 bytes_of(t.share) + bytes_of(t.volume_entry) + bytes_of(t.cell_entry) + bytes_of(t.spring_other) +
                 bytes_of(t.spring);
  if (t.has_attractors()) bytes += attractor_pass(t, particles) + texel * particles;
  if (base_terms) bytes += bases_pass(t, particles, corners) + corners * texel * t.base_count;
  if (base_terms && corners == 4.0) bytes += bytes_of(t.index);
  if (t.volume_count > 0) bytes += volumes_pass(t, particles) + 4.0 * texel * t.volume_count;
  if (t.cell_count > 0) bytes += cells_pass(t, particles) + 3.0 * texel * t.cell_count + bytes_of(t.cell_gradient);
  return bytes;
}

double bytes_a_step(const SliceTables& s) {
  double ranges = 0.0;
  for (const auto* lists : {&s.neighbours, &s.heights, &s.bases, &s.reactions, &s.volumes, &s.cells, &s.springs}) {
    ranges += bytes_of(*lists);
  }
  if (s.rows.options.reaction == Reaction::conservative) ranges += bytes_of(s.bases);  // by the step too
  return bytes_a_step(s.rows) + ranges;
}

}  // namespace phymul::gl
