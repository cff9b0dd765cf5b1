// SPDX-License-Identifier: MIT
//
// Many steps in one dispatch, by one workgroup, which waits for itself between the passes: no other could be waited for.
// Needs store_terms.glsl, store_step.glsl and wait_for_all.glsl; where KEPT_VOLUMES is defined, store_kept_sums.glsl and
// store_kept_step.glsl.

layout(local_size_x = GROUP) in;

uniform int pair, checkpoint;  // the pair to begin with, and the one to keep
uniform int number, steps;     // of the first step, and how many

// Of three pairs, one that is neither.
int free_pair(int a, int b) {
  return a != b ? 3 - a - b : a == 0 ? 1 : 0;
}

void main() {
  int lane = int(gl_LocalInvocationID.x);
  int from = pair;
  for (int step = 0; step < steps; ++step) {
    int to = free_pair(from, checkpoint);
    begin_step(from, to, number + step);
#ifdef ATTRACTOR_ROWS
    for (int i = lane; i < particle_count; i += GROUP) store_attractor(i);
#endif
#ifdef AVERAGED
    wait_for_all();  // its bases read the forces
#endif
#ifdef BASE_ROWS
    for (int t = lane; t < base_rows_count; t += GROUP) store_base(t);
#endif
#ifdef VOLUME_ROWS
    for (int row = lane; row < volume_count; row += GROUP) store_volume(row);
#endif
#ifdef DOMAIN_ROWS
    for (int d = lane; d < domain_count; d += GROUP) store_domain(d);
#endif
#ifdef STORED_TERMS
    wait_for_all();
#endif
    for (int i = lane; i < particle_count; i += GROUP) store_step(i, step == steps - 1);
    wait_for_all();
#ifdef KEPT_VOLUMES
    displacement_place = pair_place(to);
    kept_step = number + step;
    store_kept_roots(lane, 0);
    begin_kept_step(from, to, number + step);
    for (int i = lane; i < particle_count; i += GROUP) store_kept_step(i);
    wait_for_all();
#endif
    from = to;
  }
}
