// SPDX-License-Identifier: MIT
//
// Sixteen rows to one: what step_pass.glsl left in its targets, until one row is left. FIRST reads those targets
// themselves, later passes their own results. Needs fetch.glsl.

uniform int source_count;
#ifdef FIRST
uniform sampler2D displacement;
uniform int displacement_log2;
uniform sampler2D velocity;
uniform int velocity_log2;
uniform sampler2D measured;
uniform int measured_log2;
#else
uniform isampler2D events;
uniform int events_log2;
uniform sampler2D maxima;
uniform int maxima_log2;
#endif

layout(location = 0) out ivec4 least_events;  // first step of a runaway (never - 1: none, but forces were cut), its
                                              // particle, first and last unquiet step
invariant least_events;
layout(location = 1) out vec4 largest;        // speed, acceleration, force, displacement
invariant largest;

const int never = 2147483647;

#ifdef FIRST
ivec4 events_of(int row) {
  int ran_away = int(fetch(velocity, velocity_log2, row).w);
  int unquiet = int(fetch(displacement, displacement_log2, row).w);
  return ivec4(ran_away > 0 ? ran_away : ran_away < 0 ? never - 1 : never, row, unquiet == 0 ? never : unquiet >> 10, unquiet & 1023);
}
vec4 maxima_of(int row) {
  return fetch(measured, measured_log2, row);
}
#else
ivec4 events_of(int row) {
  return fetch(events, events_log2, row);
}
vec4 maxima_of(int row) {
  return fetch(maxima, maxima_log2, row);
}
#endif

// A value that is not a number is not larger.
float larger(float a, float b) {
  return a < b ? b : a;
}

void main() {
  int row = own_row();
  if (row >= row_count) discard;
  ivec4 found = ivec4(never, never, never, 0);
  vec4 most = vec4(0.0);
  int end = min(16 * row + 16, source_count);
  for (int source = 16 * row; source < end; ++source) {
    ivec4 other = events_of(source);
    // Rows come in order, so the first of a step is its smallest particle.
    if (other.x < found.x) found.xy = other.xy;
    found.z = min(found.z, other.z);
    found.w = max(found.w, other.w);
    vec4 size = maxima_of(source);
    most = vec4(larger(most.x, size.x), larger(most.y, size.y), larger(most.z, size.z), larger(most.w, size.w));
  }
  least_events = found;
  largest = most;
}
