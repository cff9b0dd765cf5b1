// SPDX-License-Identifier: MIT
//
// What a step leaves of a particle. Needs net_force.glsl.
//
// What a step has to tell rides along, so that no further pass is needed until the batch of steps ends:
//   velocity.w      number of the first step of the batch in which the particle ran away; 0: none, -1: none, but in some
//                   step its elastic force was cut
//   displacement.w  first * 1024 + last step of the batch in which it was not quiet; 0: none

OF_STEP(int, batch_step);  // counts from 1
uniform float runaway_speed, speed_at_rest, acceleration_at_rest;

RESULT(0, vec4, next_displacement);
RESULT(1, vec4, next_velocity);
RESULT(2, vec4, next_measured);  // speed, acceleration, force of the free coordinates; displacement

float length_of(vec3 a) {
  return sqrt(inner_product(a, a));
}

bool finite(vec3 a) {
  return !(any(isnan(a)) || any(isinf(a)));
}

float unquiet_steps(float before, bool quiet) {
  int steps = batch_step == 1 ? 0 : int(before);
  if (quiet) return float(steps);
  int first = steps == 0 ? batch_step : steps >> 10;
  return float(first * 1024 + batch_step);
}

// Moved to u with velocity v by acceleration a; w of the rows before the step; was_cut: as net_force() has it.
void measure_step(vec3 u, vec3 v, vec3 a, float mass, int fixed_at, float unquiet_before, float ran_away_before,
                  float was_cut) {
  float speed = length_of(free_part(v, fixed_at));
  float pushed = length_of(free_part(a, fixed_at));
  next_measured = vec4(speed, pushed, mass * pushed, length_of(u));
  bool quiet = speed <= speed_at_rest && pushed <= acceleration_at_rest;
  bool bad = !finite(u) || !finite(v) || !(length_of(v) <= runaway_speed);
  float ran_away = batch_step == 1 ? 0.0 : ran_away_before;
  if (ran_away <= 0.0) ran_away = bad ? float(batch_step) : min(ran_away, -was_cut);
  next_displacement = vec4(u, unquiet_steps(unquiet_before, quiet));
  next_velocity = vec4(v, ran_away);
}
