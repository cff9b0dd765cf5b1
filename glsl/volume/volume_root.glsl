// SPDX-License-Identifier: MIT
//
// Twin of tests/mirror/mirror_scene.h: the s nearest to 0 with c1 s + c2 s^2 + c3 s^3 = wanted, on the branch through 0 on
// which the cubic grows. Computed as a way t = |s| ahead.

struct VolumeRoot {
  bool found;
  float s;
};

// Where a cubic that grows at 0 ceases to, ahead; 0: it never does.
float growing_end(float c1, float c2, float c3) {
  float under = c2 * c2 - 3.0 * (c3 * c1);
  float root = sqrt(max(under, 0.0));
  float end = c2 < 0.0 ? c1 * (1.0 / (root - c2)) : (c2 + root) * (1.0 / (-3.0 * c3));
  return under < 0.0 || (c2 >= 0.0 && c3 >= 0.0) ? 0.0 : end;
}

VolumeRoot root_of_cubic(vec3 c, float wanted) {
  float total = abs(wanted) + c.x + abs(c.y) + abs(c.z);
  if (!(c.x > 0.0) || isnan(total) || isinf(total)) return VolumeRoot(false, 0.0);
  if (wanted == 0.0) return VolumeRoot(true, 0.0);
  float W = abs(wanted);
  float c2 = wanted < 0.0 ? -c.y : c.y;
  float end = growing_end(c.x, c2, c.z);
  bool ends = end > 0.0;
  float straight = W * (1.0 / c.x);
  float high = ends ? min(straight, end) : straight;
  for (int k = 0; k < 64; ++k) {
    if (((c.z * high + c2) * high + c.x) * high >= W) break;
    if (k == 63 || (ends && high >= end)) return VolumeRoot(false, 0.0);
    high = ends ? min(2.0 * high, end) : 2.0 * high;
  }
  // Newton's iteration, kept in between by halving.
  float low = 0.0;
  float t = min(straight, high);
  for (int k = 0; k < 64; ++k) {
    float ahead = ((c.z * t + c2) * t + c.x) * t - W;
    float slope = (3.0 * c.z * t + 2.0 * c2) * t + c.x;
    low = ahead < 0.0 ? t : low;
    high = ahead < 0.0 ? high : t;
    float newton = t - ahead * (1.0 / slope);
    float next = newton > low && newton < high ? newton : 0.5 * (low + high);
    if (ahead == 0.0 || next == t || next == low || next == high) break;
    t = next;
  }
  return VolumeRoot(true, wanted < 0.0 ? -t : t);
}
