// SPDX-License-Identifier: MIT
#pragma once

#include <phymul/camera.h>
#include <phymul/simulation.h>

#include <optional>

/// A sharp edge along the line of sight, through the whole body, which cuts from where the mouse was to where it is.
class Scalpel {
 public:
  /// `body`: what is cut, at rest.
  Scalpel(phymul::Simulation& sim, const phymul::Model& body);

  void begin(double x, double y);  ///< pixels
  /// Once a frame: the edge goes less than a spacing in each (docs/guide/tools.md), and so comes after a hasty mouse.
  void move(const phymul::Camera& camera, double x, double y, int width, int height);
  void end();

 private:
  phymul::Simulation& sim_;
  double width_, longest_way_;            // m
  phymul::Vec3 middle_;                   // of the body, m
  std::optional<Eigen::Vector2d> place_;  // of the edge, pixels
  std::optional<phymul::ToolHandle> blade_;
};
