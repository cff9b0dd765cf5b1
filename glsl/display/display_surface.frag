// SPDX-License-Identifier: MIT
flat in vec3 normal;
in vec3 point;
in float share;
uniform float opacity;
out vec4 colour;

void main() {
  colour = vec4(lit(colour_at(share), normal, point), opacity);
}
