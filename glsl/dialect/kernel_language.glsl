// SPDX-License-Identifier: MIT
//
// The words in which glsl/kernels/ is written, for GLSL. The same files are compiled as C++, where
// tests/mirror/kernels.h and src/cpu/simd/kernel_text.h define these words: for floats, for numbers that carry a bound
// of their rounding, and for packs. So a formula of the energy is written once, and once more in double precision
// (src/elastic/), which is the independent reference.
//
// Products and sums are written out, because the order in which dot() and length() add is the driver's. Inside functions
// Mesa turns a product of four into one of two products: kernels write it so.

#define KERNEL
#define KERNEL_CONSTANT const
#define OUT(type) out type
#define INOUT(type) inout type
#define real float
#define real3 vec3
#define literal(x) x
#define select(condition, a, b) ((condition) ? (a) : (b))
#define any_below(a, b) ((a) < (b))
#define square_root(x) sqrt(x)
#define inverse_root(x) (1.0 / sqrt(x))

// VolumeLaw::bounded
#ifdef BOUNDED_VOLUME
const bool bounded_volume = true;
#else
const bool bounded_volume = false;
#endif

// A matrix by its columns.
struct Columns {
  real3 c0, c1, c2;
};

float inner_product(vec3 a, vec3 b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}

vec3 cross_product(vec3 a, vec3 b) {
  return vec3(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}

// a > 0. Three steps of Newton's method, from a guess that is 4 % off.
float inverse_cube_root(float a) {
  float x = intBitsToFloat(0x54a2fa8d - floatBitsToInt(a) / 3);
  for (int k = 0; k < 3; ++k) x = x + (0.33333334 * x) * (1.0 - (a * x) * (x * x));
  return x;
}

// A driver may multiply by an inverse where the text divides: so the text does, here and below.
float quotient(float a, float b) {
  return a * (1.0 / b);
}

// 1 / sqrt(a) - 1 for a > 0 and y = a - 1, which is known better than by subtraction.
float inverse_root_change(float a, float y) {
  float root = sqrt(a);
  return -y * (1.0 / (root * (1.0 + root)));
}
