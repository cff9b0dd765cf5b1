// SPDX-License-Identifier: MIT
//
// Sums and roots of kept volumes, computed and stored by one group, or the sums of facets by many. Dispatched only;
// needs kept_sums_pass.glsl, kept_root_pass.glsl and wait_for_all.glsl.

TABLE_INTS(kept_levels, kept_levels_place);  // first and end node: of facets, then of sums of those before
uniform int kept_level_count, kept_count;

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

void store_kept_roots(int lane, int first_level) {
  for (int level = first_level; level < kept_level_count; ++level) {
    store_kept_level(level, lane, GROUP);
    wait_for_all();
  }
  for (int volume = lane; volume < kept_count; volume += GROUP) {
    root_row(volume);
    load_rows[kept_roots_place + volume] = floatBitsToInt(kept_root);
  }
  wait_for_all();
}
