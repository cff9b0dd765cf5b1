// SPDX-License-Identifier: MIT
//
// Scene: what acts on a body. Plain values, changeable between steps. A scene pays only for what it holds: without
// an imposed position there is no imposed-position pass, without a load no force array.
#pragma once

#include <phymul/model.h>
#include <phymul/tool.h>

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace phymul {

enum class LoadType { translation, rotation, force, pressure, acceleration };

/// One value at one date. Between dates the value is linear; 0 before the first, the last one held after the last;
/// two events on one date make a step (the later listed one holds from that date on). Dates are of the solver's time
/// (State::time), whenever the load is added: a ramp that is to begin now begins at StepReport::time of the last step.
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

/// Value of the events, sorted by date, at a date.
double value_at(std::span<const ValueEvent> events, double date);

/// What a scene means at one instant, ready for a solver. Empty vectors where nothing of the kind acts.
struct LoadFrame {
  Vec3 gravity{0, 0, 0};            ///< m/s^2, on every particle
  VecList force;                    ///< [N] N, or empty
  std::vector<std::uint8_t> fixed;  ///< [N] or empty: bit a set = coordinate a is imposed
  VecList target;                   ///< [N] m, or empty: the imposed coordinates
};

/// What a scene means at any instant, taken apart into vectors that stay and numbers that change with time, so that a
/// device needs only the numbers at each step: value[m] of Scene::mode_values. Empty lists where nothing of the kind
/// acts.
struct LoadModes {
  struct Part {
    Index mode = 0;
    Vec3 vector{0, 0, 0};
  };
  int count = 0;                     ///< of the numbers
  std::vector<std::uint8_t> fixed;   ///< [N] or empty: as LoadFrame::fixed
  std::vector<Index> target_offset;  ///< [N + 1] or empty: particle i's rows of target
  std::vector<Part> target;          ///< m: imposed displacement from rest = sum of value[mode] * vector
  std::vector<Index> force_offset;   ///< [N + 1] or empty
  std::vector<Part> force;           ///< N: force = sum of value[mode] * vector
  Vec3 gravity{0, 0, 0};             ///< m/s^2, on every particle
  std::vector<Part> acceleration;    ///< m/s^2, on every particle besides: sum of value[mode] * vector
};

/// A closed surface whose volume every step restores: Scene::constrain_volume.
struct VolumeConstraint {
  std::vector<std::array<Index, 3>> triangles;  ///< counter-clockwise seen from outside
  double volume = 0.0;                          ///< m^3, wanted
  std::string applied_to;                       ///< group, for messages; empty: the whole body
  bool operator==(const VolumeConstraint&) const = default;
};

/// Touching of surfaces, of bodies and of parts of one: Scene::contacts. A particle on a surface and the nearest
/// triangle of another one come no nearer than their margins, and rub by Coulomb's law; impulses are equal and
/// opposite.
struct ContactOptions {
  double friction = 0.3;  ///< Coulomb's coefficient, >= 0
  double margin = 0.0;    ///< m, around every surface; two margins touch. 0: a tenth of the mean edge around a particle
  bool self = true;       ///< parts of one body touch each other too, where they lie apart at rest
  int rounds = 8;         ///< sweeps over all pairs in a step, >= 1; more: pushes travel further through a stack
  bool operator==(const ContactOptions&) const = default;
};

class Scene;

/// Moves a tool of a scene. Cheap to make and to copy; no call but grasp() makes a solver allocate. Good as long as the
/// scene has the tool: later calls throw Error. Points to the scene, which must outlive it: a handle of a scene that is
/// gone must not be used, and nothing can check this. Its calls change the scene, and are no more thread-safe than it.
class ToolHandle {
 public:
  /// Where the tool is at the end of the solver's next step(): over the call's steps it goes there from where it is,
  /// straight and evenly, turning the shorter way. Afterwards it goes on with the pose's velocity and spin. (In
  /// run_to_rest() it is there after the first step.)
  void move_to(const ToolPose& pose) const;
  /// The same at once, without having been in between: nothing is pushed along, and no force says so. Particles that it
  /// then covers come out in the next step without gaining speed; against a tool with compliance its spring pushes
  /// them.
  void teleport(const ToolPose& pose) const;
  const ToolPose& target_pose() const;  ///< the last pose asked for

  /// From the next step on, free particles within `distance` of the surface (or inside) move with the tool. Imposed
  /// coordinates win (Scene::fix, translations): a particle with all of them imposed is not taken, another one goes
  /// with the tool along those that are free, also where they are imposed later. What another tool holds is not taken;
  /// of tools that grasp in one step, the first in Scene::tools() gets what both reach. The next grasp() adds to what
  /// is held. Throws Error for a negative distance and for a needle.
  void grasp(double distance) const;
  void release() const;

 private:
  friend class Scene;
  friend class Solver;
  ToolHandle(Scene& scene, std::uint64_t id) : scene_(&scene), id_(id) {}
  SceneTool& own() const;
  Scene* scene_;
  std::uint64_t id_;
};

/// Points to the model, which must outlive it and not change. Not thread-safe: any number of threads may read it, one
/// that changes it must be alone with it and with its solvers. A copy is another scene, which solvers and handles of
/// the first do not see; there is no moving and no assigning, after which a solver would step what nobody meant:
/// std::move copies, and clear() empties a scene for other loads. An empty list of particles is allowed, and
/// does nothing. Functions throw Error for an unknown group, an index out
/// of range, or a value that is not finite, and then leave the scene as it was.
///
/// Meaning of the load types, for value v, unit direction u (from `direction` or `toward`):
/// - translation: driven axes are imposed at rest + v u, held axes at rest, free axes move.
/// - rotation: the particles are imposed at their rest places turned by v rad about the axis u through the centroid
///   of their rest places.
/// - force: v u newtons on each particle.
/// - pressure: v pascals on every surface facet all of whose particles are meant; the facet's rest area times v,
///   along u, or inward where no direction is given, shared evenly by its particles. Surface facets are the faces that
///   exactly one volume cell has; in a model without volume cells its triangles and quads, counter-clockwise seen
///   from outside. In 2-D: edges of one cell alone, or lines with the outside on their right; per metre of thickness.
/// A particle listed twice in a load is meant once. Where loads impose the same coordinate, the later one holds;
/// an imposed coordinate beats any force; forces add up.
/// - acceleration: mass times v u on each particle.
class Scene {
 public:
  explicit Scene(const Model& model);      ///< throws Error unless validate(model) accepts it
  explicit Scene(const Model&&) = delete;  ///< a temporary would be gone before the first step
  Scene(const Scene&) = default;
  Scene& operator=(const Scene&) = delete;

  const Model& model() const { return *model_; }

  Scene& fix(std::string_view group);            ///< holds the group at its rest place, for ever, against tools too
  Scene& fix(std::span<const Index> particles);  ///< the same for listed particles
  Scene& gravity(const Vec3& acceleration);      ///< m/s^2
  Scene& add(Load load);                         ///< appends a load
  Scene& add(std::vector<Load> loads);           ///< appends loads, as read_lml gives them
  Scene& replace(std::size_t row, Load load);    ///< puts another load in an existing row
  Scene& remove(std::size_t row);                ///< later rows move up
  Scene& clear();  ///< no loads, no gravity, nothing fixed, no tools, no kept volumes, no contacts

  /// After each step the volume that the surface of these particles' cells encloses is brought back to what it was at
  /// rest (or to `volume`, m^3), exactly (in single precision: as far as positions are rounded, 1e-7 or so of it):
  /// every free particle of the surface moves along the gradient of the volume over its mass. Linear momentum is kept,
  /// and angular momentum; imposed coordinates stay. Surfaces are those of pressure loads. Throws Error where one is
  /// not closed, with an edge that is open.
  Scene& constrain_volume();
  Scene& constrain_volume(std::string_view group);
  Scene& constrain_volume(VolumeConstraint surface);

  Scene& contacts(const ContactOptions& options);  ///< bodies, and parts of a body, touch from now on
  Scene& no_contacts();

  /// Gives a load other values; where it acts and along what stays. Cheap however large the body: no solver prepares
  /// anything anew, and nothing is allocated where the load has had as many events before and these are sorted. For
  /// what changes at every step, as the tool of a haptic device does: three translations with one driven axis each move
  /// a group anywhere.
  Scene& set_events(std::size_t row, std::span<const ValueEvent> events);
  /// Throws Error for a name that is taken, a size or pose that makes no sense. Whether solvers step the scene already
  /// or not, the first step that sees the tool finds it at its first pose as if by ToolHandle::teleport().
  Scene& add_tool(std::string name, Tool tool);
  /// The same with a name that the scene makes up ("tool 1"), for tools that their handle is enough for.
  ToolHandle add_tool(Tool tool) &;
  ToolHandle add_tool(ToolShape shape) &;
  Scene& remove_tool(std::string_view name);
  ToolHandle tool(std::string_view name) &;  ///< throws Error that lists the known names
  const std::vector<SceneTool>& tools() const { return tools_; }

  const std::vector<Load>& loads() const { return loads_; }
  const Vec3& gravity() const { return gravity_; }
  const std::vector<VolumeConstraint>& volume_constraints() const { return volume_constraints_; }
  const std::optional<ContactOptions>& contacts() const { return contacts_; }

  /// Grows by one at every change but those of set_events() and of a tool's pose and grasp, which have counters of
  /// their own: lets a solver see that its prepared frame is stale.
  std::uint64_t version() const { return version_; }
  /// Grows by one at every set_events(): frame and modes are as before, their values are not.
  std::uint64_t values_version() const { return values_version_; }

  /// Gives `frame` the sizes this scene needs. Allocates; called when version() has changed.
  void prepare(LoadFrame& frame) const;

  /// Fills a frame that prepare() sized at this version, for one instant. Writes only to what loads act on. Does not
  /// allocate, does not throw.
  void evaluate(double time, LoadFrame& frame) const;

  LoadModes modes() const;                                        ///< of this version; allocates
  void mode_values(double time, std::span<double> values) const;  ///< [LoadModes::count]; does not allocate

 private:
  /// A load made ready: what is left to do at an instant is to multiply by its value.
  struct Action {
    std::vector<Index> particles;  // sorted, each once
    VecList unit;                  // [particles] loads and translations: effect per unit of value; rotations: rest
                                   // place from the centroid, m
    Vec3 axis{0, 0, 0};            // unit axis of a rotation; direction of a uniform acceleration
    std::uint8_t imposed = 0;      // bit a set: coordinate a is imposed
    bool uniform = false;          // an acceleration of the whole body along one direction, which needs no forces
  };

  void require(const Load& load) const;
  Action accepted(Load& load) const;
  Action prepared(const Load& load) const;
  Action prepared_rotation(const Load& load, Action action) const;
  Action prepared_pressure(const Load& load, Action action) const;
  Vec3 unit_direction(const Load& load, const Vec3& from) const;
  friend class ToolHandle;

  const Model* model_;
  std::vector<Load> loads_;
  std::vector<Action> actions_;  // per load
  Vec3 gravity_{0, 0, 0};
  std::vector<VolumeConstraint> volume_constraints_;
  std::optional<ContactOptions> contacts_;
  std::vector<SceneTool> tools_;
  std::uint64_t next_tool_ = 1;
  std::uint64_t version_ = 0, values_version_ = 0;
};

}  // namespace phymul
