// SPDX-License-Identifier: MIT
//
// What a Simulation keeps on the heap, where scene and solver can point to it.
#pragma once

#include <phymul/scene.h>
#include <phymul/simulation.h>
#include <phymul/state.h>
#include <phymul/topology_textures.h>

#include <array>
#include <chrono>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "elastic/scaled_tables.h"
#include "model/outer_faces.h"
#include "statics/rest_body.h"
#include "statics/rest_tools.h"
#include "topology/body_edit.h"

namespace phymul {

/// Where a body may tear, and the cut by which it does (phymul/tearing.h).
class Tears {
 public:
  /// The body as it is; model, edit and scene must outlive the next find().
  void follow(const Model& model, const TopologyTextures& topology, const BodyEdit& edit, const Scene& scene);

  bool has_fronts() const { return !fronts_.empty(); }
  bool is_by(const std::vector<Tearing>& laws) const { return laws_ == laws; }  ///< follow() saw these

  /// What tears now, at most one row of cells along each front. `elastic`: tables of the forces that `now` has.
  struct Found {
    std::vector<Index> cells{};                    ///< rows, ascending
    std::unordered_map<Index, double> distance{};  ///< m, of their particles from the new surface
  };
  Found find(const TopologyTextures& elastic, const State& now);

 private:
  /// A face of a cell that is whole, behind which the cells are cut: a piece of the front.
  struct Front {
    Index cell = -1;
    std::array<Index, 3> face{};    // particles
    std::array<double, 3> value{};  // m, theirs of the cut behind it
    Vec3 normal{0, 0, 0};           // of the cut, at rest
    Vec3 place{0, 0, 0};            // m at rest, the middle of the cut's edge
    std::vector<Index> around{};    // domains over which the stress is averaged
  };
  struct Pull {
    Vec3 direction{0, 0, 0};  // at rest, of the largest principal stress
    double excess = 0.0;      // that over what the material bears; more than 1: it tears
  };

  void look_behind(Index row);
  const Mat3& stress_of(Index d, const TopologyTextures& elastic, const State& now);
  Pull pull_at(const TopologyTextures& elastic, const State& now, const Vec3& place, Index cell, double radius,
               std::span<const Index> around);
  std::optional<double> known_distance(Index particle, double own, const Vec3& normal) const;
  void find_surface();
  void begin_near_grasps(const TopologyTextures& elastic, const State& now, Found& found);
  bool can_tear(Index cell) const;     // whether it is there and its material tears
  double radius_at(Index cell) const;  // m, of means
  double radius_of(const Tearing& law) const;

  const Model* model_ = nullptr;
  const BodyEdit* edit_ = nullptr;
  const Scene* scene_ = nullptr;
  std::vector<Tearing> laws_;  // Scene::tearing()
  double widest_ = 0.0;        // m, radius_of() any of these
  std::vector<Front> fronts_;
  OuterFaces outer_;
  bool surface_known_ = false;
  std::vector<Index> surface_;                 // particles of outer faces
  std::vector<std::pair<bool, Mat3>> stress_;  // [D] whether it is known, of the state at hand
  std::vector<Index> stressed_;                // of which it is
};

/// What a user has probably not meant, a sentence each: no material, quantities in other units than SI, parts that
/// nothing holds. `takes_material`: the law of the body can use one.
std::vector<std::string> warnings_of(const Model& model, const Scene& scene, bool takes_material);

/// Adds a sentence if a tool touches a body with cuts at its particles; adds it only once.
void look_for_tools_beyond_cuts(const Model& model, const Scene& scene, std::vector<std::string>& found);

/// Adds a sentence if bodies that can touch each other overlap at rest: the deepest pair, and by how much.
void look_for_overlaps(const Model& model, const Scene& scene, std::vector<std::string>& found);

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
