// SPDX-License-Identifier: MIT
#include <phymul/error.h>
#include <phymul/recording.h>

#include <algorithm>
#include <bit>

#include "base/decimal.h"
#include "base/files.h"
#include "scene_bytes.h"
#include "wire_codes.h"

namespace phymul {
namespace {

bool same_bits(double a, double b) {
  return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b);
}

void require_same(const char* what, double recorded, double own) {
  if (same_bits(recorded, own)) return;
  throw Error(std::string("Replay: expected a solver with ") + what + " " + to_decimal(recorded) +
              ", as the recording's, got " + to_decimal(own));
}

void require_same_options(const RecordedOptions& recorded, const RecordedOptions& own) {
  require_same("damping.rate", recorded.damping_rate, own.damping_rate);
  require_same("damping.factor", recorded.damping_factor, own.damping_factor);
  require_same("max_displacement_per_step", recorded.max_displacement_per_step, own.max_displacement_per_step);
  require_same("rest_tolerance", recorded.rest_tolerance, own.rest_tolerance);
  require_same("sleep_tolerance", recorded.sleep_tolerance, own.sleep_tolerance);
  require_same("rest_steps", recorded.rest_steps, own.rest_steps);
  require_same("max_substeps", recorded.max_substeps, own.max_substeps);
  require_same("on_unstable (1: allow)", recorded.allows_unstable, own.allows_unstable);
}

ByteReader reader(const Input& input) {
  return {"input \"" + input.kind + '"', input.bytes};
}

struct StepInput {
  int n;
  double dt;
};

StepInput take_step(const Input& input) {
  ByteReader in = reader(input);
  const StepInput step{in.index("a number of steps"), in.real("a step")};
  in.expect_end("the input");
  return step;
}

}  // namespace

Replay::Replay(Recording recording, Solver& solver, Scene& scene)
    : recording_(std::move(recording)), solver_(solver), scene_(scene) {
  if (&scene.model() != &solver.model()) throw Error("Replay: the scene was made for another model");
  if (solver.topology_hash() != recording_.topology_hash) {
    throw Error(
        "Replay: the recording is of another body: other shape, material, order of particles or options of the "
        "tables; build the one that was recorded");
  }
  require_same_options(recording_.options, recorded_options(solver));
  start_scene();  // on whose joints the step limit depends
  require_same("stable_step()", recording_.options.stable_step, recorded_options(solver).stable_step);
  try {
    solver_.restore(recording_.start);
  } catch (const Error& error) {
    throw with_prefix("Replay: the start: ", error);
  }
}

void Replay::start_scene() {
  // The recorded body may have been edited before: a scene takes pressures that have no facets any more after an edit.
  scene_.body_changed(solver_.topology().cuts);
  try {
    ByteReader in("scene", recording_.scene);
    change_scene(scene_, in);
  } catch (const Error& error) {
    throw with_prefix("Replay: the scene at the start: ", error);
  }
}

void Replay::follow_checkpoint(const Input& input) const {
  ByteReader in = reader(input);
  const std::uint64_t recorded = in.u64("a fingerprint");
  const double time = in.real("a time");
  in.expect_end("the input");
  const Snapshot now = solver_.snapshot();
  if (fingerprint(now) == recorded) return;
  throw Error("expected the recorded state at t = " + to_decimal(time) +
              " s, got another one at t = " + to_decimal(now.state.time) + " s; it was recorded on " +
              recording_.backend + " (" + recording_.device + "), this is " + std::string(solver_.name()) + " (" +
              solver_.device() + "): another backend or vector width gives other last bits");
}

void Replay::make_body(const std::vector<Index>& removed, const BodyCuts& cuts) {
  const TopologyTextures& body = solver_.topology();
  if (removed == body.removed && equal_cuts(cuts, body.cuts)) return;
  if (!on_body) {
    throw Error(
        "the recording cuts the body, or removes cells of it; replay it with Simulation::replay, or set "
        "Replay::on_body");
  }
  on_body(removed, cuts);
}

void Replay::move_tool(const Input& input) {
  ByteReader in = reader(input);
  const ToolHandle tool = scene_.tool(in.text("a tool's name"));
  const bool set = in.u8("whether it is placed, or grasps") != 0;
  if (input.kind == input_kind::pose) {
    ToolPose pose;
    pose_fields(in, pose);
    set ? tool.teleport(pose) : tool.move_to(pose);
  } else {
    const double distance = in.real("a distance to grasp within");
    set ? tool.grasp(distance) : tool.release();
  }
  in.expect_end("the input");
}

void Replay::change_thread(const Input& input) {
  ByteReader in = reader(input);
  const std::string name = in.text("a thread's name");
  const auto change = static_cast<input_kind::ThreadChange>(in.u8("what changed of a thread"));
  if (change == input_kind::ThreadChange::adds) {
    add_threads(in, scene_);
  } else if (change == input_kind::ThreadChange::removes) {
    scene_.remove_thread(name);
  } else {
    change_control(in, scene_.thread(name));
  }
  in.expect_end("the input");
}

void Replay::perform(const Input& input) {
  if (input.kind == input_kind::step) {
    const StepInput step = take_step(input);
    report_ = solver_.step(step.n, step.dt);
  } else if (input.kind == input_kind::to_rest || input.kind == input_kind::to_rest_damped) {
    ByteReader in = reader(input);
    const int steps = in.index("a number of steps");
    const double dt = in.real("a step");
    Damping damping = solver_.options().damping;
    if (input.kind == input_kind::to_rest_damped) damping = {in.real("a damping rate"), in.real("a damping factor")};
    in.expect_end("the input");
    report_ = solver_.run_to_rest(steps, dt, damping).report;
  } else if (input.kind == input_kind::restore) {
    ByteReader in = reader(input);
    const Snapshot snapshot = take_snapshot(in);
    in.expect_end("the input");
    make_body(snapshot.removed_cells, snapshot.cuts);
    solver_.restore(snapshot);
  } else if (input.kind == input_kind::scene) {
    ByteReader in = reader(input);
    change_scene(scene_, in);
  } else if (input.kind == input_kind::removed) {
    ByteReader in = reader(input);
    const std::vector<Index> cells = take_removed_cells(in);
    in.expect_end("the input");
    make_body(cells, solver_.topology().cuts);
  } else if (input.kind == input_kind::cut) {
    ByteReader in = reader(input);
    const std::uint64_t stays = in.u64("a number of cuts that stay");
    BodyCuts cuts = solver_.topology().cuts, further;
    cuts_field(in, further);
    in.expect_end("the input");
    if (stays > cuts.size()) {
      throw Error("expected at most " + std::to_string(cuts.size()) + " cuts that stay, got " + std::to_string(stays));
    }
    cuts.resize(stays);
    cuts.insert(cuts.end(), further.begin(), further.end());
    make_body(solver_.topology().removed, cuts);
  } else if (input.kind == input_kind::pose || input.kind == input_kind::grasp) {
    move_tool(input);
  } else if (input.kind == input_kind::thread) {
    change_thread(input);
  } else if (input.kind == input_kind::checkpoint) {
    follow_checkpoint(input);
  } else if (on_note && input.kind != input_kind::later) {
    on_note(input);
  }
}

void Replay::advance() {
  ++position_;
  if (++done_ >= recording_.inputs[row_].times) {
    ++row_;
    done_ = 0;
  }
}

bool Replay::next() {
  if (row_ >= recording_.inputs.size()) return false;
  try {
    perform(recording_.inputs[row_]);
  } catch (const Error& error) {
    throw with_prefix("Replay: input " + std::to_string(position_) + ": ", error);
  }
  advance();
  return true;
}

void Replay::run() {
  while (next()) {
  }
}

void Replay::skip_to(std::uint64_t position) {
  if (position < position_) {
    make_body(recording_.start.removed_cells, recording_.start.cuts);
    start_scene();
    row_ = 0;
    done_ = position_ = 0;
  }
  while (position_ < position) {
    if (row_ >= recording_.inputs.size()) {
      throw Error("Replay: expected a position of " + std::to_string(position_) + " or less, got " +
                  std::to_string(position));
    }
    const Input& input = recording_.inputs[row_];
    const bool of_scene = input.kind == input_kind::scene || input.kind == input_kind::removed ||
                          input.kind == input_kind::cut || input.kind == input_kind::pose ||
                          input.kind == input_kind::grasp || input.kind == input_kind::thread;
    if (input.kind == input_kind::restore) {
      ByteReader in = reader(input);
      const Snapshot snapshot = take_snapshot(in);
      make_body(snapshot.removed_cells, snapshot.cuts);
    }
    if (of_scene) {
      perform(input);
      advance();
    } else {
      const std::uint64_t some = std::min(position - position_, input.times - done_);
      position_ += some - 1;
      done_ += some - 1;
      advance();
    }
  }
}

}  // namespace phymul
