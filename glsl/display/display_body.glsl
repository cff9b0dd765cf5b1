// SPDX-License-Identifier: MIT
//
// Where the particles are: the rest shape, and the displacements in the texture that the solver writes. With SKIN, where
// the points of a skin are that these particles carry. Places are
// relative to the centre of the rest shape, so that a body far from the origin keeps its digits.
uniform highp sampler2D rest;          // X - centre, m
uniform highp sampler2D displacement;  // u in xyz, m
uniform int rest_log2;
uniform int displacement_log2;
uniform float displacement_scale;  // 1/m: share of the colour scale per metre; 0: one colour
uniform mat4 view;                 // from places to the eye's axes, m
uniform mat4 projection;

// Every table is as wide as a power of two.
ivec2 texel(int row, int log2_width) {
  return ivec2(row & ((1 << log2_width) - 1), row >> log2_width);
}

vec3 rest_place(int i) {
  return texelFetch(rest, texel(i, rest_log2), 0).xyz;
}

vec3 particle_moved_by(int i) {
  return texelFetch(displacement, texel(i, displacement_log2), 0).xyz;
}

#ifdef SKIN
// Two texels a point: particles that carry it, and their weights.
uniform highp isampler2D carriers;
uniform highp sampler2D shares;
uniform int carriers_log2;
uniform int shares_log2;

vec3 moved_by(int point) {
  vec3 sum = vec3(0.0);
  for (int row = 2 * point; row < 2 * point + 2; ++row) {
    ivec4 particle = texelFetch(carriers, texel(row, carriers_log2), 0);
    vec4 share = texelFetch(shares, texel(row, shares_log2), 0);
    sum += (share.x * particle_moved_by(particle.x) + share.y * particle_moved_by(particle.y)) +
           (share.z * particle_moved_by(particle.z) + share.w * particle_moved_by(particle.w));
  }
  return sum;
}
#else
vec3 moved_by(int i) {
  return particle_moved_by(i);
}
#endif

vec3 seen(vec3 place) {
  return (view * vec4(place, 1.0)).xyz;
}
