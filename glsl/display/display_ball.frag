// SPDX-License-Identifier: MIT
in vec2 disc;
in vec3 centre;
in float share;
uniform mat4 projection;
uniform float radius;
out vec4 colour;

void main() {
  float reach = dot(disc, disc);
  if (reach > 1.0) discard;
  vec3 normal = vec3(disc, sqrt(1.0 - reach));
  vec3 point = centre + radius * normal;
  vec4 place = projection * vec4(point, 1.0);
  gl_FragDepth = 0.5 + 0.5 * place.z / place.w;
  float rim = reach > 0.8 ? 0.55 : 1.0;  // a dark line around each, so that balls of one colour stay apart
  colour = vec4(rim * lit(colour_at(share), normal, point), 1.0);
}
