// SPDX-License-Identifier: MIT
//
// What a host did with a solver between its steps, recorded, and done again: on the backends "reference" and "cpu" the
// same bits come out, whatever the number of threads.
#pragma once

#include <phymul/state_file.h>

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace phymul {

struct SceneBefore;  // src/session/scene_bytes.h

/// One thing that a host did: a kind of four letters, and bytes that the kind gives a meaning.
struct Input {
  std::string kind;
  std::string bytes;
  std::uint64_t times = 1;  ///< on end
  bool operator==(const Input&) const = default;
};

/// Figures of a solver on which its trajectory depends besides tables and scene.
struct RecordedOptions {
  double damping_rate = 0.0, damping_factor = 1.0, max_displacement_per_step = 0.0, rest_tolerance = 0.0,
         stable_step = 0.0;
  int rest_steps = 0;
  bool allows_unstable = false;
  bool operator==(const RecordedOptions&) const = default;
};
RecordedOptions recorded_options(const Solver& solver);

struct Recording {
  std::uint64_t topology_hash = 0;  ///< Solver::topology_hash()
  std::string backend;              ///< Solver::name()
  std::string device;               ///< Solver::device(), for people
  RecordedOptions options;
  Snapshot start;
  std::string scene;  ///< at the start, in bytes (src/session/scene_bytes.h)
  std::vector<Input> inputs;
  bool operator==(const Recording&) const = default;
};

/// A file with magic word, version and checksums (docs/formats.md), written whole or not at all. Reading throws Error
/// for a damaged file: file, byte, what was expected, what came, what to do.
void save_recording(const Recording& recording, const std::string& path);
Recording read_recording(const std::string& path);
Recording read_recording_bytes(std::string_view bytes, const std::string& name);

/// Stands between the host and a solver: hands on what it is asked for, and writes it down. The host may change the
/// scene as it likes; what differs is written down at the next step. Keeps references to both, which must outlive it;
/// what the host does with the solver past the recorder is not recorded. Memory grows with what is done: equal steps on
/// end are one input.
class Recorder {
 public:
  /// Throws Error where the scene is that of another model. Poses and grasps of tools that no step has seen yet are
  /// forgotten: ask for them again.
  Recorder(Solver& solver, const Scene& scene);
  ~Recorder();

  StepReport step(int n, double dt);
  RestResult run_to_rest(int max_steps, double dt);
  void reset();
  void reset(const State& state);
  void restore(const Snapshot& snapshot);

  /// An input of the host's own, handed back by Replay::on_note in its place. Throws Error unless `kind` has four
  /// letters and is not one of the library's.
  void note(std::string_view kind, std::string bytes);
  /// Writes the state's fingerprint down; a replay that comes to another one says so.
  void checkpoint();

  const Recording& recording() const { return recording_; }

 private:
  void record(std::string_view kind, std::string bytes);
  void record_scene();
  void keep_scene();
  void record_tool(const SceneTool& tool);

  Solver& solver_;
  const Scene& scene_;
  Recording recording_;
  std::uint64_t scene_version_ = 0;
  std::unique_ptr<SceneBefore> before_;  // the scene as recorded
  struct SeenTool {
    std::uint64_t moves = 0, places = 0, grasps = 0;
  };
  std::map<std::uint64_t, SeenTool> seen_tools_;  // by SceneTool::id
};

/// Does it all again. Keeps references to solver and scene, which must outlive it; nobody else may change them.
class Replay {
 public:
  /// Puts the solver to the start, and clears the scene. Throws Error where the recording is of another body, of other
  /// options (which, and both values), or the scene of another model. Another backend is allowed, and gives another
  /// precision.
  Replay(Recording recording, Solver& solver, Scene& scene);

  /// Does the next input, once. False, and nothing done, at the end. Throws Error, with the input's number, where an
  /// input makes no sense to the scene or solver, or a checkpoint is missed.
  bool next();
  void run();  ///< all that is left

  /// Of the last input that stepped.
  const StepReport& report() const { return report_; }
  /// Number of inputs done, repetitions counted; skip_to(position()) of another Replay leads to the same place.
  std::uint64_t position() const { return position_; }
  /// Goes on from there without stepping: changes of the scene are made, the state is left alone. The caller then puts
  /// the solver to a state saved there (load_state). Backwards: the scene is cleared and made anew.
  void skip_to(std::uint64_t position);

  std::function<void(const Input&)> on_note;  ///< gets the host's own inputs; empty: they are passed over

 private:
  void perform(const Input& input);
  void move_tool(const Input& input);
  void follow_checkpoint(const Input& input) const;
  void start_scene();
  void advance();  // position_ by one

  Recording recording_;
  Solver& solver_;
  Scene& scene_;
  StepReport report_;
  std::size_t row_ = 0;     // of the next input
  std::uint64_t done_ = 0;  // times that input was done
  std::uint64_t position_ = 0;
};

}  // namespace phymul
