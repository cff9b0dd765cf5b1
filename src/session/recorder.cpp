// SPDX-License-Identifier: MIT
#include <phymul/error.h>
#include <phymul/recording.h>

#include <algorithm>
#include <limits>
#include <ostream>

#include "base/byte_source.h"
#include "base/checked_file.h"
#include "base/files.h"
#include "scene_bytes.h"
#include "wire_codes.h"

namespace phymul {
namespace {

std::string step_bytes(int n, double dt) {
  ByteWriter out;
  out.index(n);
  out.real(dt);
  return out.bytes();
}

std::string snapshot_bytes(const Snapshot& snapshot) {
  ByteWriter out;
  put_snapshot(out, snapshot);
  return out.bytes();
}

bool is_word(std::string_view kind) {
  return kind.size() == 4 && std::all_of(kind.begin(), kind.end(), [](unsigned char c) { return std::isgraph(c); });
}

/// What a call that throws has done is recorded as a state.
template <class Call>
auto recorded_if_thrown(Recorder& recorder, const Solver& solver, const Call& call) {
  try {
    return call();
  } catch (...) {
    recorder.restore(solver.snapshot());
    throw;
  }
}

/// Grows with every change of the scene, and with every change of a load's values alone.
std::uint64_t changes_of(const Scene& scene) {
  return scene.version() + scene.values_version();
}

}  // namespace

RecordedOptions recorded_options(const Solver& solver) {
  const SolverOptions& options = solver.options();
  return {.damping_rate = options.damping.rate,
          .damping_factor = options.damping.factor,
          .max_displacement_per_step = options.max_displacement_per_step,
          .rest_tolerance = options.rest_tolerance,
          .sleep_tolerance = options.sleep_tolerance.value_or(-1.0),
          .stable_step = solver.stable_step(),
          .rest_steps = options.rest_steps,
          .max_substeps = options.max_substeps,
          .allows_unstable = options.on_unstable == UnstableStep::allow};
}

Recorder::Recorder(Solver& solver, const Scene& scene) : solver_(solver), scene_(scene) {
  if (&scene.model() != &solver.model()) throw Error("Recorder: the scene was made for another model");
  recording_.topology_hash = solver.topology_hash();
  keep_body();
  recording_.backend = solver.name();
  recording_.device = solver.device();
  recording_.options = recorded_options(solver);
  // A step of none takes the scene over, if it has changed: a solver then forgets how long its body has rested. Poses
  // and grasps that no step has seen yet are forgotten too, for a recording starts from states.
  solver_.step(0, 1e-18);  // s, the shortest that is taken
  recording_.start = solver_.snapshot();
  solver_.restore(recording_.start);
  recording_.scene = scene_change_bytes(scene_, {}, true);
  keep_scene();
  see_threads();
}

void Recorder::keep_scene() {
  const bool starting = !before_;
  before_ = std::make_unique<SceneBefore>(scene_as_it_is(scene_));
  scene_version_ = changes_of(scene_);
  std::map<std::uint64_t, SeenTool> now;
  for (const SceneTool& tool : scene_.tools()) {
    const auto known = seen_tools_.find(tool.id);
    now[tool.id] = known != seen_tools_.end() ? known->second
                   : starting                 ? SeenTool{tool.moves, tool.places, tool.grasps}
                                              : SeenTool{};
  }
  seen_tools_ = std::move(now);
}

Recorder::~Recorder() = default;

void Recorder::record(std::string_view kind, std::string bytes) {
  std::vector<Input>& inputs = recording_.inputs;
  if (!inputs.empty() && kind == input_kind::step && inputs.back().kind == kind && inputs.back().bytes == bytes) {
    ++inputs.back().times;
    return;
  }
  inputs.push_back({std::string(kind), std::move(bytes), 1});
}

/// Even a change to the same scene is one: solvers look at the version.
void Recorder::record_scene() {
  record_threads(true);
  if (scene_version_ != changes_of(scene_)) {
    record(input_kind::scene, scene_change_bytes(scene_, *before_, false));
    keep_scene();
  }
  record_threads(false);
  for (const SceneTool& tool : scene_.tools()) record_tool(tool);
}

void Recorder::see_threads() {
  seen_threads_.clear();
  for (const SceneThread& thread : scene_.threads()) seen_threads_[thread.id] = {thread.name, thread.changes};
}

/// Threads leave tools before these go, and take hold of them when they are there.
void Recorder::record_threads(bool before_scene) {
  const auto record_one = [&](const std::string& name, input_kind::ThreadChange change, const auto& put) {
    ByteWriter out;
    out.text(name);
    out.u8(static_cast<std::uint8_t>(change));
    put(out);
    record(input_kind::thread, out.bytes());
  };
  for (const auto& [id, seen] : seen_threads_) {
    const bool stays = std::ranges::find(scene_.threads(), id, &SceneThread::id) != scene_.threads().end();
    if (before_scene && !stays) record_one(seen.name, input_kind::ThreadChange::removes, [](ByteWriter&) {});
  }
  std::erase_if(seen_threads_, [&](const auto& seen) {
    return std::ranges::find(scene_.threads(), seen.first, &SceneThread::id) == scene_.threads().end();
  });
  for (const SceneThread& thread : scene_.threads()) {
    const auto known = seen_threads_.find(thread.id);
    const bool at_tool =
        std::ranges::any_of(thread.control.ends, [](const ThreadEnd& end) { return !end.anchor.tool.empty(); });
    const bool changed = known != seen_threads_.end() && known->second.changes != thread.changes;
    if (before_scene && changed && at_tool && scene_version_ != changes_of(scene_)) {
      ThreadControl without = thread.control;
      for (ThreadEnd& end : without.ends) end = end.anchor.tool.empty() ? end : ThreadEnd{};
      record_one(thread.name, input_kind::ThreadChange::control, [&](ByteWriter& out) { put_control(out, without); });
    }
    if (before_scene && (known == seen_threads_.end() || at_tool)) continue;
    if (known == seen_threads_.end()) {
      record_one(thread.name, input_kind::ThreadChange::adds, [&](ByteWriter& out) { put_threads(out, {thread}); });
    } else if (changed) {
      record_one(thread.name, input_kind::ThreadChange::control,
                 [&](ByteWriter& out) { put_control(out, thread.control); });
    }
    seen_threads_[thread.id] = {thread.name, thread.changes};
  }
}

/// Of several poses between two steps solvers see the last.
void Recorder::record_tool(const SceneTool& tool) {
  SeenTool& seen = seen_tools_.at(tool.id);
  if (seen.moves != tool.moves) {
    ByteWriter out;
    out.text(tool.name);
    out.u8(seen.places != tool.places ? 1 : 0);
    pose_fields(out, tool.pose);
    record(input_kind::pose, out.bytes());
  }
  const auto record_grasp = [&](bool grasps) {
    ByteWriter out;
    out.text(tool.name);
    out.u8(grasps ? 1 : 0);
    out.real(tool.grasp_distance);
    record(input_kind::grasp, out.bytes());
  };
  if (tool.released > seen.grasps) record_grasp(false);
  if (seen.grasps != tool.grasps && tool.grasping) record_grasp(true);
  seen = {tool.moves, tool.places, tool.grasps};
}

StepReport Recorder::step(int n, double dt) {
  record_scene();
  const StepReport report = recorded_if_thrown(*this, solver_, [&] { return solver_.step(n, dt); });
  if (report.status == StepStatus::invalid_step) return report;  // nothing was done
  record(input_kind::step, step_bytes(report.stopped ? report.steps : n, dt));
  return report;
}

RestResult Recorder::run_to_rest(int max_steps, double dt) {
  return run_to_rest(max_steps, dt, solver_.options().damping);
}

RestResult Recorder::run_to_rest(int max_steps, double dt, const Damping& damping) {
  record_scene();
  const RestResult result =
      recorded_if_thrown(*this, solver_, [&] { return solver_.run_to_rest(max_steps, dt, damping); });
  if (result.report.status == StepStatus::invalid_step) return result;
  const StepReport& report = result.report;
  const std::string steps = step_bytes(report.stopped ? report.steps : max_steps, dt);
  if (damping == solver_.options().damping) return record(input_kind::to_rest, steps), result;
  ByteWriter out;
  out.raw(steps);
  out.real(damping.rate);
  out.real(damping.factor);
  record(input_kind::to_rest_damped, out.bytes());
  return result;
}

void Recorder::reset() {
  reset(rest_state(solver_.model()));
}

void Recorder::reset(const State& state) {
  solver_.reset(state);  // throws for a state that is none, before it is written down
  Snapshot plain;
  plain.state = state;
  plain.removed_cells = solver_.topology().removed;
  plain.cuts = solver_.topology().cuts;
  keep_body();
  record_scene();
  record(input_kind::restore, snapshot_bytes(plain));
}

void Recorder::restore(const Snapshot& snapshot) {
  solver_.restore(snapshot);
  // Scene::bring_back() may have put tools before others; what a scene made anew has lost, the snapshot has.
  if (scene_version_ != changes_of(scene_)) {
    record(input_kind::scene, scene_change_bytes(scene_, *before_, true));
    keep_scene();
    see_threads();  // it has them
  }
  keep_body();
  record_scene();
  record(input_kind::restore, snapshot_bytes(snapshot));
}

void Recorder::keep_body() {
  cuts_ = solver_.topology().cuts;
  removed_ = solver_.topology().removed;
}

void Recorder::body_changed() {
  const TopologyTextures& body = solver_.topology();
  if (before_) before_->loads.clear();  // which the replay has otherwise after the edit: with copies, or without
  if (!equal_cuts(cuts_, body.cuts)) {
    const auto stays = static_cast<std::size_t>(std::ranges::mismatch(cuts_, body.cuts).in1 - cuts_.begin());
    ByteWriter out;
    out.u64(stays);
    cuts_field(out, BodyCuts(body.cuts.begin() + static_cast<std::ptrdiff_t>(stays), body.cuts.end()));
    record(input_kind::cut, out.bytes());
  }
  if (removed_ != body.removed) {
    ByteWriter out;
    out.field(body.removed, "");
    record(input_kind::removed, out.bytes());
  }
  keep_body();
}

void Recorder::note(std::string_view kind, std::string bytes) {
  if (!is_word(kind) || input_kind::is_own(kind)) {
    throw Error("Recorder::note: expected a kind of four letters that is not one of the library's, got " + cited(kind));
  }
  record_scene();
  record(kind, std::move(bytes));
}

void Recorder::checkpoint() {
  const Snapshot now = solver_.snapshot();
  ByteWriter out;
  out.u64(fingerprint(now));
  out.real(now.state.time);
  record_scene();
  record(input_kind::checkpoint, out.bytes());
}

namespace {

constexpr FileKind recording_kind{"phymulRe", 6, "a recording"};
constexpr const char* head_tag = "head";
constexpr const char* start_tag = "stat";
constexpr const char* scene_tag = "scne";
constexpr const char* inputs_tag = "inpt";
constexpr const char* substeps_field = "a number of substeps";  // only there if it is not 1

/// For a ByteWriter and a recording that is const, or a ByteReader and one that is not.
template <class Bytes, class Any>
void head_fields(Bytes& bytes, Any& recording) {
  bytes.field(recording.topology_hash, "the topology's hash");
  bytes.field(recording.backend, "a backend's name");
  bytes.field(recording.device, "a device's name");
  auto& options = recording.options;
  for (auto* value : {&options.damping_rate, &options.damping_factor, &options.max_displacement_per_step,
                      &options.rest_tolerance, &options.sleep_tolerance, &options.stable_step}) {
    bytes.field(*value, "an option");
  }
  bytes.field(options.rest_steps, "a number of steps");
  bytes.field(options.allows_unstable, "whether steps beyond the limit are allowed");
}

void put_inputs(ByteWriter& out, const std::vector<Input>& inputs) {
  out.u64(inputs.size());
  for (const Input& input : inputs) {
    out.raw(input.kind);
    out.u64(input.times);
    out.u64(input.bytes.size());
    out.raw(input.bytes);
  }
}

std::vector<Input> take_inputs(ByteReader& in) {
  std::vector<Input> inputs(in.count(20, "a number of inputs"));
  for (Input& input : inputs) {
    input.kind = in.raw(4, "an input's kind");
    input.times = in.u64("how often an input was made");
    if (input.times == 0) in.fail("expected 1 or more times, got 0; the file was written by something else");
    input.bytes = in.raw(in.count(1, "an input's length"), "an input");
  }
  in.expect_end("section \"inpt\"");
  return inputs;
}

}  // namespace

void save_recording(const Recording& recording, const std::string& path) {
  ByteWriter head, start, scene, inputs;
  head_fields(head, recording);
  if (recording.options.max_substeps != 1) head.field(recording.options.max_substeps, substeps_field);
  put_snapshot(start, recording.start);
  scene.raw(recording.scene);
  put_inputs(inputs, recording.inputs);
  SectionWriter file(recording_kind);
  file.add(head_tag, head);
  file.add(start_tag, start);
  file.add(scene_tag, scene);
  file.add(inputs_tag, inputs);
  const std::string bytes = file.finish();
  replace_file(path, [&](std::ostream& out) { out.write(bytes.data(), static_cast<std::streamsize>(bytes.size())); });
}

Recording read_recording_bytes(std::string_view bytes, const std::string& name) {
  const std::vector<FileSection> sections =
      read_sections(name, bytes, recording_kind, {head_tag, start_tag, scene_tag, inputs_tag});
  Recording recording;
  const auto reader = [&](std::size_t k) { return ByteReader(name, sections[k].payload, sections[k].first_byte); };
  ByteReader head = reader(0), start = reader(1), inputs = reader(3);
  head_fields(head, recording);
  if (head.remaining() > 0) head.field(recording.options.max_substeps, substeps_field);
  const RecordedOptions& options = recording.options;
  if (!(options == options)) {
    head.fail("expected numbers as options before this byte, got NaN; the file was written by something else");
  }
  head.expect_end("section \"head\"");
  recording.start = take_snapshot(start);
  recording.start.topology_hash = recording.topology_hash;
  recording.start.backend = recording.backend;
  start.expect_end("section \"stat\"");
  recording.scene = sections[2].payload;
  recording.inputs = take_inputs(inputs);
  return recording;
}

Recording read_recording(const std::string& path) {
  return read_recording_bytes(read_whole_file(path, std::numeric_limits<std::size_t>::max()), path);
}

}  // namespace phymul
