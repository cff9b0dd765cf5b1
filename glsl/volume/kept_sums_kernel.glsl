// SPDX-License-Identifier: MIT
//
// What the particles of kept volumes have to make up for in a step: sums and roots. Many groups sum facets alone; one
// does the rest. Needs kept_sums_pass.glsl and kept_root_pass.glsl.

layout(local_size_x = GROUP) in;

TABLE_INTS(kept_levels, kept_levels_place);  // first and end node: of facets, then of sums of those before
uniform int kept_level_count, kept_count;
uniform int next_pair, number;
uniform int first_level;  // below 0: facets alone

// A level's nodes first, first + stride ... of it.
void store_kept_level(int level, int first, int stride) {
  ivec4 nodes = fetch_load_ivec4(kept_levels, kept_levels_place, level);
  for (int node = nodes.x + first; node < nodes.y; node += stride) {
    if (level == 0) {
      facets_row(node);
    } else {
      sums_row(node);
    }
    load_rows[kept_sums_place + node] = floatBitsToInt(kept_sum);
  }
}

void main() {
  displacement_place = pair_place(next_pair);
  kept_step = number;
  int lane = int(gl_LocalInvocationID.x);
  if (first_level < 0) {
    int groups = int(gl_NumWorkGroups.x * gl_NumWorkGroups.y);
    store_kept_level(0, own_group() * GROUP + lane, groups * GROUP);
    return;
  }
  for (int level = first_level; level < kept_level_count; ++level) {
    store_kept_level(level, lane, GROUP);
    memoryBarrierBuffer();  // of one group: what others wrote before is there after
    barrier();
  }
  for (int volume = lane; volume < kept_count; volume += GROUP) {
    root_row(volume);
    load_rows[kept_roots_place + volume] = floatBitsToInt(kept_root);
  }
}
