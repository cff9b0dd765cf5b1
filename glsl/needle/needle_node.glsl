// SPDX-License-Identifier: MIT
//
// Nodes of a needle's hole, by all lanes: a new one, places, and how an impulse on one moves the others. Needs
// needle_weights.glsl.

// Appends a node at x, from the tip, whose weights reach so far.
int add_node(int lane, vec3 x, float reach) {
  if (any(isnan(x)) || any(isinf(x))) return node_none;
  float inverse_reach = 1.0 / reach;
  int length = (model_count + GROUP - 1) / GROUP;
  int from = min(lane * length, model_count);
  int to = min(from + length, model_count);
  int own = 0;
  for (int row = from; row < to; ++row) {
    if (inside_of(basis_at(needle_words[needle_order + row], x, inverse_reach)) > 0.0) ++own;
  }
  int before = count_before(lane, own);
  if (lane == GROUP - 1) group_counts[0] = before + own;
  wait_for_group();
  int found = group_counts[0];
  wait_for_group();
  if (found > most_around || node_count >= longest) return node_full;
  int list = list_place(node_count);
  int entry = list + before;
  vec4 m0 = vec4(0.0);
  vec4 m1 = vec4(0.0);
  vec4 m2 = vec4(0.0);
  for (int row = from; row < to; ++row) {
    int i = needle_words[needle_order + row];
    vec4 b = basis_at(i, x, inverse_reach);
    float inside = inside_of(b);
    if (!(inside > 0.0)) continue;
    needle_words[entry] = i;
    ++entry;
    vec4 weighted = inside * inside * b;
    m0 += weighted;
    m1 += vec4(weighted.y * b.yzw, 0.0);
    m2 += vec4(weighted.z * b.z, weighted.z * b.w, weighted.w * b.w, 0.0);
  }
  m0 = sum_of_lanes(lane, m0);
  m1 = sum_of_lanes(lane, m1);
  m2 = sum_of_lanes(lane, m2);
  mat4 moments = moments_of(m0, m1.xyz, m2.xyz);
  bool sound = found >= 4 && spans(moments);
  if (!sound) return found < model_count && reach < 1000.0 * first_reach ? node_again : node_none;
  mat4 lower;
  cholesky(moments, lower);
  vec4 coefficients = vec4(0.0), missing = vec4(0.0);
  for (int k = 0; k < refinements; ++k) {
    vec4 sum = vec4(0.0);
    for (int j = before; j < before + own; ++j) {
      vec4 b = basis_at(needle_words[list + j], x, inverse_reach);
      float inside = inside_of(b);
      float weight = inside * inside * dot(coefficients, b);
      needle_words[list + most_around + j] = floatBitsToInt(weight);
      sum += weight * b;
    }
    sum = sum_of_lanes(lane, sum);
    missing = solved(lower, vec4(1.0, 0.0, 0.0, 0.0) - sum);
    if (k < refinements - 1) coefficients += missing;
  }
  // Coefficients are rounded more coarsely than this, where all particles lie to one side.
  for (int j = before; j < before + own; ++j) {
    vec4 b = basis_at(needle_words[list + j], x, inverse_reach);
    float inside = inside_of(b);
    float weight = intBitsToFloat(needle_words[list + most_around + j]) + inside * inside * dot(missing, b);
    needle_words[list + most_around + j] = floatBitsToInt(weight);
  }
  if (lane == 0) {
    needle_words[node_words(node_count)] = found;
    needle_words[node_words(node_count) + 1] = 0;
  }
  wait_for_group();
  ++node_count;
  return node_added;
}

// Of node k at the step's start, from the tip.
vec3 mean_place(int lane, int k) {
  vec4 sum = vec4(0.0);
  int end = around(k);
  for (int j = lane; j < end; j += GROUP) sum += vec4(weight_of(k, j) * place_of(particle_of(k, j)), 0.0);
  return sum_of_lanes(lane, sum).xyz;
}

// How an impulse on node k moves itself and those before it, and they it: sums over common particles, a team for each.
void couple_node(int lane, int k) {
  int end = around(k);
  for (int j = lane; j < end; j += GROUP) {
    int i = particle_of(k, j);
    vec4 ease = eased(i, weight_of(k, j));
    for (int c = 0; c < 4; ++c) needle_words[share_place + 4 * i + c] = floatBitsToInt(ease[c]);
  }
  wait_for_group();
  int member = lane % TEAM;
  for (int first = 0; first <= k; first += GROUP / TEAM) {
    int other = first + lane / TEAM;
    vec4 sum = vec4(0.0);
    if (other <= k) {
      int others = around(other);
      for (int j = member; j < others; j += TEAM) {
        int share = share_place + 4 * particle_of(other, j);
        ivec4 bits = ivec4(needle_words[share], needle_words[share + 1], needle_words[share + 2],
                           needle_words[share + 3]);
        sum += weight_of(other, j) * intBitsToFloat(bits);
      }
    }
    group_rows[lane] = sum;
    wait_for_group();
    if (member == 0 && other <= k) {
      for (int m = 1; m < TEAM; ++m) sum += group_rows[lane + m];
      for (int c = 0; c < 4; ++c) {
        needle_words[coupling_row(k, other) + c] = floatBitsToInt(sum[c]);
        needle_words[coupling_row(other, k) + c] = floatBitsToInt(sum[c]);
      }
    }
    wait_for_group();
  }
  for (int j = lane; j < end; j += GROUP) {
    for (int c = 0; c < 4; ++c) needle_words[share_place + 4 * particle_of(k, j) + c] = 0;
  }
  wait_for_group();
}
