// SPDX-License-Identifier: MIT
#include "scene_bytes.h"

#include <phymul/state_file.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/fnv.h"

namespace phymul {
namespace {

/// Parts in the bytes alone, so that files are read that were written before snapshots had them.
constexpr const char *motion_part = "motion", *scene_part = "scene", *removed_part = "removed cells",
                     *cuts_part = "cuts", *blades_part = "blades", *threads_part = "threads",
                     *scene_threads_part = "scene threads", *fluids_part = "fluids", *sewn_part = "sewn passages",
                     *needles_part = "needles", *start_part = "start", *later_part = "cells to cut";

bool all_finite(const VecList& list) {
  return std::all_of(list.begin(), list.end(), [](const Vec3& v) { return v.allFinite(); });
}

void require_particle(const ByteReader& in, Index i, std::size_t count) {
  if (i >= 0 && static_cast<std::size_t>(i) < count) return;
  in.fail("expected particles from 0 to " + std::to_string(static_cast<long long>(count) - 1) + ", got " +
          std::to_string(i) + "; the file was written by something else");
}

/// For a ByteWriter and joints that are const, or a ByteReader and ones that are not.
template <class Bytes, class Joints>
void joint_state_fields(Bytes& bytes, Joints& joints) {
  bytes.list(joints, 12, "a number of joints", [&](auto& joint) {
    bytes.field(joint.name, "a joint's name");
    bytes.field(joint.broken, "broken springs");
  });
}

template <class Bytes, class Parts>
void scene_fields(Bytes& bytes, Parts& scene) {
  bytes.list(scene.tools, 139, "a number of tools", [&](auto& tool) {
    bytes.field(tool.first, "a tool's name");
    tool_fields(bytes, tool.second);
  });
  bytes.list(scene.joints, 37, "a number of joints", [&](auto& joint) {
    bytes.field(joint.first, "a joint's name");
    joint_fields(bytes, joint.second);
  });
}

template <class Bytes, class Tools, class Joints>
void report_fields(Bytes& bytes, Tools& tools, Joints& joints) {
  bytes.list(tools, 412, "a number of tools", [&](auto& tool) {
    pose_fields(bytes, tool.target);
    pose_fields(bytes, tool.last_pose);
    auto& [force, torque, mean_force, mean_torque, particles, held_mass, held_centre, held_inertia] = tool.force;
    for (auto* value : {&force, &torque, &mean_force, &mean_torque, &held_centre})
      bytes.field(*value, "a tool's force");
    bytes.field(particles, "a number of particles");
    bytes.field(held_mass, "a mass");
    for (int k = 0; k < 9; ++k) bytes.field(held_inertia(k / 3, k % 3), "a moment of inertia");
  });
  bytes.list(joints, 44, "a number of joints", [&](auto& joint) {
    bytes.field(joint.force, "a joint's force");
    bytes.field(joint.largest, "a force");
    bytes.field(joint.broken, "a number of broken springs");
    bytes.list(joint.springs, 33, "a number of springs", [&](auto& spring) {
      bytes.field(spring.force, "a spring's force");
      bytes.field(spring.length, "a length");
      bytes.field(spring.broken, "whether a spring is broken");
    });
  });
}

bool is_finite(const ToolMemory& tool) {
  const ToolForce& of = tool.force;
  return tool.last_pose.position.allFinite() && tool.last_pose.orientation.coeffs().allFinite() &&
         (of.force + of.torque + of.mean_force + of.mean_torque + of.held_centre).allFinite();
}

void take_scene(ByteReader& in, Snapshot& snapshot) {
  SceneParts scene;
  scene_fields(in, scene);
  report_fields(in, snapshot.tools, snapshot.joints);
  in.expect_end("the scene's tools and joints");
  if (snapshot.tools.size() != scene.tools.size() || snapshot.joints.size() != scene.joints.size() ||
      !std::ranges::all_of(snapshot.tools, [](const ToolMemory& tool) { return is_finite(tool); })) {
    in.fail("expected a report of finite numbers for each tool and joint before this byte; the file is damaged");
  }
  snapshot.scene = std::make_shared<const SceneParts>(std::move(scene));
}

template <class Bytes, class Fluids>
void fluid_fields(Bytes& bytes, Fluids& fluids) {
  bytes.list(fluids, 28, "a number of fluids", [&](auto& fluid) {
    bytes.field(fluid.name, "a fluid's name");
    bytes.field(fluid.volume, "a volume");
    bytes.field(fluid.pressure, "a pressure");
    bytes.field(fluid.pressure_before, "a pressure");
  });
}

template <class Bytes, class Points>
void blade_fields(Bytes& bytes, Points& points) {
  bytes.list(points, 57, "a number of points of a blade", [&](auto& point) {
    bytes.field(point.place, "a place along an edge");
    bytes.field(point.cell, "a cell");
    for (auto& weight : point.weights) bytes.field(weight, "a weight");
    bytes.field(point.along, "a place along an edge");
    bytes.field(point.ahead, "a distance from an edge");
    bytes.field(point.slides, "whether an edge slides");
  });
}

template <class Bytes, class Cells>
void later_fields(Bytes& bytes, Cells& cells) {
  bytes.list(cells, 36, "a number of cells", [&](auto& own) {
    bytes.field(own.cell, "a cell");
    for (auto& value : own.cut) bytes.field(value, "a distance from a cut");
  });
}

/// What states of tools written before do not have.
template <class Bytes, class Tools>
void needle_fields(Bytes& bytes, Tools& tools) {
  for (auto& tool : tools) {
    bytes.field(tool.needle.free, "whether a needle is free");
    for (auto& node : tool.needle.hole) bytes.field(node.out, "whether a hole ends");
  }
}

bool has_needle_fields(const ToolState& tool) {
  return tool.needle.free || std::ranges::any_of(tool.needle.hole, &NeedleNode::out);
}

}  // namespace

void put_snapshot(ByteWriter& out, const Snapshot& snapshot, bool with_scene) {
  out.u64(snapshot.state.position.size());
  out.real(snapshot.state.time);
  out.real(snapshot.last_dt);
  out.u32(static_cast<std::uint32_t>(snapshot.steps_at_rest));
  out.vectors(snapshot.state.position);
  out.vectors(snapshot.state.velocity);
  out.field(!snapshot.displacement.empty(), "");
  out.vectors(snapshot.displacement);
  out.u64(snapshot.state.tools.size());
  for (const ToolState& tool : snapshot.state.tools) put_tool_state(out, tool);
  joint_state_fields(out, snapshot.state.joints);
  std::vector<std::pair<const char*, std::string>> own;
  const auto add = [&](bool there, const char* name, const auto& put) {
    if (!there) return;
    ByteWriter part;
    put(part);
    own.emplace_back(name, part.bytes());
  };
  const State& state = snapshot.state;
  with_scene = with_scene && snapshot.scene;
  add(with_scene, scene_part, [&](ByteWriter& part) {
    scene_fields(part, *snapshot.scene);
    report_fields(part, snapshot.tools, snapshot.joints);
  });
  add(!snapshot.removed_cells.empty(), removed_part, [&](ByteWriter& part) { part.field(snapshot.removed_cells, ""); });
  add(!snapshot.cuts.empty(), cuts_part, [&](ByteWriter& part) { cuts_field(part, snapshot.cuts); });
  const bool blades = std::ranges::any_of(state.tools, [](const ToolState& tool) { return !tool.blade.empty(); });
  add(blades, blades_part, [&](ByteWriter& part) {
    for (const ToolState& tool : state.tools) blade_fields(part, tool.blade);
  });
  const bool scene_threads = with_scene && !snapshot.scene->threads.empty();
  add(scene_threads, scene_threads_part, [&](ByteWriter& part) { put_threads(part, snapshot.scene->threads); });
  add(!state.threads.empty(), threads_part, [&](ByteWriter& part) { put_thread_states(part, state.threads); });
  add(!state.fluids.empty(), fluids_part, [&](ByteWriter& part) { fluid_fields(part, state.fluids); });
  const bool sewn = std::ranges::any_of(state.threads, [](const ThreadState& thread) { return !thread.sewn.empty(); });
  add(sewn, sewn_part, [&](ByteWriter& part) { put_sewn(part, state.threads); });
  const bool needles = std::ranges::any_of(state.tools, has_needle_fields);
  add(needles, needles_part, [&](ByteWriter& part) { needle_fields(part, state.tools); });
  add(!snapshot.start.position.empty(), start_part, [&](ByteWriter& part) {
    part.real(snapshot.start.dt);
    part.vectors(snapshot.start.position);
    part.vectors(snapshot.start.velocity);
  });
  const auto& later = snapshot.start.cut_later;
  add(!later.empty(), later_part, [&](ByteWriter& part) { later_fields(part, later); });
  add(snapshot.growth != 0.0 || snapshot.max_speed != 0.0, motion_part, [&](ByteWriter& part) {
    part.real(snapshot.growth);
    part.real(snapshot.max_speed);
  });
  out.u64(snapshot.parts.size() + own.size());
  for (const Snapshot::Part& part : snapshot.parts) {
    out.text(part.name);
    out.text({reinterpret_cast<const char*>(part.bytes.data()), part.bytes.size()});
  }
  for (const auto& [name, bytes] : own) {
    out.text(name);
    out.text(bytes);
  }
}

std::vector<Index> take_removed_cells(ByteReader& in) {
  std::vector<Index> rows;
  in.field(rows, "removed cells");
  if (std::ranges::adjacent_find(rows, std::greater_equal()) != rows.end()) {
    in.fail("expected rows of removed cells in increasing order; the file is damaged");
  }
  return rows;
}

Snapshot take_snapshot(ByteReader& in) {
  Snapshot snapshot;
  const std::size_t count = in.count(48, "a number of particles");
  snapshot.state.time = in.real("a time");
  snapshot.last_dt = in.real("the last step");
  const std::uint32_t rested = in.u32("a count of steps at rest");
  if (rested > static_cast<std::uint32_t>(std::numeric_limits<int>::max())) {
    in.fail("expected a count of steps at rest, got " + std::to_string(rested) + "; the file is damaged");
  }
  snapshot.steps_at_rest = static_cast<int>(rested);
  snapshot.state.position = in.vectors(count, "positions");
  snapshot.state.velocity = in.vectors(count, "velocities");
  bool displaced = false;
  in.field(displaced, "whether there are displacements");
  if (displaced) snapshot.displacement = in.vectors(count, "displacements");
  const std::size_t tools = in.count(40, "a number of tools");
  for (std::size_t k = 0; k < tools; ++k) {
    snapshot.state.tools.push_back(take_tool_state(in));
    for (const Index i : snapshot.state.tools.back().held) require_particle(in, i, count);
    for (const NeedleNode& node : snapshot.state.tools.back().needle.hole) {
      for (const Index i : node.particles) require_particle(in, i, count);
    }
  }
  joint_state_fields(in, snapshot.state.joints);
  const std::size_t parts = in.count(8, "a number of parts");
  for (std::size_t k = 0; k < parts; ++k) {
    Snapshot::Part part;
    part.name = in.text("a part's name");
    ByteReader bytes = in.nested("a part");
    const auto is_own = [&](const char* name, const char* what, const auto& take) {
      if (part.name != name) return false;
      take();
      bytes.expect_end(what);
      return true;
    };
    if (is_own(cuts_part, "the cuts", [&] { cuts_field(bytes, snapshot.cuts); }) ||
        is_own(threads_part, "the threads", [&] { snapshot.state.threads = take_thread_states(bytes); }) ||
        is_own(sewn_part, "the passages of threads", [&] { take_sewn(bytes, snapshot.state.threads); }) ||
        is_own(needles_part, "the needles", [&] { needle_fields(bytes, snapshot.state.tools); })) {
      continue;
    }
    if (part.name == scene_part) {
      take_scene(bytes, snapshot);
      continue;
    }
    if (part.name == removed_part) {
      snapshot.removed_cells = take_removed_cells(bytes);
      bytes.expect_end("the removed cells");
      continue;
    }
    if (part.name == blades_part) {
      for (ToolState& tool : snapshot.state.tools) blade_fields(bytes, tool.blade);
      bytes.expect_end("the points of blades");
      continue;
    }
    if (part.name == scene_threads_part) {
      SceneParts with = snapshot.scene ? *snapshot.scene : SceneParts{};
      with.threads = take_threads(bytes);
      bytes.expect_end("the scene's threads");
      snapshot.scene = std::make_shared<const SceneParts>(std::move(with));
      continue;
    }
    if (part.name == fluids_part) {
      fluid_fields(bytes, snapshot.state.fluids);
      bytes.expect_end("the fluids");
      const bool sound = std::ranges::all_of(snapshot.state.fluids, [](const FluidState& fluid) {
        return fluid.volume > 0.0 && std::isfinite(fluid.volume) && std::isfinite(fluid.pressure) &&
               std::isfinite(fluid.pressure_before);
      });
      if (!sound) in.fail("expected fluids with a volume above 0 and finite pressures; the file is damaged");
      continue;
    }
    if (part.name == start_part) {
      Snapshot::Start& start = snapshot.start;
      start.dt = bytes.real("a step");
      start.position = bytes.vectors(count, "positions");
      start.velocity = bytes.vectors(count, "velocities");
      bytes.expect_end("the start");
      const bool sound = all_finite(start.position) && all_finite(start.velocity) && start.dt >= 0.0;
      if (!sound || !std::isfinite(start.dt)) in.fail("expected finite numbers where the first step begins");
      continue;
    }
    if (part.name == later_part) {
      later_fields(bytes, snapshot.start.cut_later);
      bytes.expect_end("the cells to cut");
      const bool sound = std::ranges::all_of(snapshot.start.cut_later, [](const Snapshot::CutLater& own) {
        return own.cell >= 0 && std::ranges::all_of(own.cut, [](double value) { return std::isfinite(value); });
      });
      if (!sound) in.fail("expected rows of cells and finite distances from cuts; the file is damaged");
      continue;
    }
    if (part.name == motion_part) {
      snapshot.growth = bytes.real("a growth");
      snapshot.max_speed = bytes.real("a speed");
      if (!(snapshot.growth >= 0.0 && snapshot.max_speed >= 0.0)) in.fail("expected a growth and a speed of 0 or more");
      continue;
    }
    const std::string_view all = bytes.raw(bytes.remaining(), "a part");
    part.bytes.assign(all.begin(), all.end());
    snapshot.parts.push_back(std::move(part));
  }
  const bool finite = is_finite(snapshot.state) && all_finite(snapshot.displacement) && snapshot.last_dt >= 0.0 &&
                      std::isfinite(snapshot.last_dt);
  if (!finite) in.fail("expected finite numbers in the state before this byte; it was written by something else");
  return snapshot;
}

std::uint64_t fingerprint(const Snapshot& snapshot) {
  ByteWriter bytes;
  put_snapshot(bytes, snapshot, false);
  Fnv sum;
  sum.bytes(bytes.bytes());
  return sum.value();
}

}  // namespace phymul
