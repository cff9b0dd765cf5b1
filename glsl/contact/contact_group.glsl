// SPDX-License-Identifier: MIT
//
// What lanes of a single group do together besides lone_group.glsl; all of them call each function.

// What is not a number is not larger.
float larger(float a, float b) {
  return a < b ? b : a;
}

float largest_of_lanes(int lane, float own) {
  group_rows[lane] = vec4(own);
  for (int half_of = GROUP / 2; half_of > 0; half_of /= 2) {
    wait_for_group();
    if (lane < half_of) group_rows[lane].x = larger(group_rows[lane].x, group_rows[lane + half_of].x);
  }
  wait_for_group();
  float largest = group_rows[0].x;
  wait_for_group();
  return largest;
}

// Words first ... first + count - 1 become the sums up to themselves.
void add_up_words(int lane, int first, int count) {
  int length = (count + GROUP - 1) / GROUP;
  int from = min(lane * length, count);
  int to = min(from + length, count);
  int sum = 0;
  for (int k = from; k < to; ++k) sum += load_words[first + k];
  sum = count_before(lane, sum);
  for (int k = from; k < to; ++k) {
    sum += load_words[first + k];
    load_words[first + k] = sum;
  }
  wait_for_group();
}
