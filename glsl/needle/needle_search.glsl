// SPDX-License-Identifier: MIT
//
// Where a line meets the surface of the body, by all lanes of a group. Needs needle_surface.glsl and lone_group.glsl.

// Way and facing as above, of the nearest triangle, of several that near of the first one. `entering`: of the farthest
// on the shaft of those whose outside looks along it.
vec2 meet_surface(int lane, vec3 from, vec3 direction, bool entering) {
  vec4 best = vec4(-1.0, 0.0, 0.0, 0.0);  // way, facing, triangle
  for (int t = lane; t < facet_count; t += GROUP) {
    vec2 met = way_to(t, from, direction);
    if (!(met.x >= 0.0)) continue;
    if (entering && !(met.x <= needle_length && met.y > 0.0)) continue;
    if (best.x < 0.0 || (entering ? met.x > best.x : met.x < best.x)) best = vec4(met, float(t), 0.0);
  }
  group_rows[lane] = best;
  for (int half_of = GROUP / 2; half_of > 0; half_of /= 2) {
    wait_for_group();
    if (lane < half_of) {
      vec4 other = group_rows[lane + half_of];
      bool better = entering ? other.x > best.x : other.x < best.x;
      bool first = other.x == best.x && other.z < best.z;
      if (other.x >= 0.0 && (best.x < 0.0 || better || first)) best = other;
      group_rows[lane] = best;
    }
  }
  wait_for_group();
  vec2 found = group_rows[0].xy;
  wait_for_group();
  return found;
}
