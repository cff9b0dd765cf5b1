// SPDX-License-Identifier: MIT
//
// What lanes of a single group do together; all of them call each function. GROUP is a power of two.

shared vec4 group_rows[GROUP];
shared int group_counts[GROUP];

void wait_for_group() {
  memoryBarrierShared();
  memoryBarrierBuffer();
  barrier();
}

vec4 sum_of_lanes(int lane, vec4 own) {
  group_rows[lane] = own;
  for (int half_of = GROUP / 2; half_of > 0; half_of /= 2) {
    wait_for_group();
    if (lane < half_of) group_rows[lane] += group_rows[lane + half_of];
  }
  wait_for_group();
  vec4 sum = group_rows[0];
  wait_for_group();
  return sum;
}

// Sum over the lanes before this one.
int count_before(int lane, int own) {
  group_counts[lane] = own;
  for (int far = 1; far < GROUP; far *= 2) {
    wait_for_group();
    int more = lane >= far ? group_counts[lane - far] : 0;
    wait_for_group();
    group_counts[lane] += more;
  }
  wait_for_group();
  int before = group_counts[lane] - own;
  wait_for_group();
  return before;
}
