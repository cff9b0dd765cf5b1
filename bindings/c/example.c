// SPDX-License-Identifier: MIT
//
// A block of tissue, a ball that is pressed into it, and a skin that follows: all a program in C needs.
#include <phymul_c.h>
#include <stdio.h>
#include <stdlib.h>

static void check(phymul_status status) {
  if (status == PHYMUL_OK) return;
  fprintf(stderr, "%s\n", phymul_last_error());
  exit(1);
}

int main(void) {
  const double size[3] = {0.06, 0.06, 0.04};  // m
  phymul_body* body = NULL;
  check(phymul_body_block(size, 6, 6, 4, &body));

  const phymul_material tissue = {.size = sizeof tissue, .young = 10e3, .poisson = 0.45, .density = 1000};
  const phymul_options options = {.size = sizeof options, .material = &tissue, .damping_rate = 20};
  const phymul_body* bodies[] = {body};
  phymul_simulation* sim = NULL;
  check(phymul_simulation_create(bodies, NULL, 1, &options, &sim));
  phymul_body_free(body);
  check(phymul_fix(sim, "z0"));

  phymul_pose pose = {.size = sizeof pose, .position = {0.03, 0.03, 0.052}};
  const phymul_tool_options ball = {.size = sizeof ball, .shape = PHYMUL_SPHERE, .radius = 0.01, .pose = &pose};
  uint64_t tool = 0;
  check(phymul_tool_add(sim, &ball, &tool));
  const double points[2][3] = {{0.03, 0.03, 0.04}, {0.0, 0.0, 0.04}};
  phymul_skin* skin = NULL;
  check(phymul_skin_create(sim, points[0], 2, NULL, 0, &skin));

  phymul_tool_force felt = {.size = sizeof felt};
  for (int tick = 0; tick < 200; ++tick) {
    pose.position[2] -= 5e-5;
    check(phymul_tool_move_to(sim, tool, &pose));
    check(phymul_advance(sim, 1e-3, NULL));
  }
  check(phymul_tool_read_force(sim, tool, &felt));
  const double* now = NULL;
  check(phymul_skin_deform(skin, sim, &now, NULL));
  printf("%.2f N on the ball; the point below it moved by %.1f mm\n", felt.force[2], 1e3 * (points[0][2] - now[2]));
  phymul_skin_free(skin);
  phymul_simulation_free(sim);
  return felt.force[2] > 0.1 ? 0 : 1;
}
