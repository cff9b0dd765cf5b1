// SPDX-License-Identifier: MIT
//
// Impulses on all nodes of a needle's hole, in a fragment that goes through all of them. Needs needle_limits.glsl and
// needle_coupling.glsl.

vec4 node_side[MOST_NODES];    // N s: sideways, along the shaft toward the hub
float pushed;                  // N s by the tip so far, forward: of the last node

// `impulse` on node k, N s.
void push_nodes(int k, vec3 impulse) {
  if (impulse == vec3(0.0)) return;
  for (int other = 0; other < node_count; ++other) {
    node_motion[other].xyz += coupling(other, k).xyz * impulse;
  }
}
