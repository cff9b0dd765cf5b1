// SPDX-License-Identifier: MIT
//
// What a Simulation keeps on the heap, where scene and solver can point to it.
#pragma once

#include <phymul/simulation.h>

#include <chrono>
#include <map>
#include <optional>

#include "elastic/scaled_tables.h"
#include "statics/rest_search.h"
#include "statics/rest_tools.h"
#include "tears.h"
#include "topology/body_edit.h"

namespace phymul {

struct Simulation::Parts {
  Parts(Model model_in, SimulationOptions options_in);

  Solver& solver();  ///< made by the first call
  double step_limit(double seconds = 0.0);
  /// Of a call of so many seconds that may have `steps` by this limit, s: more where the last one had.
  double held_steps(double seconds, double limit, double steps);
  const TopologyTextures& elastic() { return scaled.of(*topology, scene.stiffness_factors()); }

  /// To be called before steps of dt: converts the velocities of a state that was set for just these steps.
  void begin(double dt);
  /// Starts from a state whose velocities are those of its own time.
  void start(const State& state);
  /// Starts from a state in which all forces are balanced, those of tools and joints (by Scene::tools() and joints())
  /// too, and velocities are 0.
  void start_at_rest(const State& state, const std::vector<ToolForce>& of_tools,
                     const std::vector<JointReport>& of_joints);
  /// Whether no step was taken since start() before this present state, and the solver was given no other one.
  bool is_at_start(const Snapshot& now) const;
  Snapshot snapshot();                      ///< with Snapshot::start
  void begin_again(const Snapshot& there);  ///< after the solver was given it
  void follow_history(const StepReport& report);
  /// Gives the scene the tools, joints and target poses of a snapshot, unless it is of another body.
  void bring_back(const Snapshot& snapshot);
  /// After a state or recording was refused: everything as it was. `asked`: Scene::tools() as they were.
  void take_back(const Snapshot& before, const std::vector<SceneTool>& asked);
  BodyEdit& body_edit();  ///< made by the first call
  /// `removed`: ascending. Where the solver refuses it, the body stays as it was.
  void set_body(const std::vector<Index>& removed, const BodyCuts& cuts);
  void change_body(const std::vector<Index>& removed, const BodyCuts& cuts);
  void state_changed();       ///< by something that the recorder does not see
  void begin_history_anew();  ///< at the present state

  StepReport step(int n, double dt);
  bool divide(StepReport& report);  ///< cuts and tears after the steps of a call; whether the body changed, or is to
  void cut_with_blades(StepReport& report);
  void cut_waiting(StepReport& report);
  void follow_waiting(const BodyCuts& before);  ///< to the cuts that the body has now
  void tear(StepReport& report);
  /// One of those cuts, of so many cells. The solver may refuse it.
  void make_cut(BodyCut cut, std::size_t cells, StepReport& report);
  bool keeps_body();  ///< whether the solver refuses all cuts, as far as is known
  RestResult run_to_rest(int max_steps, double dt, const Damping& damping);
  RestResult run_to_rest(int max_steps, double dt);  ///< with a damping that it chooses

  SimulationOptions options;
  Model model;
  Scene scene;
  std::shared_ptr<TopologyTextures> topology;
  std::unique_ptr<BodyEdit> edit;  ///< of model and topology, by body_edit()
  struct SeenBlade {
    ToolPose pose{};
    std::uint64_t places = 0;  ///< SceneTool
  };
  std::map<std::uint64_t, SeenBlade> blades_seen;  ///< by SceneTool::id, after the last call
  std::vector<Snapshot::CutLater> waiting;         ///< cells for their cuts, in order
  struct SeenTool {
    std::uint64_t moves = 0, places = 0, grasps = 0;  ///< SceneTool
  };
  std::map<std::uint64_t, SeenTool> tools_seen;  ///< by SceneTool::id: what the solver's last step did
  void see_tools();
  void ask_tools_again(std::vector<SceneTool> asked, const std::map<std::uint64_t, SeenTool>& seen);
  void took_steps(const StepReport& report);
  double last_dt = 0.0;                  ///< s, of the last step; 0: none
  std::optional<double> growth_at_rest;  ///< frequency_growth(), by held_steps(): of the materials alone
  bool refused_cut = false;              ///< make_cut()
  Tears tears;
  std::uint64_t tears_version = 0;  ///< Scene::body_version() and one that they are of
  ScaledTables scaled;

  /// Of solve_static(), as long as body and held coordinates stay.
  struct AtRest {
    std::uint64_t body_version = 0;  ///< Scene
    std::vector<double> factors;     ///< of stiffness
    std::vector<std::uint8_t> fixed;
    std::vector<ConnectedBody> loose;
    std::unique_ptr<RestBody> body;    ///< none for walls
    std::unique_ptr<RestTools> tools;  ///< of the last search
    VecList end;                       ///< m, that it found
  };
  AtRest at_rest;
  void follow_at_rest(const LoadFrame& loads);

  struct Start {
    State wanted, taken;  ///< as given; as the solver has it
    double dt = 0.0;      ///< s, that its velocities were converted for
  };
  std::optional<Start> started;
  std::optional<StateHistory> history;
  int history_every = 1;  ///< steps

  /// SolverOptions::progress of the user, for calls that are made of several calls of the solver.
  struct Progress {
    std::function<bool(const StepProgress&)> tell;
    double seconds = 0.0;
    int steps_before = 0, of = 0;  ///< of the whole call; of 0: the solver's own call is the whole
    std::chrono::steady_clock::time_point told;

    bool pass_on(StepProgress part);
    bool is_due() const;
  } progress;

  std::unique_ptr<Solver> made;       ///< ask solver() for it
  std::vector<std::string> warnings;  ///< of when it was made, and of cuts since
  std::optional<Recorder> recorder;   ///< refers to it
};

}  // namespace phymul
