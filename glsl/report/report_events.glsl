// SPDX-License-Identifier: MIT
//
// What step_pass.glsl left in its results, and how two rows' become one.
//   events   first step of a runaway (never - 1: none, but forces were cut), its particle, first and last unquiet step
//   largest  speed, acceleration, force, displacement

const int never = 2147483647;

ivec4 events_of(vec4 u, vec4 v, int particle) {
  int ran_away = int(v.w);
  int unquiet = int(u.w);
  return ivec4(ran_away > 0 ? ran_away : ran_away < 0 ? never - 1 : never, particle, unquiet == 0 ? never : unquiet >> 10,
               unquiet & 1023);
}

// A value that is not a number is not larger.
float larger(float a, float b) {
  return a < b ? b : a;
}

// Of one step, the smallest particle.
void merge_events(inout ivec4 events, ivec4 other) {
  if (other.x < events.x || (other.x == events.x && other.y < events.y)) events.xy = other.xy;
  events.z = min(events.z, other.z);
  events.w = max(events.w, other.w);
}

void merge_largest(inout vec4 largest, vec4 other) {
  largest = vec4(larger(largest.x, other.x), larger(largest.y, other.y), larger(largest.z, other.z),
                 larger(largest.w, other.w));
}
