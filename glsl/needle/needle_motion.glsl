// SPDX-License-Identifier: MIT
//
// How a needle and the nodes of its hole move in one step, and the impulses on one of them within their limits, by the
// law of NeedlePath of src/cpu. Needs needle_shaft.glsl and pushed_tables.glsl.

uniform float dt, inverse_dt;

vec3 end_axis, gone, gain;  // the axis at the step's end; what tip and axis gain up to there
float turned;               // m: how far the shaft's surface turns

shared vec4 node_place[MOST_NODES];   // at the step's start from the tip; along the axis
shared vec4 node_motion[MOST_NODES];  // m/s, with the impulses so far; 1/kg: of itself

// Of the node in hand.
vec3 own_place, own_motion;
float own_ease;                // 1/kg
float own_limit;               // N s
float own_rubbed, own_pushed;  // N s so far: along the shaft toward the hub; by the tip, forward
vec3 own_side;                 // N s

bool is_last(int k) {
  return k == node_count - 1;
}

// All nodes but the one ahead of the tip.
bool on_shaft(int k) {
  return punctured && !(is_last(k) && !through) && node_place[k].w > 0.0;
}

void begin_motion() {
  vec4 x = frame_row(number - 1, 4);
  vec4 y = frame_row(number - 1, 5);
  vec4 z = frame_row(number - 1, 6);
  gone = vec3(x.w, y.w, z.w);
  gain = z.xyz;
  turned = frame_row(number - 1, 3).w;
  end_axis = frame_row(number, 2).xyz;
}

vec3 motion_of(int i) {
  return fetch_load_vec4(free_velocity, free_velocity_place, i).xyz;
}

// m, along the axis, by which a node that moves so slides on the shaft; as tools see ways, from what both gain.
float slide_of(vec3 place, vec3 motion) {
  return inner_product(end_axis, dt * motion - gone) + inner_product(gain, place);
}

vec3 across(vec3 x) {
  return x - inner_product(end_axis, x) * end_axis;
}

// After them, on a straight insertion, nodes lie within some 1e-3 of a step's motion of where the limits let them be.
const int sweeps = 12;

// The last node stays ahead of the tip, but for what has slipped past, as long as that takes less than the limit.
vec3 push_ahead() {
  float behind = inner_product(end_axis, own_place - gone + dt * own_motion) - slip;
  float most = (punctured ? cutting : puncture) * dt;
  float wanted = clamp(own_pushed + behind * (1.0 / (dt * own_ease)), 0.0, most);
  vec3 impulse = (own_pushed - wanted) * end_axis;
  own_pushed = wanted;
  return impulse;
}

// Onto the axis. The tip on the surface holds it by dry friction only.
vec3 hold_sideways() {
  vec3 wanted = own_side - (1.0 / (dt * own_ease)) * across(own_place - gone + dt * own_motion);
  float most = surface_friction * own_pushed;
  float size = sqrt(inner_product(wanted, wanted));
  if (!punctured && size > most) wanted = wanted * (most / size);
  vec3 impulse = wanted - own_side;
  own_side = wanted;
  return impulse;
}

vec3 rub(vec3 motion) {
  float wanted = own_rubbed - slide_of(own_place, motion) * (1.0 / (dt * own_ease));
  wanted = clamp(wanted, -own_limit, own_limit);
  vec3 impulse = (wanted - own_rubbed) * end_axis;
  own_rubbed = wanted;
  return impulse;
}

// `itself`: how it moves itself, 1/kg along the axes.
vec3 own_impulse(int k, vec3 itself, bool bends) {
  vec3 impulse = vec3(0.0);
  bool at_tip = is_last(k) && !through && (punctured ? !is_ahead_of_tip(node_place[k].w) : own_pushed > 0.0);
  if (!bends && (on_shaft(k) || at_tip)) impulse = hold_sideways();
  if (on_shaft(k)) impulse = impulse + rub(own_motion + itself * impulse);
  return impulse;
}
