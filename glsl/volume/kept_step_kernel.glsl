// SPDX-License-Identifier: MIT
//
// The end of a step of all particles, a lane each. Needs store_kept_step.glsl.

layout(local_size_x = GROUP) in;

uniform int pair, next_pair, number;

void main() {
  int i = own_group() * GROUP + int(gl_LocalInvocationID.x);
  if (i >= particle_count) return;
  begin_kept_step(pair, next_pair, number);
  store_kept_step(i);
}
