// SPDX-License-Identifier: MIT
#pragma once

#include <phymul/display.h>

#include <string>

#include "view_drag.h"
#include "view_scalpel.h"

class ViewSimulation;
class ViewWindow;

/// What keys and mouse do: to the view, to the layers, to the body.
class ViewInput {
 public:
  ViewInput(ViewSimulation& simulation, ViewWindow& window);

  // From the window; places in points from its upper left corner, buttons and keys as GLFW numbers them.
  void key(int key);
  void button(int button, bool pressed);
  void cursor(double x, double y);
  void wheel(double notches);

  void advance(double wall_time, bool keep_up);  ///< one frame, unless paused; see ViewSimulation::advance

  const phymul::Camera& camera() const { return camera_; }
  const phymul::DisplayOptions& layers() const { return layers_; }
  std::string title() const;

 private:
  void look_at_body();
  void orbit(double across, double upward);
  void shift(double across, double upward);
  void layer_key(int key);
  void mark_dragged();
  void let_go();

  ViewSimulation& simulation_;
  ViewWindow& window_;
  phymul::Camera camera_;
  phymul::DisplayOptions layers_;
  ParticleDrag drag_;
  Scalpel scalpel_;
  double full_scale_ = 0.0;   // m
  double x_ = 0.0, y_ = 0.0;  // of the mouse, points
  bool turning_ = false, shifting_ = false, cutting_ = false, paused_ = false;
};
