// SPDX-License-Identifier: MIT
#include <phymul/error.h>
#include <phymul/monitor.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "cell_cutter.h"
#include "cell_geometry.h"

namespace phymul {
namespace {

constexpr double unmoved_ratio = 1e-12;  // displacement of the reference / body size

void require_count(const Model& model, std::size_t count, const char* what) {
  if (count == model.rest.size()) return;
  throw Error("expected " + std::to_string(model.rest.size()) + " " + what + ", one per particle, got " +
              std::to_string(count));
}

/// Sum over particles of mass times term(i).
template <class Term>
Vec3 mass_sum(const Model& model, Term term) {
  Vec3 sum = Vec3::Zero();
  for (Index i = 0; i < model.particle_count(); ++i) sum += model.mass[i] * term(i);
  return sum;
}

/// The value that the share of all values is not above, by nearest rank; 0 for none. Reorders the values.
double percentile(std::vector<double>& values, double share) {
  if (values.empty()) return 0.0;
  const double rank = std::ceil(share * static_cast<double>(values.size()));
  const auto nth = values.begin() + static_cast<std::ptrdiff_t>(std::max(rank, 1.0)) - 1;
  std::nth_element(values.begin(), nth, values.end());
  return *nth;
}

/// Of its rest measure: a cell or corner below counts as folded.
constexpr double folded_share = 1e-3;
/// Of its cell's volume: a corner as small as this at rest is flat, and says nothing.
constexpr double flat_corner = 1e-3;

double corner_volume(const Cell& cell, const CellCorner& corner, std::span<const Vec3> x) {
  const auto at = [&](int k) -> const Vec3& { return x[cell.particles[corner[k]]]; };
  return (at(1) - at(0)).cross(at(2) - at(0)).dot(at(3) - at(0)) / 6.0;
}

/// Infinite where a coordinate is not a number, so that such a particle counts as the worst.
double distance(const Vec3& a, const Vec3& b) {
  const double length = (a - b).norm();
  return std::isnan(length) ? std::numeric_limits<double>::infinity() : length;
}

}  // namespace

Vec3 linear_momentum(const Model& model, const State& state) {
  require_count(model, state.velocity.size(), "velocities");
  return mass_sum(model, [&](Index i) { return state.velocity[i]; });
}

Vec3 angular_momentum(const Model& model, const State& state, const Vec3& about) {
  require_count(model, state.position.size(), "positions");
  require_count(model, state.velocity.size(), "velocities");
  return mass_sum(model, [&](Index i) -> Vec3 { return (state.position[i] - about).cross(state.velocity[i]); });
}

Vec3 centre_of_mass(const Model& model, const State& state) {
  require_count(model, state.position.size(), "positions");
  double mass = 0.0;
  for (const double m : model.mass) mass += m;
  return mass_sum(model, [&](Index i) { return state.position[i]; }) / mass;
}

double kinetic_energy(const Model& model, const State& state) {
  require_count(model, state.velocity.size(), "velocities");
  double sum = 0.0;
  for (Index i = 0; i < model.particle_count(); ++i) sum += 0.5 * model.mass[i] * state.velocity[i].squaredNorm();
  return sum;
}

double volume(const Model& model, std::span<const Vec3> position) {
  require_count(model, position.size(), "positions");
  double sum = 0.0;
  for (const Cell& cell : model.cells) sum += signed_measure(model.dimension, cell, position);
  return sum;
}

Index first_folded_cell(const Model& model, std::span<const Vec3> position) {
  require_count(model, position.size(), "positions");
  for (std::size_t c = 0; c < model.cells.size(); ++c) {
    const Cell& cell = model.cells[c];
    if (cell.share == 0.0) continue;
    const bool solid = model.dimension == 3 && is_volume(cell.type);
    // All corners of a tetrahedron are the whole of it.
    const bool one_corner = solid && cell.type == CellType::tetrahedron;
    const auto measure = [&](std::span<const Vec3> x) {
      return one_corner ? corner_volume(cell, cell_corners(cell.type).front(), x)
                        : signed_measure(model.dimension, cell, x);
    };
    const double at_rest = measure(model.rest);
    // A cell that the model has wound the other way is negative from the start.
    const auto folds = [&](double now, double rest) { return !(now * at_rest >= folded_share * rest * at_rest); };
    if (folds(measure(position), at_rest)) return static_cast<Index>(c);
    if (!solid || one_corner) continue;
    for (const CellCorner& corner : cell_corners(cell.type)) {
      const double rest = corner_volume(cell, corner, model.rest);
      if (rest * at_rest < flat_corner * at_rest * at_rest) continue;
      if (folds(corner_volume(cell, corner, position), rest)) return static_cast<Index>(c);
    }
  }
  return -1;
}

DisplacementNorms displacement_norms(const Model& model, const State& state) {
  require_count(model, state.position.size(), "positions");
  DisplacementNorms norms;
  double squares = 0.0;
  for (Index i = 0; i < model.particle_count(); ++i) {
    const double length = distance(state.position[i], model.rest[i]);
    squares += length * length;
    if (norms.max_particle < 0 || length > norms.max) {
      norms.max = length;
      norms.max_particle = i;
    }
  }
  const std::size_t count = model.rest.size() - spare_particles_of(model).size();
  if (count > 0) norms.rms = std::sqrt(squares / static_cast<double>(count));
  return norms;
}

std::vector<double> relative_errors(const Model& model, std::span<const Vec3> position,
                                    std::span<const Vec3> reference) {
  require_count(model, position.size(), "positions");
  require_count(model, reference.size(), "reference positions");
  const double unmoved = unmoved_ratio * body_size(model);
  std::vector<double> errors(model.rest.size(), std::numeric_limits<double>::quiet_NaN());
  for (std::size_t i = 0; i < errors.size(); ++i) {
    const double moved = (reference[i] - model.rest[i]).norm();
    if (moved > unmoved) errors[i] = distance(position[i], reference[i]) / moved;
  }
  return errors;
}

PositionError position_error(const Model& model, std::span<const Vec3> position, std::span<const Vec3> reference,
                             std::span<const std::uint8_t> skip) {
  const std::vector<double> relative = relative_errors(model, position, reference);
  if (!skip.empty()) require_count(model, skip.size(), "marks of particles to skip (or none)");
  PositionError error;
  std::vector<double> distances, rens;
  double off = 0.0, moved = 0.0;
  for (Index i = 0; i < model.particle_count(); ++i) {
    if (!skip.empty() && skip[i] != 0) continue;
    if (static_cast<std::size_t>(i) < model.mass.size() && model.mass[i] == 0.0) continue;
    const double length = distance(position[i], reference[i]);
    distances.push_back(length);
    off += length * length;
    moved += (reference[i] - model.rest[i]).squaredNorm();
    if (error.max_particle < 0 || length > error.max) {
      error.max = length;
      error.max_particle = i;
    }
    if (std::isnan(relative[i])) continue;
    rens.push_back(relative[i]);
    error.max_ren = std::max(error.max_ren, relative[i]);
  }
  if (off > 0.0) error.global_ratio = std::sqrt(off / moved);
  error.p95 = percentile(distances, 0.95);
  error.median_ren = percentile(rens, 0.5);
  return error;
}

}  // namespace phymul
