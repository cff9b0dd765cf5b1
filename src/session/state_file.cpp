// SPDX-License-Identifier: MIT
#include <phymul/error.h>
#include <phymul/state_file.h>

#include <algorithm>
#include <limits>
#include <ostream>

#include "base/byte_source.h"
#include "base/checked_file.h"
#include "base/files.h"
#include "scene_bytes.h"

namespace phymul {
namespace {

constexpr FileKind state_kind{"phymulSt", 4, "a state file"};
constexpr const char* body_tag = "body";
constexpr const char* state_tag = "stat";

std::size_t bytes_of(const Snapshot& snapshot) {
  std::size_t bytes =
      sizeof(Snapshot) + sizeof(Vec3) * (snapshot.state.position.size() + snapshot.state.velocity.size() +
                                         snapshot.displacement.size() + 2 * snapshot.start.position.size());
  for (const ToolState& tool : snapshot.state.tools) {
    bytes += sizeof tool + tool.name.size() + tool.held.size() * (sizeof(Index) + sizeof(Vec3));
    bytes += tool.needle.shaft.size() * sizeof(ShaftLoad) + tool.blade.size() * sizeof(BladePoint);
    for (const NeedleNode& node : tool.needle.hole) {
      bytes += sizeof node + node.particles.size() * (sizeof(Index) + sizeof(double));
    }
  }
  for (const JointState& joint : snapshot.state.joints) {
    bytes += sizeof joint + joint.name.size() + joint.broken.size() * sizeof(Index);
  }
  for (const ThreadState& thread : snapshot.state.threads) {
    bytes += sizeof thread + 2 * thread.position.size() * (sizeof(Vec3) + sizeof(double));
    for (const Anchor& own : thread.sewn) bytes += sizeof own + own.particles.size() * (sizeof(Index) + sizeof(double));
  }
  bytes += snapshot.start.cut_later.size() * sizeof(Snapshot::CutLater);
  for (const FluidState& fluid : snapshot.state.fluids) bytes += sizeof fluid + fluid.name.size();
  bytes += snapshot.tools.size() * sizeof(ToolMemory);  // Snapshot::scene is shared by all that have the same
  for (const JointReport& joint : snapshot.joints) bytes += sizeof joint + joint.springs.size() * sizeof(SpringReport);
  bytes += snapshot.removed_cells.size() * sizeof(Index) + snapshot.cuts.size() * sizeof(snapshot.cuts.front());
  for (const Snapshot::Part& part : snapshot.parts) bytes += sizeof part + part.name.size() + part.bytes.size();
  return bytes;
}

}  // namespace

void save_state(const Solver& solver, const std::string& path) {
  save_state(solver.snapshot(), path);
}

void save_state(const Snapshot& snapshot, const std::string& path) {
  ByteWriter body, state;
  body.u64(snapshot.topology_hash);
  body.text(snapshot.backend);
  put_snapshot(state, snapshot);
  SectionWriter file(state_kind);
  file.add(body_tag, body);
  file.add(state_tag, state);
  const std::string bytes = file.finish();
  replace_file(path, [&](std::ostream& out) { out.write(bytes.data(), static_cast<std::streamsize>(bytes.size())); });
}

Snapshot read_state_bytes(std::string_view bytes, const std::string& name) {
  const std::vector<FileSection> sections = read_sections(name, bytes, state_kind, {body_tag, state_tag});
  ByteReader body(name, sections[0].payload, sections[0].first_byte);
  const std::uint64_t topology_hash = body.u64("the topology's hash");
  std::string backend = body.text("a backend's name");
  body.expect_end("section \"body\"");
  ByteReader state(name, sections[1].payload, sections[1].first_byte);
  Snapshot snapshot = take_snapshot(state);
  snapshot.topology_hash = topology_hash;
  snapshot.backend = std::move(backend);
  state.expect_end("section \"stat\"");
  return snapshot;
}

Snapshot read_state(const std::string& path) {
  return read_state_bytes(read_whole_file(path, std::numeric_limits<std::size_t>::max()), path);
}

void load_state(Solver& solver, const std::string& path) {
  const Snapshot snapshot = read_state(path);
  try {
    solver.restore(snapshot);
  } catch (const Error& error) {
    throw in_file(path, with_prefix(path + ": ", error));
  }
}

StateHistory::StateHistory(int every, std::size_t most_bytes) : every_(every), most_bytes_(most_bytes) {
  if (every < 1 || most_bytes < 1) {
    throw Error("StateHistory: expected a state every 1 step or more and room for 1 byte or more, got " +
                std::to_string(every) + " and " + std::to_string(most_bytes));
  }
}

void StateHistory::drop_after(double time) {
  while (!states_.empty() && states_.back().state.time > time) {
    bytes_ -= bytes_of(states_.back());
    states_.pop_back();
  }
}

void StateHistory::follow(const Solver& solver, const StepReport& report, const Snapshot::Start& start) {
  const bool same_body =
      states_.empty() || states_.back().topology_hash == solver.topology_hash() ||
      states_.back().topology_hash == fingerprint(solver.topology(), states_.back().removed_cells, states_.back().cuts);
  if (!same_body) {
    throw Error(
        "StateHistory::follow: expected a solver of the body whose states are kept, got one of another shape, "
        "material, order of particles or other options of the tables; clear() the history, or keep one for each body");
  }
  if (report.status == StepStatus::invalid_step) return;  // nothing was done
  drop_after(report.time);
  since_ += report.steps;
  if (!states_.empty() && since_ < every_) return;
  Snapshot now = solver.snapshot();
  now.start = start;
  bytes_ += bytes_of(now);
  states_.push_back(std::move(now));
  since_ = 0;
  // The newest stays, however large: a history without any would be none.
  while (bytes_ > most_bytes_ && states_.size() > 1) {
    bytes_ -= bytes_of(states_.front());
    states_.pop_front();
  }
}

const Snapshot* StateHistory::newest_at(double time) const {
  // A sum of steps is seldom the time that it stands for.
  const auto after = std::upper_bound(states_.begin(), states_.end(), time, [](double when, const Snapshot& state) {
    return !(state.state.time - 1e-3 * state.last_dt <= when);
  });
  return after == states_.begin() ? nullptr : &*(after - 1);
}

bool StateHistory::rewind(Solver& solver, double time) {
  const Snapshot* const found = newest_at(time);
  if (found == nullptr) return false;
  solver.restore(*found);
  drop_after(found->state.time);
  since_ = 0;
  return true;
}

void StateHistory::clear() {
  states_.clear();
  bytes_ = 0;
  since_ = 0;
}

}  // namespace phymul
