// SPDX-License-Identifier: MIT
//
// ROWS_TO_ONE rows to one, until one is left: the mean of the velocities of surfaces, m/s, or where FASTEST is defined the
// largest square of a speed against it. FIRST reads the velocities, later passes their own results. Needs
// contact_surfaces.glsl and kernel_language.glsl.

uniform int source_count;
#ifdef FIRST
#ifdef FASTEST
STORED(mean_velocity, mean_velocity_place);
#endif
#else
STORED(speeds, speeds_place);
#endif

RESULT(0, vec4, speed);

void speed_row(int row) {
  vec3 found = vec3(0.0);
#if defined(FIRST) && defined(FASTEST)
  vec3 mean = fetch_changing(mean_velocity, mean_velocity_place, 0).xyz;
#endif
  int end = min(ROWS_TO_ONE * (row + 1), source_count);
  for (int source = ROWS_TO_ONE * row; source < end; ++source) {
#ifdef FIRST
    vec3 v = fetch_changing(surface_velocity, surface_velocity_place, source).xyz;
#ifdef FASTEST
    float own = inner_product(v - mean, v - mean);
#else
    vec3 own = v * (1.0 / float(surface_count));
#endif
#else
    vec3 own = fetch_changing(speeds, speeds_place, source).xyz;
#endif
#ifdef FASTEST
    found = found.x < vec3(own).x ? vec3(own) : found;  // what is not a number is not larger
#else
    found = found + own;
#endif
  }
  speed = vec4(found, 0.0);
}

PASS_MAIN(speed_row)
