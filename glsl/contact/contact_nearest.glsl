// SPDX-License-Identifier: MIT
//
// Where a particle of a surface is seen from a triangle, and which of them it meets: look() and keep() of BodyContacts
// in src/interaction. Needs contact_range.glsl, kernel_language.glsl, closest_point.glsl, and of the tables triangle_edge(),
// rest_between() and way_between().

uniform float skin;          // m; 0: a share of edges
uniform float usual_skin;    // that share
uniform float skin_factor;   // of edges: what is that near at rest does not touch, in one body
uniform float facing_share;  // of the longest edge: by how much what faces a particle counts as nearer

struct Seen {
  int triangle;
  bool inside;
  float far, facing;  // m; of a body's the one of least difference is met
  vec3 share, way;  // of the corners in the nearest point; off the triangle, unit
};

// `own`: row of the particle's table.
bool is_own_skin(int k, ivec4 own, ivec4 corners, float edge) {
  if (own.y != corners.w >> 1) return false;
  float near = skin_factor * max(intBitsToFloat(own.z), edge);
  for (int c = 0; c < 3; ++c) {
    vec3 way = rest_between(k, c == 0 ? corners.x : c == 1 ? corners.y : corners.z);
    if (inner_product(way, way) <= near * near) return true;
  }
  return false;
}

bool is_deep(float far, float edge, ivec4 own) {
  return far > depth_factor * max(edge, intBitsToFloat(own.z));
}

// False where the particle is not within reach of triangle t.
bool look_from(int t, ivec4 corners, int k, ivec4 own, float reach, out Seen seen) {
  float edge = triangle_edge(t);
  if (is_own_skin(k, own, corners, edge)) return false;
  vec3 a = way_between(k, corners.x);
  vec3 b = way_between(k, corners.y);
  vec3 c = way_between(k, corners.z);
  vec3 share = closest_point(a, b, c);
  vec3 way = -(share.x * a + share.y * b + share.z * c);
  float far = sqrt(inner_product(way, way));
  if (!(far <= reach)) return false;
  vec3 area = cross_product(b - a, c - a);
  float size = sqrt(inner_product(area, area));
  float across = size > 0.0 && far > 0.0 ? inner_product(area, way) / (size * far) : 0.0;
  bool inside = (corners.w & 1) != 0 && across < 0.0;
  if (own.y == corners.w >> 1 && inside && is_deep(far, edge, own)) return false;
  if (far > 0.0) {
    way = way * ((inside ? -1.0 : 1.0) / far);
  } else if (size > 0.0) {
    way = area * (1.0 / size);
  } else {
    return false;
  }
  seen = Seen(t, inside, far, facing_share * longest_edge * abs(across), share, way);
  return true;
}

// Than the one known so far, of the same body. What faces a particle says less than floats of distances round: those of
// triangles that share the nearest corner are equal, and cancel.
bool comes_before(Seen seen, int triangle, float far, float facing) {
  float behind = (seen.far - far) - (seen.facing - facing);
  return behind < 0.0 || (behind == 0.0 && seen.triangle < triangle);
}

// Between the skins at the step's start, m. False where they do not meet within the step.
bool closes_in(bool inside, float far, float edge, ivec4 own, float margin, out float gap) {
  float own_edge = intBitsToFloat(own.z);
  float skins = skin > 0.0 ? 2.0 * skin : usual_skin * (edge + own_edge);
  gap = (inside ? -far : far) - skins;
  bool deep = inside && is_deep(far, edge, own);
  return !(gap > margin || deep);
}
