// SPDX-License-Identifier: MIT
//
// Per meeting, the nearest triangle of a body to a particle of a surface: contact_search_kernel.glsl with trees in place
// of a grid. What is near enough to meet within the step is a contact. Needs contact_surfaces.glsl, contact_tree.glsl and
// contact_nearest.glsl.

uniform int touches_itself;
TABLE_INTS(tree_roots, tree_roots_place);  // by body: its tree's first node, and the end of its nodes
STORED(fastest, fastest_place);            // one row: square of a speed

RESULT(0, ivec4, who);
RESULT(1, vec4, nearest);
RESULT(2, vec4, normal);

bool is_near(int n, vec3 x, float far) {
  vec3 below = fetch_changing(tree_low, tree_low_place, n).xyz - x;
  vec3 above = x - fetch_changing(tree_high, tree_high_place, n).xyz;
  vec3 off = max(max(below, above), vec3(0.0));
  return inner_product(off, off) <= far * far;
}

// The next leaf from node n on that is near; `end` where there is none.
int leaf_from(int n, int end, vec3 x, float far) {
  while (n < end) {
    ivec4 node = tree_node(n);
    bool near = is_near(n, x, far);
    if (near && node.w == 1) break;
    n = near ? n + 1 : node.z;
  }
  return n;
}

// False where there is none within reach.
bool find_nearest(int k, ivec4 own, int body, float reach, inout Seen nearest_one) {
  bool any = false;
  vec3 x = about_place(k);
  float slack = (1.0 / 32.0) * reach;  // rounding must not leave out what is just near enough, nor what is as near
  ivec2 tree = fetch_ivec2(tree_roots, tree_roots_place, body);
  float far = reach + slack;
  for (int n = leaf_from(tree.x, tree.y, x, far); n < tree.y; n = leaf_from(n + 1, tree.y, x, far)) {
    ivec4 leaf = tree_node(n);
    for (int entry = leaf.x; entry < leaf.y; ++entry) {
      int t = tree_item(entry);
      Seen seen;
      if (!look_from(t, fetch_ivec4(triangle, triangle_place, t), k, own, reach, seen)) continue;
      if (any && !comes_before(seen, nearest_one.triangle, nearest_one.rank)) continue;
      nearest_one = seen;
      far = seen.far + slack;
      any = true;
    }
  }
  return any;
}

void meeting_row(int m) {
  int k = m / body_count;
  int body = m - k * body_count;
  ivec4 own = fetch_ivec4(surface, surface_place, k);
  who = ivec4(-1);
  nearest = vec4(0.0);
  normal = vec4(0.0);
  if (touches_itself == 0 && body == own.y) return;
  float margin = contact_margin(sqrt(fetch_changing(fastest, fastest_place, 0).x));
  Seen seen = Seen(-1, false, 0.0, 0.0, vec3(0.0), vec3(0.0));
  if (!find_nearest(k, own, body, contact_reach(margin), seen)) return;
  ivec3 corners = fetch_ivec4(triangle, triangle_place, seen.triangle).xyz;
  float edge = triangle_edge(seen.triangle);
  float gap;
  if (!closes_in(seen.inside, seen.far, edge, own, margin, gap)) return;
  if (!takes_pushes(k) && !takes_pushes(corners.x) && !takes_pushes(corners.y) && !takes_pushes(corners.z)) return;
  who = ivec4(k, corners);
  nearest = vec4(seen.share, gap);
  normal = vec4(seen.way, max(edge, intBitsToFloat(own.z)));
}

PASS_MAIN(meeting_row)
