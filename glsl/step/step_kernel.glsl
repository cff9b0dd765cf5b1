// SPDX-License-Identifier: MIT
//
// One step of all particles, a lane each. Needs store_step.glsl.

layout(local_size_x = GROUP) in;

uniform int pair, next_pair, number, measuring;

void main() {
  int i = own_group() * GROUP + int(gl_LocalInvocationID.x);
  if (i >= particle_count) return;
  begin_step(pair, next_pair, number);
  store_step(i, measuring != 0);
}
