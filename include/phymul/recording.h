// SPDX-License-Identifier: MIT
//
// Recorder and Replay: record what an application does with a solver, and repeat it. On the backends "reference" and
// "cpu" the result is the same to the last bit, for any number of threads; on "cpu" only with the same vector width.
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

/// One action of the application: a kind of four printable ASCII characters, and bytes whose meaning depends on it.
struct Input {
  std::string kind;
  std::string bytes;
  std::uint64_t times = 1;  ///< number of consecutive repetitions
  bool operator==(const Input&) const = default;
};

/// Options of a solver, in addition to tables and scene, that determine its trajectory. Units: SolverOptions.
struct RecordedOptions {
  double damping_rate = 0.0, damping_factor = 1.0, max_displacement_per_step = 0.0, rest_tolerance = 0.0,
         sleep_tolerance = -1.0, stable_step = 0.0;  ///< sleep_tolerance: -1 for none
  int rest_steps = 0, max_substeps = 1;
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

/// A file with magic word, version and checksums (docs/guide/formats.md), written as a whole or not at all. Reading
/// throws Error for a damaged file, with file (or `name`), byte, expected and found value, and a remedy.
void save_recording(const Recording& recording, const std::string& path);
Recording read_recording(const std::string& path);
Recording read_recording_bytes(std::string_view bytes, const std::string& name);

/// Forwards calls to a solver and records them. The application may change the scene; the next call records the
/// differences. Calls made directly to the solver are not recorded. Keeps references to solver and scene, which must
/// outlive it. Memory grows with the number of inputs; consecutive equal steps are one input.
class Recorder {
 public:
  /// Throws Error if the scene is of another model. Discards calls of tool handles made since the last step: repeat
  /// them afterwards.
  Recorder(Solver& solver, const Scene& scene);
  ~Recorder();

  StepReport step(int n, double dt);
  RestResult run_to_rest(int max_steps, double dt);
  RestResult run_to_rest(int max_steps, double dt, const Damping& damping);
  void reset();
  void reset(const State& state);
  void restore(const Snapshot& snapshot);

  /// Records which cuts the body has and which of its cells are the removed ones from now on, after
  /// Solver::body_changed().
  void body_changed();

  /// Records an input of the application, which Replay passes to Replay::on_note. Throws Error unless `kind` has four
  /// printable ASCII characters and is not a kind of the library.
  void note(std::string_view kind, std::string bytes);
  /// Records a hash of the state. Replay throws Error if its own state there has another hash.
  void checkpoint();

  const Recording& recording() const { return recording_; }

 private:
  friend class Simulation;  // adds what waits for its cut
  void record(std::string_view kind, std::string bytes);
  void record_scene();
  void keep_scene();
  void keep_body();
  void record_tool(const SceneTool& tool);
  void record_threads(bool before_scene);
  void see_threads();

  Solver& solver_;
  const Scene& scene_;
  Recording recording_;
  std::uint64_t scene_version_ = 0;
  std::unique_ptr<SceneBefore> before_;  // the scene as recorded
  BodyCuts cuts_;                        // the body as recorded
  std::vector<Index> removed_;
  struct SeenTool {
    std::uint64_t moves = 0, places = 0, grasps = 0;
  };
  std::map<std::uint64_t, SeenTool> seen_tools_;  // by SceneTool::id
  struct SeenThread {
    std::string name;
    std::uint64_t changes = 0;
  };
  std::map<std::uint64_t, SeenThread> seen_threads_;  // by SceneThread::id
};

/// Repeats a recording. Keeps references to solver and scene, which must outlive it. Nothing else may change them.
class Replay {
 public:
  /// Restores the recorded start in the solver and the scene. Throws Error if the recording is of another topology or
  /// other options, or the scene of another model. Another backend is allowed and gives results of another precision.
  Replay(Recording recording, Solver& solver, Scene& scene);

  /// Repeats the next input, once. Returns false at the end. Throws Error, with the input's number, if an input does
  /// not fit the scene or solver, or a checkpoint differs.
  bool next();
  void run();  ///< repeats all inputs that are left; throws as next()

  /// Of the last input that was a call of step() or run_to_rest().
  const StepReport& report() const { return report_; }
  /// Number of inputs done, repetitions counted; skip_to(position()) of another Replay leads to the same place.
  std::uint64_t position() const { return position_; }
  /// Continues from there without stepping: makes the changes of the scene, leaves the solver's state and skips notes
  /// and checkpoints. The caller then loads a state saved there (load_state). A position before the present one is
  /// allowed. Throws Error for a position after the end.
  void skip_to(std::uint64_t position);

  /// Makes these rows of Model::cells, and no others, the removed ones, and these the cuts of the body (Simulation does
  /// so). Empty: a recording that changes the body throws Error.
  std::function<void(const std::vector<Index>& removed, const BodyCuts& cuts)> on_body;
  std::function<void(const Input&)> on_note;  ///< receives the application's own inputs; empty: they are skipped

 private:
  void perform(const Input& input);
  void move_tool(const Input& input);
  void change_thread(const Input& input);
  void follow_checkpoint(const Input& input) const;
  void start_scene();
  void make_body(const std::vector<Index>& removed, const BodyCuts& cuts);
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
