// SPDX-License-Identifier: MIT
//
// By one group: particles of surfaces as they would move, how far ahead to look, balls around triangles, and these in
// the cells of a uniform grid, hashed into buckets by counting. Their order in a bucket is no order yet:
// contact_order_kernel.glsl. Needs pushed_tables.glsl, contact_tables.glsl, contact_group.glsl, contact_range.glsl and
// kernel_language.glsl.

layout(local_size_x = GROUP) in;

uniform int pair;
uniform int bucket_next, raw_list, owner_list, bucket_of;  // words: scratch

// Largest speed against the mean, m/s.
float fastest_particle(int lane) {
  vec3 mean = vec3(0.0);
  for (int k = lane; k < surface_count; k += GROUP) {
    int place = load_rows[surface_place + k].x;
    vec4 free = float_row(free_velocity_place + place);
    vec3 moved = intBitsToFloat(changing_rows[pair_place(pair) + place]).xyz;
    store_row(surface_moved_place + k, vec4(moved, float_row(pushed_shift_place + place).w));
    store_row(surface_velocity_place + k, free);
    store_row(surface_push_place + k, vec4(0.0));
    mean += free.xyz * (1.0 / float(surface_count));
  }
  mean = sum_of_lanes(lane, vec4(mean, 0.0)).xyz;
  float fastest = 0.0;
  for (int k = lane; k < surface_count; k += GROUP) {
    vec3 v = float_row(surface_velocity_place + k).xyz - mean;
    fastest = larger(fastest, inner_product(v, v));
  }
  return sqrt(largest_of_lanes(lane, fastest));
}

// Largest radius of the balls, m.
float surround_triangles(int lane) {
  float widest = 0.0;
  for (int t = lane; t < triangle_count; t += GROUP) {
    ivec4 own = load_rows[triangle_place + t];
    vec3 a = about_place(own.x);
    vec3 b = about_place(own.y);
    vec3 c = about_place(own.z);
    vec3 middle = (a + b + c) * (1.0 / 3.0);
    float furthest = max(inner_product(a - middle, a - middle), inner_product(b - middle, b - middle));
    float radius = sqrt(max(furthest, inner_product(c - middle, c - middle)));
    store_row(triangle_ball_place + t, vec4(middle, radius));
    widest = larger(widest, radius);
  }
  return largest_of_lanes(lane, widest);
}

void main() {
  int lane = int(gl_LocalInvocationID.x);
  for (int b = lane; b <= bucket_count; b += GROUP) load_words[bucket_first + b] = 0;
  float margin = contact_margin(fastest_particle(lane));
  wait_for_group();
  float widest = surround_triangles(lane);
  float reach = contact_reach(margin);
  // Wider than needed, so that rounding of places as far away as 2^17 cells does not take anything out of the next cell.
  float inverse_side = 1.0 / ((widest + reach) * (1.0 + 1.0 / 64.0));
  bool any = widest < 1e4 * longest_edge;  // else a particle ran away, which is found out elsewhere
  if (lane == 0) store_row(contact_range_place, vec4(margin, reach, inverse_side, 0.0));
  for (int t = lane; t < triangle_count && any; t += GROUP) {
    int bucket = bucket_at(cell_at(float_row(triangle_ball_place + t).xyz, inverse_side));
    load_words[bucket_of + t] = bucket;
    atomicAdd(load_words[bucket_first + bucket + 1], 1);
  }
  wait_for_group();
  add_up_words(lane, bucket_first, bucket_count + 1);
  for (int b = lane; b < bucket_count; b += GROUP) load_words[bucket_next + b] = load_words[bucket_first + b];
  wait_for_group();
  for (int t = lane; t < triangle_count && any; t += GROUP) {
    int bucket = load_words[bucket_of + t];
    int entry = atomicAdd(load_words[bucket_next + bucket], 1);
    load_words[raw_list + entry] = t;
    load_words[owner_list + entry] = bucket;
  }
}
