// SPDX-License-Identifier: MIT
//
// Scene: what acts on a body: fixed particles, loads, gravity, tools, joints, threads, volume constraints and contacts.
// It also has the present factors of stiffness. It may change between steps. What is not in it costs no time.
#pragma once

#include <phymul/body_cut.h>
#include <phymul/fluid.h>
#include <phymul/joint.h>
#include <phymul/load.h>
#include <phymul/model.h>
#include <phymul/tearing.h>
#include <phymul/thread.h>
#include <phymul/tool.h>

#include <array>
#include <cstdint>
#include <initializer_list>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace phymul {

struct LoadFrame;     // load_frame.h
struct SurfacePatch;  // surface_patch.h
struct LoadModes;     // load_frame.h
struct SceneParts;    // state.h

/// A closed surface and the fluid in it: Scene::constrain_volume.
struct VolumeConstraint {
  std::vector<std::array<Index, 3>> triangles;  ///< indices of particles, counter-clockwise seen from outside
  double volume = 0.0;                          ///< m^3, of the fluid without pressure
  std::string applied_to{};                     ///< group, for messages; empty: the whole body
  std::string name{};                           ///< empty: "volume 1", "volume 2" and so on
  Fluid fluid{};
  std::uint64_t changes = 0;  ///< another number after each set_volume(); not to be set
  bool operator==(const VolumeConstraint&) const = default;
};

/// Contact between bodies and between parts of one body: Scene::contacts. Each particle on a surface stays at a
/// distance of the sum of both contact margins from the nearest triangle of every other body, with Coulomb friction.
/// Impulses are equal and opposite.
struct ContactOptions {
  double friction = 0.3;  ///< Coulomb coefficient, >= 0
  /// m, >= 0, contact margin of every surface. 0: a tenth of a particle's mean edge, or of a triangle's longest edge
  double margin = 0.0;
  bool self = true;  ///< parts of one body that are more than two surface edges apart at rest also touch each other
  int rounds = 8;    ///< sweeps over all contacts per step, >= 1. More sweeps carry forces further through a stack
  bool operator==(const ContactOptions&) const = default;
};

class Scene;

/// Moves a tool of a scene. It is small and copyable. Functions throw Error after the tool was removed from the scene,
/// and for a pose that is not finite. The scene must outlive its handles; the library cannot detect violations. The
/// scene's rules for threads apply, because calls change it. Only grasp() and release() make a solver allocate.
class ToolHandle {
 public:
  /// Target pose at the end of the solver's next step(). During that call the tool moves there from its present pose in
  /// a straight line at constant speed and turns by the shorter way (in run_to_rest(): during the first step).
  /// Afterwards it continues with ToolPose::velocity and ToolPose::spin. A solver that is made later starts it where it
  /// was added or last teleported to: reset() it to the other's read().
  void move_to(const ToolPose& pose) const;
  /// Puts the tool at a pose at once, without touching anything on the way. The next step moves covered particles out;
  /// they gain no speed and cause no force. A tool with Tool::compliance pushes them by its spring instead.
  void teleport(const ToolPose& pose) const;
  /// The last pose passed to move_to() or teleport(); Tool::pose before. Valid until the scene's tools change.
  const ToolPose& target_pose() const;

  /// From the next step on, free particles within `distance`, m, of the tool's surface, or inside it, move with the
  /// tool. Another grasp() adds particles. The tool does not grasp particles whose coordinates are all imposed
  /// (Scene::fix, translations) or that another tool holds. If tools grasp in the same step, the first in
  /// Scene::tools() has priority. Imposed coordinates always have priority over the tool. Throws Error for a negative
  /// distance, for a needle and for a blade.
  void grasp(double distance) const;
  /// From the next step on the tool holds nothing. A needle is let go: it moves with the tissue around its shaft, as a
  /// rigid body of no mass at Solver::tool_pose(), until move_to() or teleport() takes it again: after a step, not
  /// before.
  void release() const;

  std::uint64_t id() const { return id_; }  ///< SceneTool::id
  bool is_of(const Scene& scene) const { return scene_ == &scene; }

 private:
  friend class Scene;
  ToolHandle(Scene& scene, std::uint64_t id) : scene_(&scene), id_(id) {}
  SceneTool& own() const;
  Scene* scene_;
  std::uint64_t id_;
};

/// Changes a joint of a scene. The rules of ToolHandle apply. Solvers rebuild nothing after these calls.
/// Solver::stable_step() uses the new values.
class JointHandle {
 public:
  void set_stiffness(double stiffness, double damping) const;    ///< as in Joint; throws Error if one is negative
  void set_rest_length(double length) const;                     ///< m, of all springs; throws Error if negative
  void set_rest_lengths(std::span<const double> lengths) const;  ///< [springs] m; throws Error for another size, too
  const Joint& joint() const;                                    ///< valid until the scene's joints change

  std::uint64_t id() const { return id_; }  ///< SceneJoint::id
  bool is_of(const Scene& scene) const { return scene_ == &scene; }

 private:
  friend class Scene;
  JointHandle(Scene& scene, std::uint64_t id) : scene_(&scene), id_(id) {}
  Joint& own() const;
  Scene* scene_;
  std::uint64_t id_;
};

/// Changes what holds a thread. The rules of ToolHandle apply. Calls take effect in the next step. Functions throw
/// Error for values that are not finite, nodes and passages that the thread does not have, and as their comments say.
class ThreadHandle {
 public:
  /// Holds a node of a free thread. It goes to the place, m, at constant speed during the solver's next step() (in
  /// run_to_rest(): in the first step) and stays there; call again to move it. Throws Error for a sewn thread.
  void hold(Index node, const Vec3& position) const;
  void release(Index node) const;  ///< no error for a node that is not held

  /// Joins a tip to particles, a tool or a point of the world. A tip of a free thread that is elsewhere goes there
  /// during the next step(). From the tip of a sewn thread a segment leads to its first or last passage; its rest
  /// length becomes the distance. Throws Error as Scene::add_joint() does for an anchor.
  void join(ThreadTip tip, const Anchor& anchor) const;
  void pull(ThreadTip tip, const Vec3& force) const;  ///< N; through the passages of a sewn thread. 0: lets go
  void fix(ThreadTip tip) const;                      ///< TipHold::fixed; throws Error for a free thread
  /// TipHold::clamped: thread slips through above `holding`, N > 0. `gap`, m >= 0: during the next step() the segment
  /// next to it is drawn to this length, with at most that force; again by each call. Throws Error for a free thread.
  void clamp(ThreadTip tip, double holding, double gap = -1.0) const;

  /// Ties two passages of a sewn thread, by their rows as in Knot. From the next step on the thread slides through
  /// neither, and a segment joins them whose rest length is their distance then. Under more than throws *
  /// Thread::throw_holding the knot lets thread through. Again: changes the throws, or replaces a knot that broke.
  void tie(Index passage, Index other, int throws) const;
  void loosen(Index passage, Index other) const;  ///< no error for a knot that there is not

  void set(const ThreadControl& control) const;  ///< all of these calls at once; no change if it is the same
  const SceneThread& thread() const;             ///< valid until the scene's threads change

  std::uint64_t id() const { return id_; }  ///< SceneThread::id
  bool is_of(const Scene& scene) const { return scene_ == &scene; }

 private:
  friend class Scene;
  ThreadHandle(Scene& scene, std::uint64_t id) : scene_(&scene), id_(id) {}
  SceneThread& own() const;
  Scene* scene_;
  std::uint64_t id_;
};

/// Lifetimes: a scene keeps a pointer to its model, or shares its ownership. The model must not change. A scene cannot
/// be moved or assigned, because solvers and handles point to it. Only copy() copies it: write
/// `auto& scene = simulation.scene()`, since `auto scene` does not compile.
/// Threads: any number may read a scene. A thread that changes it must be the only one to use it and its solvers.
/// Errors: functions throw Error for an unknown group, an index out of range and a value that is not finite; the scene
/// then stays as it was. An empty list of particles is allowed and has no effect.
/// Priorities: forces add up. Imposed coordinates have priority over forces. If several loads impose the same
/// coordinate, the one added last has priority.
class Scene {
 public:
  explicit Scene(const Model& model);                  ///< throws Error unless validate(model) accepts it
  explicit Scene(const Model&&) = delete;              ///< a temporary would be gone before the first step
  explicit Scene(std::shared_ptr<const Model> model);  ///< shares ownership; throws Error also for null
  Scene& operator=(const Scene&) = delete;
  Scene copy() const { return *this; }  ///< a new scene of the same model, without solvers and handles

  const Model& model() const { return *model_; }

  // Functions that return a scene can be chained. Those with && are for scenes that are being made:
  // Scene scene = Scene(model).fix("x0").gravity(g);
  Scene& fix(std::string_view group) &;            ///< adds a load that holds the group at its rest position
  Scene& fix(std::span<const Index> particles) &;  ///< the same for listed particles
  Scene& gravity(const Vec3& acceleration) &;      ///< sets the gravity, m/s^2
  Scene& add(Load load) &;                         ///< appends a load, as row loads().size() - 1
  Scene& add(std::vector<Load> loads) &;           ///< appends loads, as read_lml returns them
  Scene fix(std::string_view group) && { return fix(group); }
  Scene fix(std::span<const Index> particles) && { return fix(particles); }
  Scene gravity(const Vec3& acceleration) && { return gravity(acceleration); }
  Scene add(Load load) && { return add(std::move(load)); }
  Scene add(std::vector<Load> loads) && { return add(std::move(loads)); }
  Scene& replace(std::size_t row, Load load);  ///< replaces loads()[row]
  Scene& remove(std::size_t row);              ///< removes loads()[row]; later rows decrease by 1
  Scene& clear();                              ///< removes everything

  /// Fills the surface of these cells with a fluid; incompressible, of the rest volume, unless VolumeConstraint says
  /// otherwise. In each step the pressure pushes every free particle of the surface along the volume's gradient, so
  /// far that volume and pressure at the step's end fit the law (single precision: the volume within about 1e-7). No
  /// law shortens the stable step. This conserves linear and angular momentum and does not move imposed coordinates.
  /// The backends gl and gl-compute take incompressible fluids without an opening. Throws Error if the surface is not
  /// closed or shares a particle with another one, for a name in use, for values out of range, and for a
  /// two-dimensional model.
  Scene& constrain_volume() &;                          ///< of all cells together
  Scene& constrain_volume(std::string_view group) &;    ///< of the cells of the group, as set_material()
  Scene& constrain_volume(VolumeConstraint surface) &;  ///< of the given triangles
  Scene constrain_volume() && { return constrain_volume(); }
  Scene constrain_volume(std::string_view group) && { return constrain_volume(group); }
  // By name; they throw Error, with the known names, for an unknown one; the last also if another one opens into it.
  Scene& set_volume(std::string_view name, double volume);  ///< m^3, > 0, of the fluid without pressure from now on
  Scene& set_fluid(std::string_view name, Fluid fluid);     ///< as much of it as there is; opens and closes openings
  Scene& remove_volume(std::string_view name);

  /// Switches contacts on, between parts of the model that no cell and no neighbourhood connects (bodies.h). Throws
  /// Error for options out of their range and for a two-dimensional model.
  Scene& contacts(const ContactOptions& options) &;
  Scene contacts(const ContactOptions& options) && { return contacts(options); }
  Scene& no_contacts();

  /// Multiplies the stiffness (Young's modulus and what follows from it) of all materials of the model, or of one, by a
  /// factor from 1e-6 to 1e6. A factor refers to the values in the model: 1 restores them. It is cheap for any size of
  /// body: solvers rebuild no tables, and allocate only when the factors change from all 1 or to all 1.
  /// Solver::stable_step() becomes a bound: at most the stable step of a body made with these constants, and seldom
  /// less than 0.7 of it. At the first factors a solver of a body of several materials estimates two more spectra
  /// (elasticity.h): call this once before a loop that must not pause. All backends of this library support it; others
  /// may report not_supported. Throws Error for a model without materials or without this one, and for a factor out of
  /// range.
  Scene& scale_stiffness(double factor);
  Scene& scale_stiffness(const Material& material, double factor);  ///< one equal to a row of Model::materials
  Scene& scale_stiffness(std::span<const double> factors);          ///< [number of materials]; empty: all 1
  Scene& scale_stiffness(std::initializer_list<double> factors);    ///< the same
  const std::vector<double>& stiffness_factors() const { return stiffness_factors_; }  ///< [materials]; empty: all 1

  /// Replaces the events of loads()[row], for values that change at every step. It is cheap for bodies of any size:
  /// nothing is allocated if the load had at least as many events before and the new ones are sorted.
  Scene& set_events(std::size_t row, std::span<const ValueEvent> events);

  /// Adds a tool. The next step starts with it at Tool::pose, as after ToolHandle::teleport(). Throws Error for a name
  /// that is empty or in use, and for a size or pose out of its range. Default names are "tool 1", "tool 2" and so on.
  ToolHandle add_tool(std::string name, Tool tool) &;
  ToolHandle add_tool(Tool tool) &;
  ToolHandle add_tool(ToolShape shape) &;     ///< with the defaults of Tool
  Scene& remove_tool(std::string_view name);  ///< throws Error also while a joint or a thread has an anchor there
  ToolHandle tool(std::string_view name) &;   ///< throws Error, with the known names, for an unknown one
  const std::vector<SceneTool>& tools() const { return tools_; }

  /// Adds a joint. Rest lengths below 0 become the distances of the anchors with the particles at `position` [N], m
  /// (empty: at rest), and tools at their last target pose. Throws Error for an empty or used name, a joint without
  /// springs, anchors that do not fit the scene, weights whose sum is not 1, a spring without particles or between
  /// equal anchors, and constants out of their range.
  JointHandle add_joint(std::string name, Joint joint, std::span<const Vec3> position = {}) &;
  JointHandle add_joint(Joint joint, std::span<const Vec3> position = {}) &;  ///< named "joint 1", "joint 2" and so on
  /// Adds a joint of one spring; stiffness in N/m, damping in N s/m.
  JointHandle add_joint(JointSpring spring, double stiffness, double damping = 0.0,
                        std::span<const Vec3> position = {}) &;

  /// Adds a joint with one spring for each particle of a patch, a list of particles of the surface. The patch has the
  /// facets whose particles are all listed, as for pressure loads. JointSpring::share is the particle's part of their
  /// rest area, m^2 (2-D: m). Particles without such a facet get no spring. The springs connect the patch with one of:
  /// - the world. Each spring ends at a fixed point.
  /// - a tool. They pull each particle back to its place in the tool's frame at the time of this call.
  /// - another body: the cells of a group. Each spring ends at a point that moves with the nearest cell, so that a gap
  ///   between patch and body stays and turns with the body.
  /// Throws Error if the patch has no facet, if a particle is farther than one cell from the group or belongs to it,
  /// and as add_joint().
  JointHandle attach(std::span<const Index> patch, const World& world, const Attachment& springs) &;
  JointHandle attach(std::span<const Index> patch, const ToolHandle& tool, const Attachment& springs) &;
  JointHandle attach(std::span<const Index> patch, std::string_view group, const Attachment& springs) &;

  /// Holds a part of the surface in all directions, as stiff glue to the world does. What is held depends on the
  /// patch alone; particles that fix() holds are those that happen to lie there, and the result changes with them. The
  /// joint has a spring for each point, between the cell that it is in and its place at rest. The stiffness per
  /// area is at most 25 E / h (Young's modulus, distance of vertices of a cell), and no particle gets more for its
  /// mass than 0.8 of the mean; 15 to 20 E / h result. The stable step becomes shorter by a tenth to two thirds, by
  /// more if points lie outside the body. JointSpring::share is the area times this reduction. Throws Error for a
  /// 2-D body or one without a material, for points farther than two cells from it, and for areas that are not
  /// above 0 and finite or are not as many as the points.
  JointHandle hold(const SurfacePatch& patch) &;

  Scene& remove_joint(std::string_view name);
  JointHandle joint(std::string_view name) &;  ///< throws Error, with the known names, for an unknown one
  const std::vector<SceneJoint>& joints() const { return joints_; }

  /// Adds a straight thread without speed, from its first tip along a direction of any length but 0. Throws Error for
  /// an empty or used name, values out of their range or not finite, more than 100,000 nodes, and a 2-D model.
  ThreadHandle add_thread(std::string name, const Thread& thread, const Vec3& start, const Vec3& direction) &;
  ThreadHandle add_thread(const Thread& thread, const Vec3& start, const Vec3& direction) &;  ///< "thread 1" and so on
  /// Adds a thread that passes through places of the body, m at rest. Each is bound to the cell that it is in, or is
  /// nearest to. Both tips are fixed. Throws Error also for fewer than 2 or more than 100 places, places farther than
  /// one cell outside the body or one on the other, and a thread shorter than its way.
  ThreadHandle sew(std::string name, const Thread& thread, std::span<const Vec3> places) &;
  ThreadHandle sew(const Thread& thread, std::span<const Vec3> places) &;
  /// The same with anchors of particles, as a recording has them.
  ThreadHandle sew(std::string name, const Thread& thread, std::vector<Anchor> passages) &;
  /// Adds a thread that a needle sews: its last tip is joined to the tail of that tool, and what leaves the tissue at
  /// the tail becomes passages of the thread, at most 100 (ThreadState::sewn). The first tip is free. Another hold of
  /// the last tip cuts the thread off. Without a needle nothing is joined. Throws Error as add_thread() does, and for a
  /// tool that is not a needle.
  ThreadHandle swage(std::string name, const Thread& thread, std::string_view needle) &;
  ThreadHandle swage(const Thread& thread, std::string_view needle) &;
  /// Clips two walls together, each held at its anchor of particles; ThreadHandle::pull() of both tips by 0, or
  /// remove_thread(), takes the clip off. It closes during the next step(). Throws Error as sew() does, and for a value
  /// out of its range.
  ThreadHandle add_clip(std::string name, const Clip& clip, const Anchor& one, const Anchor& other) &;
  ThreadHandle add_clip(const Clip& clip, const Anchor& one, const Anchor& other) &;  ///< "clip 1" and so on
  ThreadHandle add_thread(const SceneThread& thread) &;  ///< as it was added, without its SceneThread::control
  Scene& remove_thread(std::string_view name);
  ThreadHandle thread(std::string_view name) &;  ///< throws Error, with the known names, for an unknown one
  const std::vector<SceneThread>& threads() const { return threads_; }

  SceneParts parts() const;  ///< tools, joints and threads, as a Snapshot has them (state.h)
  /// Makes tools, joints and threads those of a snapshot, in its order: removes others and adds missing ones. Handles
  /// stay valid if the scene had a tool of the same name, shape and constants, a joint of the same name and springs, or
  /// a thread of the same name, constants and passages. Throws Error as add_tool(), add_joint() and the functions that
  /// add threads do, and then changes nothing.
  Scene& bring_back(const SceneParts& parts);

  /// From the next call of Simulation on, cells tear (phymul/tearing.h): all of the model, or those of one of its
  /// materials. Each call parts at most one row of cells along each front, as a cut (Simulation::cuts(),
  /// StepReport::torn). Needs a body of tetrahedra with spare particles (with_spare_particles). Throws Error for values
  /// out of their range, a 2-D model or one without materials, and a material that the model has not.
  Scene& tear(const Tearing& law);
  Scene& tear(const Material& material, const Tearing& law);
  const std::vector<Tearing>& tearing() const { return tearing_; }  ///< by Model::materials; empty: nothing tears

  const std::vector<Load>& loads() const { return loads_; }
  const Vec3& gravity() const { return gravity_; }
  const std::vector<VolumeConstraint>& volume_constraints() const { return volume_constraints_; }
  bool any_volume_open() const;
  /// Whether a triangle of this volume constraint is no longer at a cell (body_changed()): then its volume is not kept.
  bool is_open(std::size_t volume) const { return volume < open_volumes_.size() && open_volumes_[volume] != 0; }
  [[nodiscard]] const std::optional<ContactOptions>& contacts() const { return contacts_; }

  // For authors of backends (load_frame.h).
  /// Says that cells of the model were removed, brought back or cut (Simulation calls it): what depends on surface and
  /// masses follows. Particles without mass stay at their rest places, nothing touches or pulls them, and springs of
  /// joints that end at one are broken. `cuts`: all that the body has. What is imposed on a particle, and an
  /// acceleration, is so on its copies as well.
  /// `cells`: rows that are others than before, or not there any more; empty: any may be.
  void body_changed(const BodyCuts& cuts = {}, std::vector<Index> cells = {});
  std::uint64_t body_version() const { return body_version_; }                ///< counts its calls
  const std::vector<Index>& changed_cells() const { return changed_cells_; }  ///< of its last call
  /// Counts all changes except those that values_version() counts and those by a ToolHandle or ThreadHandle (SceneTool
  /// and SceneThread count these). A solver that finds a new value calls prepare() again.
  std::uint64_t version() const { return version_; }
  /// Counts calls of set_events(), of JointHandle, and of scale_stiffness() unless all factors were or become 1.
  std::uint64_t values_version() const { return values_version_; }
  void prepare(LoadFrame& frame) const;  ///< resizes a frame for this version(); allocates
  /// Fills a frame, prepared at this version(), for a time, s. Writes only the entries that loads act on. Does not
  /// allocate and does not throw.
  void evaluate(double time, LoadFrame& frame) const;
  LoadModes modes() const;                                        ///< of this version(); allocates
  void mode_values(double time, std::span<double> values) const;  ///< [LoadModes::count]; does not allocate

 private:
  Scene(const Scene&) = default;

  /// A prepared load: at a time only the multiplication by its value remains.
  struct Action {
    std::vector<Index> particles;  // sorted, each once
    VecList unit;                  // [particles] loads and translations: effect per unit of value; rotations: rest
                                   // place from the centroid, m
    Vec3 axis{0, 0, 0};            // unit axis of a rotation; direction of a uniform acceleration
    std::uint8_t imposed = 0;      // bit a set: coordinate a is imposed
    bool uniform = false;          // an acceleration of the whole body along one direction, which needs no forces
  };

  void set_factors(std::vector<double> factors);
  void find_removed();
  void follow_copies(const BodyCuts& cuts);
  void find_open_volumes();
  VolumeConstraint& volume_named(std::string_view name);
  void require(const Load& load) const;
  Action accepted(Load& load) const;
  Action prepared(const Load& load) const;
  Action prepared_rotation(const Load& load, Action action) const;
  Action prepared_pressure(const Load& load, Action action) const;
  Vec3 unit_direction(const Load& load, const Vec3& from) const;
  void require(const SceneJoint& joint, std::span<const Vec3> position) const;
  JointHandle attach(std::span<const Index> patch, std::span<const Anchor> partners, double rest_length,
                     const Attachment& springs);
  void require_new_thread(const SceneThread& thread) const;
  void bring_back_threads(const std::vector<SceneThread>& wanted);
  friend class ThreadHandle;
  friend class ToolHandle;
  friend class JointHandle;

  std::shared_ptr<const Model> owned_;  // or null
  const Model* model_;
  std::vector<Load> loads_;
  std::vector<Action> actions_;  // per load
  Vec3 gravity_{0, 0, 0};
  std::vector<double> stiffness_factors_;
  std::vector<Tearing> tearing_;
  std::vector<VolumeConstraint> volume_constraints_;
  std::optional<ContactOptions> contacts_;
  std::vector<SceneTool> tools_;
  std::vector<SceneJoint> joints_;
  std::vector<SceneThread> threads_;
  std::uint64_t next_tool_ = 1, next_joint_ = 1, next_thread_ = 1, next_volume_ = 1, volume_changes_ = 0;
  std::uint64_t version_ = 0, values_version_ = 0, body_version_ = 0;
  std::vector<Index> changed_cells_, removed_;         // the latter: particles without mass
  std::vector<BodyCut::Copy> copies_, undone_copies_;  // of all cuts; what was a copy, in ascending order
  std::vector<char> open_volumes_;                     // per volume constraint there was
};

}  // namespace phymul
