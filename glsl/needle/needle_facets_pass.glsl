// SPDX-License-Identifier: MIT
//
// Where the shaft meets the surface of the body, up to 32 facets (FIRST), then rows, to one: the farthest on the shaft
// from the tip whose outside looks along it; the nearest from the tip back along the shaft, and ahead. Drawn only; needs
// needle_follow.glsl and needle_surface.glsl.

#ifndef FIRST
STORED(entering_rows, entering_rows_place);
STORED(behind_rows, behind_rows_place);
STORED(ahead_rows, ahead_rows_place);
#endif
uniform int source_count;

// Way (negative: none), facing (> 0: outward), triangle.
RESULT(0, vec4, entering);
RESULT(1, vec4, behind);
RESULT(2, vec4, ahead);

// Of several that near the first.
vec4 better_of(vec4 best, vec4 other, bool farther) {
  if (!(other.x >= 0.0)) return best;
  if (best.x < 0.0) return other;
  if (other.x == best.x) return other.z < best.z ? other : best;
  return (farther ? other.x > best.x : other.x < best.x) ? other : best;
}

void facets_row(int row) {
  if (int(state_row(1).w) == done) discard;
#ifdef FIRST
  begin_needle();
  vec3 tip = shaft_at(0.0);
  vec3 back = way_back();
#endif
  entering = vec4(-1.0, 0.0, 0.0, 0.0);
  behind = entering;
  ahead = entering;
  int end = min(branch * (row + 1), source_count);
  for (int t = branch * row; t < end; ++t) {
#ifdef FIRST
    vec4 met = vec4(way_to(t, vec3(0.0), axis), float(t), 0.0);
    if (met.x <= needle_length && met.y > 0.0) entering = better_of(entering, met, true);
    behind = better_of(behind, vec4(way_to(t, tip, back), float(t), 0.0), false);
    ahead = better_of(ahead, vec4(way_to(t, tip, -back), float(t), 0.0), false);
#else
    entering = better_of(entering, fetch_changing(entering_rows, entering_rows_place, t), true);
    behind = better_of(behind, fetch_changing(behind_rows, behind_rows_place, t), false);
    ahead = better_of(ahead, fetch_changing(ahead_rows, ahead_rows_place, t), false);
#endif
  }
}

PASS_MAIN(facets_row)
