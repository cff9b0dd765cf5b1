// SPDX-License-Identifier: MIT
//
// Time of a step by number of particles, of the bodies and the law of bench/thesis_table.cpp.
#pragma once

#include <string>

struct StepTime {
  int particles = 0;
  double seconds = 0.0;  ///< for a step, of calls that take a tenth of a second or more
};

/// Of the lattice with so many particles a side; 0: of the cylinder of 275 particles. In the WebGL context that is
/// current. Throws Error as make_solver() and where a step fails.
StepTime step_time(int side, const std::string& backend);
