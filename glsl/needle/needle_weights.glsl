// SPDX-License-Identifier: MIT
//
// Weights of a node of a needle's hole by moving least squares: twin of needle_weights.cpp of src/cpu. Needs
// needle_tables.glsl and pushed_tables.glsl.

// Least over largest eigenvalue of the moments below which particles lie in a plane, or all but.
const float flattest = 1e-4;
// Weights fulfil their conditions to rounding after so many solutions.
const int refinements = 4;

const int node_again = 0, node_added = 1, node_none = 2, node_full = 3;

// Lower triangle; false where m is not positive definite.
bool cholesky(mat4 m, out mat4 lower) {
  lower = mat4(0.0);
  for (int j = 0; j < 4; ++j) {
    float pivot = m[j][j];
    for (int k = 0; k < j; ++k) pivot -= lower[k][j] * lower[k][j];
    if (!(pivot > 0.0)) return false;
    lower[j][j] = sqrt(pivot);
    for (int i = j + 1; i < 4; ++i) {
      float entry = m[j][i];
      for (int k = 0; k < j; ++k) entry -= lower[k][i] * lower[k][j];
      lower[j][i] = entry / lower[j][j];
    }
  }
  return true;
}

vec4 solved(mat4 lower, vec4 x) {
  for (int j = 0; j < 4; ++j) {
    for (int k = 0; k < j; ++k) x[j] -= lower[k][j] * x[k];
    x[j] /= lower[j][j];
  }
  for (int j = 3; j >= 0; --j) {
    for (int k = j + 1; k < 4; ++k) x[j] -= lower[j][k] * x[k];
    x[j] /= lower[j][j];
  }
  return x;
}

float trace(mat4 m) {
  return m[0][0] + m[1][1] + m[2][2] + m[3][3];
}

// Of moments, whose eigenvalues are not negative: its 33rd power has little but the largest.
float largest_eigenvalue(mat4 m) {
  mat4 power = m * (1.0 / trace(m));
  for (int k = 0; k < 5; ++k) {
    power = power * power;
    power = power * (1.0 / trace(power));
  }
  return trace(power * m);
}

// Particles span space.
bool spans(mat4 moments) {
  if (!(trace(moments) > 0.0)) return false;
  mat4 unused;
  return cholesky(moments - mat4(flattest * largest_eigenvalue(moments)), unused);
}

vec4 basis_at(int i, vec3 x, float inverse_reach) {
  return vec4(1.0, inverse_reach * (place_of(i) - x));
}

// Of the place that basis_at() tells of; 0 where it is beyond the reach.
float inside_of(vec4 basis) {
  return max(1.0 - inner_product(basis.yzw, basis.yzw), 0.0);
}

// Of sums of weight * (b, products of its last three): see add_node().
mat4 moments_of(vec4 m0, vec3 m1, vec3 m2) {
  return mat4(m0, vec4(m0.y, m1), vec4(m0.z, m1.y, m2.xy), vec4(m0.w, m1.z, m2.yz));
}

// 1/kg: what a share of an impulse on a particle adds to its velocity, along the axes, and as one number for all of
// them. (Nothing pushes what a tool holds along any axis: free_kernel.glsl.)
vec4 eased(int i, float share) {
  int axes = int(fetch_load_vec4(free_velocity, free_velocity_place, i).w);
  float ease = axes == 7 ? 0.0 : share * fetch_load_vec4(pushed_shift, pushed_shift_place, i).w;
  return vec4((axes & 1) != 0 ? 0.0 : ease, (axes & 2) != 0 ? 0.0 : ease, (axes & 4) != 0 ? 0.0 : ease, ease);
}
