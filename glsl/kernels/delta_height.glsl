// SPDX-License-Identifier: MIT
//
// Twin of tests/mirror/delta_height.h. Wanted only where AREA_EXPONENT is defined.

float log_one_plus(float y) {
  float a = 1.0 + y;
  int e = (floatBitsToInt(a) - 0x3f3504f3) >> 23;
  float m = intBitsToFloat(floatBitsToInt(a) - (e << 23));
  float x = e == 0 ? y : m - 1.0;
  float t = x * (1.0 / (2.0 + x));
  float t2 = t * t;
  float series = 0.6666667 + t2 * (0.4 + t2 * (0.28571429 + t2 * 0.22222222));
  float log_m = 2.0 * t + t * (t2 * series);
  return 0.693145751953125 * float(e) + (log_m + 1.4286068203e-6 * float(e));
}

float exp_minus_one(float z_in) {
  float z = z_in < -80.0 ? -80.0 : z_in;
  float k = floor(z * 1.442695 + 0.5);
  float r = (z - k * 0.693145751953125) - k * 1.4286068203e-6;
  float tail =
      0.5 + r * (0.16666667 + r * (0.041666668 + r * (0.008333334 + r * (0.0013888889 + r * 0.0001984127))));
  float small = r + (r * r) * tail;
  float power = intBitsToFloat((int(k) + 127) << 23);
  return power * small + (power - 1.0);
}

struct DeltaHeight {
  float excess;
  float value;
  float slope;
};

DeltaHeight delta_height(float growth, float s, float p) {
  float excess = exp_minus_one(-(p * log_one_plus(growth)));
  float value = 1.0 + excess;
  float slope = -(p * s * value * (1.0 / (1.0 + growth)));
  return DeltaHeight(excess, value, slope);
}
