// SPDX-License-Identifier: MIT
//
// Impulses on the nodes of a needle's hole within their limits, node after node, several times over: NeedlePath::settle
// of src/cpu, in its order. What an impulse on one node does to the others goes by their coupling, so that the sweeps
// need no particles. Needs needle_nodes.glsl, and needle_bend.glsl where BENDING is defined.

shared vec4 given_now[2];
int slot;  // of given_now; two in turn, so that one wait is enough

// `impulse` of lane k, on its node, N s.
void give(int lane, int k, vec3 impulse) {
  if (lane == k) given_now[slot] = vec4(impulse, 0.0);
  wait_for_group();
  if (lane < node_count) own_motion = own_motion + coupling(lane, k).xyz * given_now[slot].xyz;
  slot = 1 - slot;
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
      if (lane == k) impulse = own_impulse(k, coupling(k, k).xyz, bends);
      give(lane, k, impulse);
    }
  }
}
