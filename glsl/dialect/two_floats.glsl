// SPDX-License-Identifier: MIT
//
// Numbers as the sum of two floats, larger part first: about 44 bits. T. J. Dekker, "A floating-point technique for
// extending the available precision", Numer. Math. 18 (1971) 224-242. Each rounding is `precise` where the
// language has the word, and also goes through integers, for OpenGL ES 3.1, which has not. Integers alone are not enough
// for every driver.

uniform int kept_bits;  // 0, which a compiler cannot know

float kept(float x) {
  PRECISE float rounded = intBitsToFloat(floatBitsToInt(x) ^ kept_bits);
  return rounded;
}

vec2 quick_sum(float a, float b) {  // |a| >= |b|
  PRECISE float s = kept(a + b);
  PRECISE vec2 sum = vec2(s, b - kept(s - a));
  return sum;
}

vec2 exact_sum(float a, float b) {
  PRECISE float s = kept(a + b);
  PRECISE float part = kept(s - a);
  PRECISE vec2 sum = vec2(s, kept(a - kept(s - part)) + kept(b - part));
  return sum;
}

vec2 split(float a) {
  PRECISE float t = kept(4097.0 * a);
  PRECISE float high = kept(t - kept(t - a));
  PRECISE vec2 both = vec2(high, kept(a - high));
  return both;
}

vec2 exact_product(float a, float b) {
  PRECISE float p = kept(a * b);
  PRECISE vec2 x = split(a);
  PRECISE vec2 y = split(b);
  PRECISE float low = kept(x.x * y.x - p);
  low = kept(low + x.x * y.y);
  low = kept(low + x.y * y.x);
  PRECISE vec2 product = vec2(p, low + x.y * y.y);
  return product;
}

vec2 sum_of(vec2 a, vec2 b) {
  PRECISE vec2 s = exact_sum(a.x, b.x);
  return quick_sum(s.x, s.y + (a.y + b.y));
}

vec2 product_of(vec2 a, vec2 b) {
  PRECISE vec2 p = exact_product(a.x, b.x);
  return quick_sum(p.x, p.y + (a.x * b.y + a.y * b.x));
}

vec2 quotient_of(vec2 a, vec2 b) {
  PRECISE float first = a.x / b.x;
  PRECISE vec2 left = sum_of(a, -product_of(vec2(first, 0.0), b));
  return quick_sum(first, left.x / b.x);
}

vec2 root_of(vec2 a) {
  PRECISE float first = sqrt(a.x);
  PRECISE vec2 left = sum_of(a, -exact_product(first, first));
  return quick_sum(first, left.x / (2.0 * first));
}
