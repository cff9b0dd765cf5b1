// SPDX-License-Identifier: MIT
//
// For each particle the contacts it is in, in ascending order, as entries 4 * meeting + which of the four it is there.
// Nothing lists them: the next one is looked for, among the particle's own meetings and through trees among those of
// others. Needs contact_surfaces.glsl and contact_tree.glsl.

// The next leaf from node n on with place x in its box, and rows among `from` ... least - 1 that are in contact;
// tree_size where there is none.
int leaf_from(int n, vec3 x, int from, int least) {
  while (n < tree_size) {
    ivec4 node = tree_node(n);
    vec4 low = fetch_changing(tree_low, tree_low_place, n);
    vec4 high = fetch_changing(tree_high, tree_high_place, n);
    bool holds = all(lessThanEqual(low.xyz, x)) && all(lessThanEqual(x, high.xyz)) && high.w >= float(from) &&
                 low.w < float(least);
    if (holds && node.w == 1) break;
    n = holds ? n + 1 : node.z;
  }
  return n;
}

// Of contacts of other particles with a triangle that particle k is a corner of, behind meeting m; -1: none.
int corner_entry_after(int m, int k, int body) {
  int found = -1;
  int from = (m - body + body_count) / body_count;  // the first whose meeting is behind m
  int least = surface_count;                        // the surface row of what is found
  vec3 x = about_place(k);                          // the same bits as in the boxes
  for (int n = leaf_from(0, x, from, least); n < tree_size; n = leaf_from(n + 1, x, from, least)) {
    ivec4 leaf = tree_node(n);
    for (int entry = leaf.x; entry < leaf.y; ++entry) {
      int other = tree_item(entry);
      if (other < from || other >= least) continue;
      int meeting = other * body_count + body;
      ivec4 who = who_meet(meeting);
      int j = who.x < 0 ? 0 : who.y == k ? 1 : who.z == k ? 2 : who.w == k ? 3 : 0;
      if (j == 0) continue;
      least = other;
      found = 4 * meeting + j;
    }
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
