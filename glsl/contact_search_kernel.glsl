// SPDX-License-Identifier: MIT
//
// The nearest triangle of each body to each particle of a surface, a lane each, as BodyContacts of src/cpu finds it: a
// lane looks at the triangles of the 27 cells about it in a fixed order. What is near enough to meet within the step is
// a contact. Needs contact_tables.glsl, vector3.glsl and closest_point.glsl.

layout(local_size_x = GROUP) in;

uniform int touches_itself;
uniform float skin;        // m; 0: a share of edges
uniform float usual_skin;  // that share
uniform float skin_factor;  // of edges: what is that near at rest does not touch, in one body
uniform float depth_factor;  // of edges: what is that far inside has not got in there

const float same_distance = 1e-6;  // edges: closer than this distances count as one

int own_row;  // of its meetings
ivec4 own;
float reach;

// While searching a meeting's rows are: none or its particle, corners; shares, distance; way off the triangle (unit),
// how much it faces; triangle, inside.

bool is_own_skin(int k, ivec4 corners, float edge) {
  if (own.y != corners.w >> 1) return false;
  float near = skin_factor * max(intBitsToFloat(own.z), edge);
  for (int c = 0; c < 3; ++c) {
    int corner = c == 0 ? corners.x : c == 1 ? corners.y : corners.z;
    vec3 high = float_row(surface_rest_place + 2 * corner).xyz - float_row(surface_rest_place + 2 * k).xyz;
    vec3 low = float_row(surface_rest_place + 2 * corner + 1).xyz - float_row(surface_rest_place + 2 * k + 1).xyz;
    vec3 way = high + low;
    if (inner_product(way, way) <= near * near) return true;
  }
  return false;
}

void keep_nearer(int k, int t, ivec4 corners, float edge, vec3 share, float far, vec3 way, float facing, bool inside) {
  int at = own_row + 4 * (corners.w >> 1);
  ivec4 known = load_rows[at + 3];
  if (load_rows[at].x >= 0) {
    float distance = float_row(at + 1).w;
    float alignment = float_row(at + 2).w;
    float tie = same_distance * edge;
    bool faces = facing > alignment || (facing == alignment && t < known.x);
    if (far >= distance - tie && !(far <= distance + tie && faces)) return;
  }
  load_rows[at] = ivec4(k, corners.xyz);
  store_row(at + 1, vec4(share, far));
  store_row(at + 2, vec4(way, facing));
  load_rows[at + 3] = ivec4(t, inside ? 1 : 0, 0, 0);
}

bool is_deep(float far, float edge) {
  return far > depth_factor * max(edge, intBitsToFloat(own.z));
}

void look(int k, int t, ivec4 corners) {
  float edge = float_row(triangle_law_place + t).x;
  if (is_own_skin(k, corners, edge)) return;
  vec3 a = way_between(k, corners.x);
  vec3 b = way_between(k, corners.y);
  vec3 c = way_between(k, corners.z);
  vec3 share = closest_point(a, b, c);
  vec3 way = -(share.x * a + share.y * b + share.z * c);
  float far = sqrt(inner_product(way, way));
  if (!(far <= reach)) return;
  vec3 area = cross_product(b - a, c - a);
  float size = sqrt(inner_product(area, area));
  float across = size > 0.0 && far > 0.0 ? inner_product(area, way) / (size * far) : 0.0;
  bool inside = (corners.w & 1) != 0 && across < 0.0;
  if (own.y == corners.w >> 1 && inside && is_deep(far, edge)) return;
  if (far > 0.0) {
    way = way * ((inside ? -1.0 : 1.0) / far);
  } else if (size > 0.0) {
    way = area * (1.0 / size);
  } else {
    return;
  }
  keep_nearer(k, t, corners, edge, share, far, way, abs(across), inside);
}

bool is_movable(int k) {
  return int(float_row(surface_velocity_place + k).w) != 7;
}

// What is left of a meeting: a contact, or none.
void settle(int at, float margin) {
  ivec4 who = load_rows[at];
  if (who.x < 0) return;
  ivec4 found = load_rows[at + 3];
  float edge = float_row(triangle_law_place + found.x).x;
  float own_edge = intBitsToFloat(own.z);
  float skins = skin > 0.0 ? 2.0 * skin : usual_skin * (edge + own_edge);
  vec4 nearest = float_row(at + 1);
  float gap = (found.y != 0 ? -nearest.w : nearest.w) - skins;
  bool movable = is_movable(who.x) || is_movable(who.y) || is_movable(who.z) || is_movable(who.w);
  bool deep = found.y != 0 && is_deep(nearest.w, edge);
  if (gap > margin || deep || !movable) {
    load_rows[at].x = -1;
    return;
  }
  store_row(at + 1, vec4(nearest.xyz, gap));
  store_row(at + 2, vec4(float_row(at + 2).xyz, max(edge, own_edge)));
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
