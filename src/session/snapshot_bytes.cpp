// SPDX-License-Identifier: MIT
#include "snapshot_bytes.h"

#include <phymul/state_file.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/fnv.h"
#include "tool_bytes.h"

namespace phymul {
namespace {

/// A part in the bytes alone, so that files have it which were written before snapshots had it.
constexpr const char* motion_part = "motion";

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

}  // namespace

void put_snapshot(ByteWriter& out, const Snapshot& snapshot) {
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
  const bool moved = snapshot.growth != 0.0 || snapshot.max_speed != 0.0;
  out.u64(snapshot.parts.size() + (moved ? 1 : 0));
  for (const Snapshot::Part& part : snapshot.parts) {
    out.text(part.name);
    out.text({reinterpret_cast<const char*>(part.bytes.data()), part.bytes.size()});
  }
  if (!moved) return;
  ByteWriter motion;
  motion.real(snapshot.growth);
  motion.real(snapshot.max_speed);
  out.text(motion_part);
  out.text(motion.bytes());
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
    const std::string bytes = in.text("a part");
    if (part.name == motion_part) {
      ByteReader motion("", bytes);
      snapshot.growth = motion.real("a growth");
      snapshot.max_speed = motion.real("a speed");
      if (!(snapshot.growth >= 0.0 && snapshot.max_speed >= 0.0)) in.fail("expected a growth and a speed of 0 or more");
      continue;
    }
    part.bytes.assign(bytes.begin(), bytes.end());
    snapshot.parts.push_back(std::move(part));
  }
  const bool finite = is_finite(snapshot.state) && all_finite(snapshot.displacement) && snapshot.last_dt >= 0.0 &&
                      std::isfinite(snapshot.last_dt);
  if (!finite) in.fail("expected finite numbers in the state before this byte; it was written by something else");
  return snapshot;
}

std::uint64_t fingerprint(const Snapshot& snapshot) {
  ByteWriter bytes;
  put_snapshot(bytes, snapshot);
  Fnv sum;
  sum.bytes(bytes.bytes());
  return sum.value();
}

}  // namespace phymul
