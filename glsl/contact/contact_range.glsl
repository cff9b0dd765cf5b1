// SPDX-License-Identifier: MIT
//
// How far ahead contacts are looked for, m.

uniform float dt;
uniform float longest_edge, largest_skins;  // m; the latter of two that meet, together
uniform float depth_factor;  // of edges: what is that far inside has not got in there

// fastest: the largest speed against the mean, m/s.
float contact_margin(float fastest) {
  return min(2.0 * dt * fastest, 4.0 * longest_edge);
}

float contact_reach(float margin) {
  return max(margin + largest_skins, depth_factor * longest_edge);
}
