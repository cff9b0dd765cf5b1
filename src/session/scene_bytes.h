// SPDX-License-Identifier: MIT
//
// A scene in bytes, load by load. A change of a scene is: whether it starts from an empty one (u8), gravity, contacts,
// the factors of the materials' stiffness (count, f64 each), the number of loads (u64), the changed ones (count, then
// row and load each), the joints that stay, by name, with their stiffness, damping and rest lengths where these
// changed, all tools by name, with what they are where they are new, the new joints, after an empty scene a number of
// kept volumes (0, but in older files) and the threads, if anything follows, all volumes, if they or what comes after
// them changed, the laws of tearing, if they or what comes after changed, and the names of all tools and joints, where
// new ones come before others. Later changes of threads are inputs of their own.
//
// Cuts of a body in files.
//
// A snapshot in bytes: count of particles (u64), time, last_dt (f64), steps_at_rest (u32), positions, velocities (f64
// each), whether there are displacements (u8) and they, the count of tools (u64) and their states, the count of joints
// with broken springs (u64) and each as name and their rows, the count of parts (u64) and each as name and bytes (u64).
// Parts of these bytes alone: "motion", growth and max_speed (f64), and "scene", Snapshot::scene, tools and joints.
#pragma once

#include <phymul/body_cut.h>
#include <phymul/scene.h>
#include <phymul/state.h>
#include <phymul/tool.h>

#include <span>

#include "base/checked_file.h"

namespace phymul {

std::string load_bytes(const Load& load);
Load take_load(ByteReader& in);  ///< throws Error for a value that no load has; the scene checks the rest

/// A scene as it was: what a change is told from.
struct SceneBefore {
  std::vector<std::string> loads;  ///< load_bytes of each
  std::vector<VolumeConstraint> volumes;
  std::vector<std::uint64_t> tools;  ///< SceneTool::id
  struct Joint {
    std::uint64_t id = 0;  ///< SceneJoint::id
    std::string values;    ///< stiffness, damping, rest lengths
  };
  std::vector<Joint> joints;
  std::vector<Tearing> tearing;
};
SceneBefore scene_as_it_is(const Scene& scene);

/// The change from a scene as it was; `anew`: from an empty one.
std::string scene_change_bytes(const Scene& scene, const SceneBefore& before, bool anew);

/// Makes such a change. Throws Error for bytes that are none, or that the scene refuses.
void change_scene(Scene& scene, ByteReader& in);

/// What makes a scene with the volumes `before` one with those of `scene`.
void put_volumes(ByteWriter& out, const Scene& scene, std::span<const VolumeConstraint> before);
void take_volumes(ByteReader& in, Scene& scene);
void take_old_volumes(ByteReader& in, Scene& scene);  ///< as files had them before fluids

/// For a ByteWriter and a pose that is const, or a ByteReader and one that is not.
template <class Bytes, class Pose>
void pose_fields(Bytes& bytes, Pose& pose) {
  bytes.field(pose.position, "a tool's position");
  for (int k = 0; k < 4; ++k) bytes.field(pose.orientation.coeffs()[k], "a tool's orientation");  // x, y, z, w
  bytes.field(pose.velocity, "a tool's velocity");
  bytes.field(pose.spin, "a tool's spin");
}

/// The shape's code (u8), then the members of the shape, pose and coefficients.
void tool_fields(ByteWriter& out, const Tool& tool);
void tool_fields(ByteReader& in, Tool& tool);  ///< throws Error for a shape there is none of; the scene checks the rest

void put_tool_state(ByteWriter& out, const ToolState& state);
ToolState take_tool_state(ByteReader& in);  ///< throws Error for lists that do not fit together

// The joints and the threads of a scene in bytes, and the states of threads.

// Joints. For a ByteWriter and a thing that is const, or a ByteReader and one that is not; the scene checks a joint.

template <class Bytes, class Any>
void anchor_fields(Bytes& bytes, Any& anchor) {
  bytes.field(anchor.particles, "an anchor's particles");
  bytes.list(anchor.weights, 8, "a number of weights", [&](auto& weight) { bytes.field(weight, "a weight"); });
  bytes.field(anchor.tool, "an anchor's tool");
  bytes.field(anchor.point, "an anchor's point");
}

template <class Bytes, class Any>
void joint_fields(Bytes& bytes, Any& joint) {
  bytes.list(joint.springs, 104, "a number of springs", [&](auto& spring) {
    anchor_fields(bytes, spring.a);
    anchor_fields(bytes, spring.b);
    bytes.field(spring.rest_length, "a rest length");
    bytes.field(spring.share, "a spring's share");
  });
  bytes.field(joint.stiffness, "a joint's stiffness");
  bytes.field(joint.damping, "a joint's damping");
  bytes.field(joint.slack, "whether a joint is slack");
  bytes.field(joint.breaking_force, "a breaking force");
}

void put_threads(ByteWriter& out, const std::vector<SceneThread>& threads);
std::vector<SceneThread> take_threads(ByteReader& in);
void add_threads(ByteReader& in, Scene& scene);  ///< throws Error for bytes that the scene refuses

/// What a ThreadHandle changed. `in`: of a thread that the scene has.
void put_control(ByteWriter& out, const ThreadControl& control);
void change_control(ByteReader& in, const ThreadHandle& thread);

/// ThreadState::sewn of each, apart from the rest: files written before have none.
void put_sewn(ByteWriter& out, const std::vector<ThreadState>& threads);
void take_sewn(ByteReader& in, std::vector<ThreadState>& threads);
void put_thread_states(ByteWriter& out, const std::vector<ThreadState>& threads);
std::vector<ThreadState> take_thread_states(ByteReader& in);

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

void put_snapshot(ByteWriter& out, const Snapshot& snapshot, bool with_scene = true);

/// Rows of Model::cells, which must be ascending.
std::vector<Index> take_removed_cells(ByteReader& in);

/// Throws Error where a number is not finite, too.
Snapshot take_snapshot(ByteReader& in);

}  // namespace phymul
