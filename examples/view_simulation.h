// SPDX-License-Identifier: MIT
//
// The body that phymul-view moves: its solver, which can be changed for another, and its display.
#pragma once

#include <phymul/display.h>
#include <phymul/scene.h>
#include <phymul/skin.h>
#include <phymul/solver.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "view_options.h"

/// Needs the window's context current at every call: GL backends run in it, and leave the particles where they are
/// drawn from.
class Simulation {
 public:
  Simulation(const ViewBody& body, const ViewOptions& options);

  phymul::Scene& scene() { return scene_; }
  const phymul::Model& model() const { return model_; }
  const phymul::Solver& solver() const { return *solver_; }
  phymul::Display& display() { return *display_; }
  double time() const { return time_; }  ///< s, simulated

  /// As many steps as make up a frame's time; fewer where the frame before, of `wall_time` s, came late and `keep_up`
  /// is asked for.
  void advance(double wall_time, bool keep_up);
  void step(int n);
  void reset();
  void next_backend();
  bool shows_skin() const { return skin_ && shows_skin_; }
  void change_skin();  ///< shows the surface that the body fills, or the body itself

  std::string status() const;  ///< backend, device, rate
  /// Why it stands still, if a step failed; empty otherwise.
  const std::string& failure() const { return failure_; }

 private:
  void use(const std::string& backend);
  void show();

  const ViewBody& body_;
  const phymul::Model& model_;
  const ViewOptions& options_;
  phymul::Scene scene_;
  std::optional<phymul::Spectrum> spectrum_;
  std::shared_ptr<const phymul::TopologyTextures> topology_;
  std::unique_ptr<phymul::Solver> solver_;
  std::unique_ptr<phymul::Display> display_;
  std::optional<phymul::Skin> skin_;
  bool shows_skin_ = true;
  std::string failure_;
  double time_ = 0.0;
  double dt_ = 0.0;
  int steps_a_frame_ = 1;
  double rate_ = 0.0;  // steps a second, smoothed
};
