// SPDX-License-Identifier: MIT
//
// What phymul-run says: a line of progress while it works, a table when it is done.
#pragma once

#include <phymul/monitor.h>
#include <phymul/solver.h>

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "run_schedule.h"

/// Figures of one moment of a run.
struct Snapshot {
  std::string label;
  double time = 0.0;  ///< s
  phymul::Energy energy;
  double residual = 0.0;          ///< N
  double max_speed = 0.0;         ///< m/s
  double linear_momentum = 0.0;   ///< kg m/s
  double angular_momentum = 0.0;  ///< kg m^2/s, about the centre of mass
  double volume_ratio = 0.0;      ///< to the rest volume; 0 where the body has none
  phymul::DisplacementNorms displacement;
  double driven = 0.0;  ///< largest displacement of a driven particle, m
};

Snapshot take_snapshot(std::string label, const phymul::Solver& solver, const phymul::State& state,
                       const phymul::StepReport& report, const std::vector<phymul::Index>& driven);

struct RunSummary {
  std::string status;   ///< how it ended
  std::string failure;  ///< what the solver said of its failure; empty: none
  bool at_rest = false;
  std::int64_t steps = 0;
  std::int64_t steps_to_rest = -1;  ///< after the last date of the loads; -1: not at rest
  double dt = 0.0;                  ///< s
  double wall_time = 0.0;           ///< s, stepping only
  std::int64_t torn = 0;            ///< cells; with --tear also the next three
  bool could_not_tear = false;
  double torn_area = 0.0;  ///< m^2 at rest
  std::size_t pieces = 0;
  std::vector<Snapshot> snapshots;
  std::optional<Snapshot> pulled;  ///< the one at the largest pull
  std::optional<Snapshot> let_go;  ///< the one just before
};

/// What is said on the way, on the standard error: one line, overwritten in place, where that is a terminal; else a
/// line every three seconds.
class Progress {
 public:
  explicit Progress(bool quiet);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// Prints when it is time to.
  void show(double time, const phymul::Energy& energy, const phymul::StepReport& report, double steps_per_second);
  /// Within a call of the solver that takes long.
  void show(const phymul::StepProgress& progress);
  /// Of a plan: a body of this spacing, m, is tried.
  void show_trial(double spacing, int particles);
  void say(const std::string& sentence);  ///< prints now, on a line of its own, terminal or not

 private:
  bool is_due();
  void print(const char* line);

  bool quiet_, terminal_;
  bool line_open_ = false;
  std::chrono::milliseconds interval_;
  std::chrono::steady_clock::time_point next_;
};

/// Where the time of the steps went.
void print_profile(const std::vector<phymul::PassProfile>& passes, const RunSummary& summary);

void print_table(const phymul::Solver& solver, const RunSummary& summary);

/// What was done to the body, and what it did, in a few sentences.
void print_story(const phymul::Scene& scene, const RunSchedule& schedule, const RunSummary& summary);
