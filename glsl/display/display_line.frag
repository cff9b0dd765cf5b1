// SPDX-License-Identifier: MIT
in float across;
in float along;
in float share;
uniform float opacity;
uniform float dash;  // pixels from one dash to the next; 0: a whole line
uniform bool tube;   // darker to its sides, as a rod
out vec4 colour;

void main() {
  if (dash > 0.0 && fract(along / dash) > 0.6) discard;
  float shade = tube ? 0.5 + 0.5 * sqrt(max(1.0 - across * across, 0.0)) : 1.0;
  colour = vec4(shade * colour_at(share), opacity);
}
