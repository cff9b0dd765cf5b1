// SPDX-License-Identifier: MIT
//
// How far a body is from a finer one under the same pull, both at rest.
#pragma once

#include <phymul/simulation.h>
#include <phymul/skin.h>

#include <memory>
#include <optional>

#include "organ.h"

struct PullError {
  double mean = 0.0;     ///< m, root of the mean square over the points of the surface
  double largest = 0.0;  ///< m
  double moved = 0.0;    ///< m, of the point of the finer body's surface that moved farthest
  int particles = 0;     ///< of the finer body
  double spacing = 0.0;  ///< m, of the finer body
};

class Comparison {
 public:
  Comparison(std::shared_ptr<const phymul::Surface> surface, double spacing);

  /// Throws Error where a rest shape is not found.
  PullError error_of(const Pull& pull);

 private:
  struct Body {
    phymul::Simulation simulation;
    phymul::Skin skin;
    phymul::VecList rest_under(const Pull& pull);
  };
  static Body body(const phymul::Surface& surface, double spacing);

  std::shared_ptr<const phymul::Surface> surface_;
  double spacing_;
  std::optional<Body> coarse_, fine_;  // made at the first question
};
