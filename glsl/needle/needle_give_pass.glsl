// SPDX-License-Identifier: MIT
//
// Per particle, what a needle's impulses on its nodes push it with, or (TWIST) a shaft that turns. Drawn only; needs
// needle_turning.glsl.

TABLE_INTS(needle_marks, needle_marks_place);
STORED(needle_impulses, needle_impulses_place);

RESULT(0, vec4, next_force);
RESULT(1, vec4, next_velocity);

bool is_marked(ivec2 mark, int k) {
  return (((k < 32 ? mark.x : mark.y) >> (k & 31)) & 1) != 0;
}

void give_row(int i) {
  next_force = fetch_load_vec4(pushed_force, pushed_force_place, i);
  next_velocity = fetch_load_vec4(free_velocity, free_velocity_place, i);
  ivec2 mark = fetch_ivec2(needle_marks, needle_marks_place, i);
  if (mark == ivec2(0) || is_held(i)) return;
#ifdef TWIST
  begin_needle();
  begin_motion();
  vec3 way = turning_of(i);
#else
  read_law();
  read_header();
#endif
  int axes = int(next_velocity.w);
  float ease = fetch_load_vec4(pushed_shift, pushed_shift_place, i).w;
  for (int k = 0; k < node_count; ++k) {
    if (!is_marked(mark, k)) continue;
    float weight = intBitsToFloat(list_entry(k, entry_of(k, i)).y);
#ifdef TWIST
    vec3 share = weight * fetch_changing(needle_impulses, needle_impulses_place, k).w * way;
#else
    vec3 share = weight * fetch_changing(needle_impulses, needle_impulses_place, k).xyz;
#endif
    share = vec3((axes & 1) != 0 ? 0.0 : share.x, (axes & 2) != 0 ? 0.0 : share.y, (axes & 4) != 0 ? 0.0 : share.z);
    next_velocity.xyz += ease * share;
    next_force.xyz += inverse_dt * share;
  }
}

PASS_MAIN(give_row)
