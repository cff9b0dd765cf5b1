// SPDX-License-Identifier: MIT
//
// How much friction each node of a needle's hole has in a step, in a fragment that knows where all of them are. Needs
// needle_motion.glsl.

float node_limit[MOST_NODES];  // N s

// Each node on the shaft rubs over half of the way to the next ones; the first up to the surface, the last to the tip
// or to where the shaft comes out.
void share_out_length() {
  float above = -1.0;  // along, of the border to the node before
  for (int k = 0; k < node_count; ++k) {
    node_limit[k] = 0.0;
    if (!on_shaft(k)) continue;
    float along = node_place[k].w;
    if (above < 0.0) above = along;
    float end = through && is_last(k) ? along : 0.0;
    bool last = is_last(k) || !on_shaft(k + 1);
    float below = last ? end : 0.5 * (along + node_place[k + 1].w);
    bool slides = turned != 0.0 || state_row(node_row(k)).y > 0.0;
    node_limit[k] = (slides ? kinetic_friction : static_friction) * max(0.0, above - below) * dt;
    above = below;
  }
}
