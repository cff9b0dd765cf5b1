// SPDX-License-Identifier: MIT
//
// Colour and light, in the eye's axes.
uniform vec3 scale_colour[17];  // at even steps of the share
uniform vec3 plain_colour;      // where displacement_scale is 0
uniform bool by_displacement;
uniform bool parallel_rays;
uniform vec3 light;  // unit vector towards it

vec3 colour_at(float share) {
  if (!by_displacement) return plain_colour;
  float place = clamp(share, 0.0, 1.0) * 16.0;
  int row = min(int(place), 15);
  return mix(scale_colour[row], scale_colour[row + 1], place - float(row));
}

vec3 towards_eye(vec3 point) {
  return parallel_rays ? vec3(0.0, 0.0, 1.0) : normalize(-point);
}

// Both sides are lit: faces of a plane body or of a turned cell may look away.
vec3 lit(vec3 colour, vec3 normal, vec3 point) {
  vec3 facing = dot(normal, towards_eye(point)) < 0.0 ? -normal : normal;
  return colour * (0.66 + 0.38 * max(dot(facing, light), 0.0));
}
