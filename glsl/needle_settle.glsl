// SPDX-License-Identifier: MIT
//
// Impulses on the nodes of a needle's hole within their limits, node after node, several times over: NeedlePath::settle
// of src/cpu, in its order. What an impulse on one node does to the others goes by their coupling, so that the sweeps
// need no particles. Needs needle_nodes.glsl, and needle_bend.glsl where BENDING is defined.

// After them, on a straight insertion, nodes lie within some 1e-3 of a step's motion of where the limits let them be.
const int sweeps = 12;

shared vec4 given_now[2];
int slot;  // of given_now; two in turn, so that one wait is enough

// `impulse` of lane k, on its node, N s.
void give(int lane, int k, vec3 impulse) {
  if (lane == k) given_now[slot] = vec4(impulse, 0.0);
  wait_for_group();
  if (lane < node_count) own_motion = own_motion + coupling(lane, k).xyz * given_now[slot].xyz;
  slot = 1 - slot;
}

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

vec3 own_impulse(int k, bool bends) {
  vec3 impulse = vec3(0.0);
  bool pressed = (!punctured || is_last(k)) && own_pushed > 0.0;
  if (!bends && (on_shaft(k) || pressed)) impulse = hold_sideways();
  if (on_shaft(k)) impulse = impulse + rub(own_motion + coupling(k, k).xyz * impulse);
  return impulse;
}

void settle(int lane) {
  bool bends = bending_stiffness > 0.0;
  int last = node_count - 1;
  slot = 0;
#ifdef BENDING
  if (bends) couple_sideways(lane);
#endif
  for (int sweep = 0; sweep < sweeps; ++sweep) {
    if (!through && node_motion[last].w > 0.0) {
      vec3 impulse = vec3(0.0);
      if (lane == last) impulse = push_ahead();
      give(lane, last, impulse);
    }
#ifdef BENDING
    if (bends) hold_on_bent(lane);
#endif
    for (int k = 0; k < node_count; ++k) {
      if (node_motion[k].w == 0.0) continue;
      vec3 impulse = vec3(0.0);
      if (lane == k) impulse = own_impulse(k, bends);
      give(lane, k, impulse);
    }
  }
}
