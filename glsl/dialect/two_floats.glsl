// SPDX-License-Identifier: MIT
//
// Numbers as the sum of two floats, larger part first: about 44 bits. T. J. Dekker, "A floating-point technique for
// extending the available precision", Numer. Math. 18 (1971) 224-242. What must be rounded goes through integers, which
// no compiler reorders: OpenGL ES 3.1 has no `precise`.

uniform int kept_bits;  // 0, which a compiler cannot know

float kept(float x) {
  return intBitsToFloat(floatBitsToInt(x) ^ kept_bits);
}

vec2 quick_sum(float a, float b) {  // |a| >= |b|
  float s = kept(a + b);
  return vec2(s, b - kept(s - a));
}

vec2 exact_sum(float a, float b) {
  float s = kept(a + b);
  float part = kept(s - a);
  return vec2(s, kept(a - kept(s - part)) + kept(b - part));
}

vec2 split(float a) {
  float t = kept(4097.0 * a);
  float high = kept(t - kept(t - a));
  return vec2(high, kept(a - high));
}

vec2 exact_product(float a, float b) {
  float p = kept(a * b);
  vec2 x = split(a);
  vec2 y = split(b);
  float low = kept(x.x * y.x - p);
  low = kept(low + x.x * y.y);
  low = kept(low + x.y * y.x);
  return vec2(p, low + x.y * y.y);
}

vec2 sum_of(vec2 a, vec2 b) {
  vec2 s = exact_sum(a.x, b.x);
  return quick_sum(s.x, s.y + (a.y + b.y));
}

vec2 product_of(vec2 a, vec2 b) {
  vec2 p = exact_product(a.x, b.x);
  return quick_sum(p.x, p.y + (a.x * b.y + a.y * b.x));
}

vec2 quotient_of(vec2 a, vec2 b) {
  float first = a.x / b.x;
  vec2 left = sum_of(a, -product_of(vec2(first, 0.0), b));
  return quick_sum(first, left.x / b.x);
}

vec2 root_of(vec2 a) {
  float first = sqrt(a.x);
  vec2 left = sum_of(a, -exact_product(first, first));
  return quick_sum(first, left.x / (2.0 * first));
}
