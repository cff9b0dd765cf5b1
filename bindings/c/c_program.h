// SPDX-License-Identifier: MIT
//
// What the program in C hands to the one in C++, which computes the same.
#pragma once

enum { most_particles = 64, skin_points = 3, thread_points = 6, shaft_points = 4 };

struct c_results {
  int particles, held;
  double position[3 * most_particles], velocity[3 * most_particles], force[3 * most_particles];
  double skin[3 * skin_points], normal[3 * skin_points];
  double tool_force[3], joint_force[3], energy[3], time, rest_residual;
  double thread[3 * thread_points], tension[thread_points - 1], knot, clip_tension, pressure, needle[3];
  double shaft[3 * shaft_points];
  int needle_nodes;
};

#ifdef __cplusplus
extern "C" {
#endif
const char* c_program(struct c_results* results);  // what went wrong; NULL: nothing
#ifdef __cplusplus
}
#endif
