// SPDX-License-Identifier: MIT
//
// For each particle the contacts it is in, in ascending order, as entries 4 * meeting + which of the four it is there.
// Nothing lists them: the next one is looked for, among the particle's own meetings and through trees among those of
// others. Needs contact_surfaces.glsl and contact_tree.glsl.

// Of contacts of other particles with a triangle that particle k is a corner of; -1: none.
int corner_entry_after(int m, int k, int body) {
  int found = -1;
  int least = surface_count;                        // the surface row of what is found
  int from = (m - body + body_count) / body_count;  // the first whose meeting is behind m
  vec3 x = about_place(k);                          // the same bits as in the boxes
  for (int n = 0; n < tree_size;) {
    ivec4 node = tree_node(n);
    vec4 low = fetch_changing(tree_low, tree_low_place, n);
    vec4 high = fetch_changing(tree_high, tree_high_place, n);
    bool holds = all(lessThanEqual(low.xyz, x)) && all(lessThanEqual(x, high.xyz));
    if (!holds || high.w < float(from) || low.w >= float(least)) {
      n = node.z;
      continue;
    }
    for (int entry = node.x; node.w == 1 && entry < node.y; ++entry) {
      int other = tree_item(entry);
      if (other < from || other >= least) continue;
      int meeting = other * body_count + body;
      ivec4 who = who_meet(meeting);
      if (who.x < 0) continue;
      int j = who.y == k ? 1 : who.z == k ? 2 : who.w == k ? 3 : 0;
      if (j == 0) continue;
      least = other;
      found = 4 * meeting + j;
    }
    ++n;
  }
  return found;
}

// Of particle k, behind meeting m; -1: none.
int entry_after(int m, int k) {
  int body = fetch_ivec4(surface, surface_place, k).y;
  int found = body < 0 ? -1 : corner_entry_after(m, k, body);
  for (int own = max(k * body_count, m + 1); own < (k + 1) * body_count; ++own) {
    if (who_meet(own).x < 0) continue;
    return found < 0 ? 4 * own : min(found, 4 * own);
  }
  return found;
}
