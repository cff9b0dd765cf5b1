// SPDX-License-Identifier: MIT
//
// Load: a force or an imposed motion on some particles of a body, with a value that changes with time.
#pragma once

#include <phymul/types.h>

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace phymul {

/// Effect of a load with value v and unit direction u (from Load::direction or Load::toward):
/// - translation: coordinates along driven axes are imposed at rest + v u, along held axes at rest; free axes move.
/// - rotation: positions are imposed at the rest positions, rotated by v rad about the axis u through their centroid,
///   which does not count copies that a cut made of them.
/// - force: v u newtons on each particle.
/// - pressure: v pascals on each surface facet whose particles are all listed. The force, rest area times v, acts along
///   u, or inward if there is no direction, and is divided evenly among the facet's particles. Surface facets are the
///   faces that belong to exactly one volume cell. In a model without volume cells they are its triangles and quads,
///   counter-clockwise seen from outside. In 2-D they are edges of exactly one cell, or lines with the outside on their
///   right, per metre of thickness.
/// - acceleration: mass times v u on each particle.
enum class LoadType { translation, rotation, force, pressure, acceleration };

/// A value at a time. Values are linear between events, 0 before the first one and constant after the last one. Two
/// events at the same time make a jump: the one listed later holds from that time on. Times are those of the solver
/// (State::time), whenever the load is added: a ramp that starts now starts at StepReport::time of the last step.
struct ValueEvent {
  double date = 0.0;   ///< s
  double value = 0.0;  ///< m, rad, N, Pa or m/s^2: unit of the load type
  bool operator==(const ValueEvent&) const = default;
};

/// How a load acts along one coordinate axis.
enum class Axis : std::uint8_t {
  free,   ///< the load does not act along it
  held,   ///< imposed displacement 0 (NULL in LML)
  driven  ///< the load acts along it, by the component of its direction
};

struct Load {
  LoadType type = LoadType::force;
  std::vector<Index> particles{};    ///< rows of the model; repeated rows count once
  std::vector<ValueEvent> events{};  ///< sorted by time; equal times keep their order
  std::array<Axis, 3> axes{Axis::driven, Axis::driven, Axis::driven};
  Vec3 direction{0, 0, 0};   ///< any length but 0; components along axes that are not driven are ignored
  Index toward = -1;         ///< >= 0: each particle's direction points from its rest position to that of this particle
  std::string applied_to{};  ///< target as written in the file, for messages and for writing back
  bool operator==(const Load&) const = default;
};

/// Value of the events at a time, s. `events` must be sorted by time.
double value_at(std::span<const ValueEvent> events, double date);

}  // namespace phymul
