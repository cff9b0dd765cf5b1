// SPDX-License-Identifier: MIT
//
// One dispatch over the rows of all passes before the step that do not need each other, whole groups each. Needs
// store_terms.glsl.

layout(local_size_x = GROUP) in;

uniform int pair;
uniform int attractor_groups, base_groups, volume_groups;  // the rest are of domains

void main() {
  displacement_place = pair_place(pair);
  int group = own_group();
  int lane = int(gl_LocalInvocationID.x);
#ifdef ATTRACTOR_ROWS
  if (group < attractor_groups) {
    int i = group * GROUP + lane;
    if (i < particle_count) store_attractor(i);
    return;
  }
  group -= attractor_groups;
#endif
#ifdef BASE_ROWS
  if (group < base_groups) {
    int t = group * GROUP + lane;
    if (t < base_rows_count) store_base(t);
    return;
  }
  group -= base_groups;
#endif
#ifdef VOLUME_ROWS
  if (group < volume_groups) {
    int row = group * GROUP + lane;
    if (row < volume_count) store_volume(row);
    return;
  }
  group -= volume_groups;
#endif
#ifdef DOMAIN_ROWS
  int d = group * GROUP + lane;
  if (d < domain_count) store_domain(d);
#endif
}
