// SPDX-License-Identifier: MIT
//
// Steps a body through the dates of its loads to rest, and writes what there is to see on the way.
#pragma once

#include <phymul/writer.h>

#include <fstream>
#include <optional>

#include "run_options.h"
#include "run_report.h"
#include "run_schedule.h"
#include "scene_picture.h"

class RunLoop {
 public:
  /// The output folder must exist.
  RunLoop(const RunOptions& options, const RunSchedule& schedule, phymul::Simulation& sim, Progress& progress);

  /// Returns the program's exit code. Throws phymul::Error where a file cannot be written.
  int run();

  const RunSummary& summary() const { return summary_; }
  const phymul::State& state() const { return state_; }

 private:
  void choose_step();
  bool reached(double date) const { return state_.time >= date - 0.5 * summary_.dt; }
  bool is_settling() const;  ///< nothing will change any more but by the body's own motion
  double next_date() const;
  bool advance(double date);
  void look();  ///< reads the state, and does what this date asks for
  void remember_pull();
  Snapshot snapshot(std::string label) const;
  int finish(bool failed, bool at_rest);
  void draw(const std::string& file, const std::string& title, const phymul::State& state, bool is_let_go);

  const RunOptions& options_;
  const RunSchedule& schedule_;
  phymul::Simulation& sim_;
  phymul::Solver& solver_;
  const phymul::Model& model_;

  double sample_interval_ = 0.0;  ///< s, between rows of energies.csv; ten of them make a frame
  double settle_date_ = 0.0;      ///< s, from then on nothing is done to the body any more
  double end_ = 0.0;              ///< s
  double first_cut_area_ = 0.0;   ///< m^2
  double full_scale_ = 0.0;       ///< m, of the pictures' colours: one for all once the largest pull is known
  std::optional<double> pull_date_, let_go_date_;
  bool pull_seen_ = false;
  bool let_go_done_ = false;
  std::int64_t samples_ = 0, frames_ = 0;  ///< dates that were reached
  std::int64_t settling_from_ = -1;        ///< step

  phymul::State state_;
  phymul::StepReport report_;
  phymul::Index loose_ = -1;  // RestResult::loose
  std::optional<phymul::State> pulled_;
  Snapshot pulled_shot_;
  std::optional<phymul::VtkSeries> series_;
  std::ofstream energies_;
  std::optional<ScenePictures> pictures_;
  Progress& progress_;
  RunSummary summary_;
};
