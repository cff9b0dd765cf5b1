// SPDX-License-Identifier: MIT
//
// What the particles of kept volumes have to make up for in a step. Many groups sum facets alone; one does the rest.
// Needs store_kept_sums.glsl.

layout(local_size_x = GROUP) in;

uniform int next_pair, number;
uniform int first_level;  // below 0: facets alone

void main() {
  displacement_place = pair_place(next_pair);
  kept_step = number;
  int lane = int(gl_LocalInvocationID.x);
  if (first_level < 0) {
    int groups = int(gl_NumWorkGroups.x * gl_NumWorkGroups.y);
    store_kept_level(0, own_group() * GROUP + lane, groups * GROUP);
    return;
  }
  store_kept_roots(lane, first_level);
}
