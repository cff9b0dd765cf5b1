// SPDX-License-Identifier: MIT
//
// The nearest triangle of each body to each particle of a surface, a lane each, as BodyContacts of src/interaction finds it: a
// lane looks at the triangles of the 27 cells about it in a fixed order. What is near enough to meet within the step is
// a contact. Needs contact_tables.glsl and contact_nearest.glsl.

layout(local_size_x = GROUP) in;

uniform int touches_itself;

int own_row;  // of its meetings
ivec4 own;
float reach;

// While searching a meeting's rows are: none or its particle, corners; shares, distance; way off the triangle (unit),
// how it faces the particle; triangle, inside.

void keep_nearer(int k, ivec4 corners, Seen seen) {
  int at = own_row + 4 * (corners.w >> 1);
  bool known = load_rows[at].x >= 0;
  if (known && !comes_before(seen, load_rows[at + 3].x, float_row(at + 1).w, float_row(at + 2).w)) return;
  load_rows[at] = ivec4(k, corners.xyz);
  store_row(at + 1, vec4(seen.share, seen.far));
  store_row(at + 2, vec4(seen.way, seen.facing));
  load_rows[at + 3] = ivec4(seen.triangle, seen.inside ? 1 : 0, 0, 0);
}

void look(int k, int t, ivec4 corners) {
  Seen seen;
  if (look_from(t, corners, k, own, reach, seen)) keep_nearer(k, corners, seen);
}

bool is_movable(int k) {
  return int(float_row(surface_velocity_place + k).w) != 7;
}

// What is left of a meeting: a contact, or none.
void settle(int at, float margin) {
  ivec4 who = load_rows[at];
  if (who.x < 0) return;
  ivec4 found = load_rows[at + 3];
  float edge = triangle_edge(found.x);
  vec4 nearest = float_row(at + 1);
  float gap;
  bool meets = closes_in(found.y != 0, nearest.w, edge, own, margin, gap);
  if (!meets || !(is_movable(who.x) || is_movable(who.y) || is_movable(who.z) || is_movable(who.w))) {
    load_rows[at].x = -1;
    return;
  }
  store_row(at + 1, vec4(nearest.xyz, gap));
  store_row(at + 2, vec4(float_row(at + 2).xyz, max(edge, intBitsToFloat(own.z))));
  store_row(at + 3, vec4(0.0));
}

void main() {
  int k = own_group() * GROUP + int(gl_LocalInvocationID.x);
  if (k >= surface_count) return;
  own = load_rows[surface_place + k];
  own_row = meeting_row(k, 0);
  for (int body = 0; body < body_count; ++body) load_rows[own_row + 4 * body].x = -1;
  vec4 range = float_row(contact_range_place);
  reach = range.y;
  vec3 x = about_place(k);
  ivec3 centre = cell_at(x, range.z);
  for (int near = 0; near < 27; ++near) {
    ivec3 cell = centre + ivec3(near / 9, near / 3 % 3, near % 3) - 1;
    int bucket = bucket_at(cell);
    int end = load_words[bucket_first + bucket + 1];
    for (int entry = load_words[bucket_first + bucket]; entry < end; ++entry) {
      int t = load_words[bucket_list + entry];
      ivec4 corners = load_rows[triangle_place + t];
      if (touches_itself == 0 && corners.w >> 1 == own.y) continue;
      vec4 ball = float_row(triangle_ball_place + t);
      if (cell_at(ball.xyz, range.z) != cell) continue;
      float far = (ball.w + reach) * (1.0 + 1.0 / 64.0);  // rounding must not leave out what is just near enough
      if (inner_product(x - ball.xyz, x - ball.xyz) <= far * far) look(k, t, corners);
    }
  }
  for (int body = 0; body < body_count; ++body) settle(own_row + 4 * body, range.x);
}
