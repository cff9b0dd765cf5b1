// SPDX-License-Identifier: MIT
//
// What phymul-view is asked to show.
#pragma once

#include <phymul/body.h>

#include <optional>
#include <string>
#include <vector>

#include "surface_body.h"

struct ViewOptions {
  std::string body = "cylinder";  ///< a file, or a shape: tetrahedron, cylinder, block, strip
  double length_unit = 0.0;       ///< m, of the body's file; 0: the reader's own
  double spacing = 0.0;           ///< m, of the particles that fill a surface or image; 0: none was given
  std::string loads;              ///< .lml; empty: none
  std::vector<std::string> fixed_groups;
  std::vector<double> fixed_balls;  ///< m, each x y z radius
  std::vector<double> held_balls;   ///< the same, of the surface
  std::string backend = "auto";
  bool from_file = false;  ///< masses and stiffnesses of the file instead of the material
  phymul::Material material{.young = 10e3, .poisson = 0.3, .density = 1000.0};
  double damping_rate = 5.0;  ///< 1/s
  double step_share = 0.3;    ///< of the stable step at rest
  int width = 1000, height = 800;

  // For scripts.
  int frames = 0;  ///< 0: until the window is closed
  std::string png;
  bool hidden = false;
  std::string keys;          ///< pressed one after the other, one a frame
  std::vector<double> drag;  ///< pixels, each x0 y0 x1 y1: as the mouse, one way after the other
};

/// None where the program should end now, with `exit_code`.
std::optional<ViewOptions> read_view_options(int argc, char** argv, int& exit_code);

/// Throws phymul::Error where there is no such body.
FileBody make_view_body(const ViewOptions& options);
