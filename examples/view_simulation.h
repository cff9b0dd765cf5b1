// SPDX-License-Identifier: MIT
//
// The body that phymul-view moves: its simulation, which can go on in another backend, and its display.
#pragma once

#include <phymul/display.h>
#include <phymul/simulation.h>
#include <phymul/skin.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "view_options.h"

/// Needs the window's context current at every call: GL backends run in it, and leave the particles where they are
/// drawn from.
class ViewSimulation {
 public:
  ViewSimulation(const FileBody& body, const ViewOptions& options);

  /// Another one after next_backend(), at the same address: its scene is new, and has nothing that was added meanwhile.
  phymul::Simulation& sim() { return sim_; }
  const phymul::Model& model() const { return body_.model; }  ///< as it was read
  phymul::Display& display();                                 ///< of the body as it is now

  /// As many steps as make up a frame's time; fewer where the frame before, of `wall_time` s, came late and `keep_up`
  /// is asked for.
  void advance(double wall_time, bool keep_up);
  void step(int n);
  void reset();
  void next_backend();
  bool shows_skin() const { return shows_skin_ && (skin_ || is_cut()); }
  void change_skin();  ///< shows the surface that the body fills or that cuts have left, or the body itself

  bool can_be_cut() const { return can_be_cut_; }
  void begin_cut();  ///< undo_cut() goes back to here
  void undo_cut();

  std::string status() const;  ///< backend, device, rate, pieces
  /// Why it stands still, if a step failed; empty otherwise.
  const std::string& failure() const { return failure_; }

 private:
  phymul::Simulation make(const std::string& backend) const;
  bool is_cut() const { return !sim_.cuts().empty() || ::is_cut(sim_.model()); }
  phymul::Snapshot snapshot() const;
  void go_back(const phymul::Snapshot& snapshot);
  void show();

  const FileBody& body_;
  const ViewOptions& options_;
  const bool can_be_cut_;
  phymul::Simulation sim_;
  phymul::Snapshot beginning_;
  std::vector<phymul::Snapshot> before_cuts_;
  std::optional<phymul::Skin> skin_;
  bool shows_skin_ = true;
  std::unique_ptr<phymul::Display> display_;
  std::uint64_t shown_version_ = 0;  // Scene::body_version()
  std::size_t pieces_ = 1;
  bool some_uncut_ = false;  // cut three times already, or the spare particles do not suffice
  std::string failure_;
  int steps_a_frame_ = 1;
  double rate_ = 0.0;  // steps a second, smoothed
};
