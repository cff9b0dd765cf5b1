// SPDX-License-Identifier: MIT
//
// Scene: what acts on a body. Plain values, changeable between steps. A scene pays only for what it holds: without
// an imposed position there is no imposed-position pass, without a load no force array.
#pragma once

#include <phymul/model.h>

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace phymul {

enum class LoadType { translation, rotation, force, pressure, acceleration };

/// One value at one date. Between dates the value is linear; 0 before the first, the last one held after the last;
/// two events on one date make a step (the later listed one holds from that date on).
struct ValueEvent {
  double date = 0.0;   ///< s
  double value = 0.0;  ///< SI unit of the load type: m, rad, N, Pa, m/s^2
  bool operator==(const ValueEvent&) const = default;
};

/// What a load's direction says of one axis.
enum class Axis : std::uint8_t {
  free,   ///< not mentioned: the load leaves it alone
  held,   ///< NULL: zero displacement along it
  driven  ///< a number
};

struct Load {
  LoadType type = LoadType::force;
  std::vector<Index> particles;    ///< what it acts on, rows of the model
  std::vector<ValueEvent> events;  ///< sorted by date (stable)
  std::array<Axis, 3> axes{Axis::driven, Axis::driven, Axis::driven};
  Vec3 direction{0, 0, 0};  ///< normalised when evaluated; components of axes that are not driven are ignored
  Index toward = -1;        ///< >= 0: each particle's direction points from its rest place to this particle's
  std::string applied_to;   ///< as the file wrote it, for messages and for writing back
  bool operator==(const Load&) const = default;
};

/// Value of the events at a date. Shapes: scalar.
double value_at(std::span<const ValueEvent> events, double date);

/// What a scene means at one instant, ready for a solver. Empty vectors where nothing of the kind acts.
struct LoadFrame {
  Vec3 gravity{0, 0, 0};            ///< m/s^2, on every particle
  VecList force;                    ///< [N] N, or empty
  std::vector<std::uint8_t> fixed;  ///< [N] or empty: bit a set = coordinate a is imposed
  VecList target;                   ///< [N] m, or empty: the imposed coordinates
};

/// Keeps a reference to the model, which must outlive it. Functions throw Error for an unknown group, an index out
/// of range, or a value that is not finite, and then leave the scene as it was.
///
/// Meaning of the load types, for value v, unit direction u (from `direction` or `toward`):
/// - translation: driven axes are imposed at rest + v u, held axes at rest, free axes move.
/// - rotation: the particles are imposed at their rest places turned by v rad about the axis u through the centroid
///   of their rest places.
/// - force: v u newtons on each particle.
/// - pressure: v pascals on every surface facet all of whose particles are meant; the facet's rest area times v,
///   along u, or inward where no direction is given, shared evenly by its particles.
/// - acceleration: mass times v u on each particle.
class Scene {
 public:
  explicit Scene(const Model& model);

  const Model& model() const { return *model_; }

  Scene& fix(std::string_view group);            ///< holds the group at its rest place, for ever
  Scene& fix(std::span<const Index> particles);  ///< the same for listed particles
  Scene& gravity(const Vec3& acceleration);      ///< m/s^2
  Scene& add(Load load);                         ///< appends a load
  Scene& add(std::vector<Load> loads);           ///< appends loads, as read_lml gives them
  Scene& replace(std::size_t row, Load load);    ///< puts another load in an existing row
  Scene& remove(std::size_t row);                ///< later rows move up
  Scene& clear();                                ///< no loads, no gravity, nothing fixed

  const std::vector<Load>& loads() const { return loads_; }
  const Vec3& gravity() const { return gravity_; }

  /// Grows by one at every change: lets a solver see that its prepared frame is stale.
  std::uint64_t version() const { return version_; }

  /// Gives `frame` the sizes this scene needs. Allocates; called when version() has changed.
  void prepare(LoadFrame& frame) const;

  /// Fills a prepared frame for one instant. Does not allocate, does not throw.
  void evaluate(double time, LoadFrame& frame) const;

 private:
  struct Facet {
    std::array<Index, 4> particles;  // -1 in the last place: a triangle
    Vec3 area;                       // outward normal times rest area, m^2
  };

  void require(const Load& load) const;

  const Model* model_;
  std::vector<Load> loads_;
  std::vector<std::vector<Facet>> facets_;  // per load; empty unless it is a pressure
  Vec3 gravity_{0, 0, 0};
  std::uint64_t version_ = 0;
};

}  // namespace phymul
