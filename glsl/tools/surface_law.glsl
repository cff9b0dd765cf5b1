// SPDX-License-Identifier: MIT
//
// Twin of SurfacePress in src/interaction, for a patch: its points in a round, all from the same state. Needs
// surface_tables.glsl and touch_tools.glsl.

struct PatchCorners {  // in the tool's frame, m
  vec4 end_a, end_b, end_c;
  vec4 way_a, way_b, way_c;
};

struct PatchPush {  // a column for each corner
  mat3 impulse, shift;
};

PatchCorners first_corners(ivec3 who) {
  return PatchCorners(fetch_load_vec4(first_end, first_end_place, who.x),
                      fetch_load_vec4(first_end, first_end_place, who.y),
                      fetch_load_vec4(first_end, first_end_place, who.z),
                      fetch_load_vec4(first_way, first_way_place, who.x),
                      fetch_load_vec4(first_way, first_way_place, who.y),
                      fetch_load_vec4(first_way, first_way_place, who.z));
}

PatchCorners corners_now(ivec3 who) {
  return PatchCorners(fetch_load_vec4(corner_end, corner_end_place, who.x),
                      fetch_load_vec4(corner_end, corner_end_place, who.y),
                      fetch_load_vec4(corner_end, corner_end_place, who.z),
                      fetch_load_vec4(corner_way, corner_way_place, who.x),
                      fetch_load_vec4(corner_way, corner_way_place, who.y),
                      fetch_load_vec4(corner_way, corner_way_place, who.z));
}

vec3 point_end(PatchCorners at, vec3 share) {
  return share.x * at.end_a.xyz + share.y * at.end_b.xyz + share.z * at.end_c.xyz;
}

vec3 point_way(PatchCorners at, vec3 share) {
  return share.x * at.way_a.xyz + share.y * at.way_b.xyz + share.z * at.way_c.xyz;
}

float square(vec3 a) {
  return inner_product(a, a);
}

// Whether a point of it may be in the tool at the step's end, or have gone through it.
bool may_touch(ShapeIn shape, PatchCorners at) {
  vec3 middle = 0.33333334 * (at.end_a.xyz + at.end_b.xyz + at.end_c.xyz);
  float far = at_least(square(at.end_a.xyz - middle), at_least(square(at.end_b.xyz - middle), square(at.end_c.xyz - middle)));
  float way = at_least(square(at.way_a.xyz), at_least(square(at.way_b.xyz), square(at.way_c.xyz)));
  return distance_to(shape, middle).phi <= 1.00001 * (sqrt(far) + sqrt(way));
}

// m^3: the area that a point stands for times its depth; 0 where it does not touch. Of less a float may have no inverse.
float point_load(ShapeIn shape, PatchCorners at, vec3 share, float area) {
  vec3 end = point_end(at, share);
  vec3 way = point_way(at, share);
  bool short_way = 2.0 * sqrt(square(way)) <= shape.thickness;
  if (short_way && distance_to(shape, end).phi >= 0.0) return 0.0;
  vec3 from = end - way;
  float load = area * depth_after(shape, from, end, way, distance_to(shape, from).phi).depth;
  return load > 1e-30 ? load : 0.0;
}

// As face_of of surface_press.cpp.
int face_of(ShapeIn box, vec3 q) {
  vec3 off = abs(q) - box.size;
  int axis = off.x >= off.y && off.x >= off.z ? 0 : off.y >= off.z ? 1 : 2;
  ivec3 beyond = ivec3(greaterThan(off, vec3(0.0)));
  if (beyond.x + beyond.y + beyond.z > 1) return -1;
  return 2 * axis + (q[axis] < 0.0 ? 1 : 0);
}

// Which points of a patch act: SurfacePress::is_before_one_face.
struct ActingPoints {
  ivec4 law;  // rows of patch_points, or 0, 3: of corners in their place; bits of the area of each, m^2
  bool corners;
};

vec3 point_share(ActingPoints points, int row) {
  if (!points.corners) return fetch_load_vec4(patch_points, patch_points_place, row).xyz;
  return vec3(row == 0 ? 1.0 : 0.0, row == 1 ? 1.0 : 0.0, row == 2 ? 1.0 : 0.0);
}

ActingPoints points_of(ShapeIn shape, PatchCorners first, ivec3 who, int patch_row) {
  ActingPoints points;
  points.law = fetch_load_ivec4(patch_laws, patch_laws_place, first_law + patch_row);
  points.corners = false;
  float way = at_least(square(first.way_a.xyz), at_least(square(first.way_b.xyz), square(first.way_c.xyz)));
  bool is_short = way <= 0.2499 * shape.thickness * shape.thickness;
  bool is_box = shape.kind == SHAPE_BOX;
  if (who.x == who.y || !is_short || !(is_box || shape.kind == SHAPE_HALF_SPACE)) return points;
  int before = is_box ? face_of(shape, first.end_a.xyz) : 0;
  points.corners = !is_box || (before >= 0 && before == face_of(shape, first.end_b.xyz) &&
                               before == face_of(shape, first.end_c.xyz));
  if (!points.corners) return points;
  float area = intBitsToFloat(points.law.z);
  points.law = ivec4(0, 3, floatBitsToInt(0.33333334 * float(points.law.y - points.law.x) * area), 0);
  return points;
}

// As patch_load has it.
vec4 load_of_patch(ShapeIn shape, int patch_row) {
  ivec3 who = fetch_load_ivec4(patch_corners, patch_corners_place, patch_row).xyz;
  PatchCorners at = first_corners(who);
  vec4 sum = vec4(0.0);
  if (!may_touch(shape, at)) return sum;
  ActingPoints points = points_of(shape, at, who, patch_row);
  for (int row = points.law.x; row < points.law.y; ++row) {
    vec3 share = point_share(points, row);
    float load = point_load(shape, at, share, intBitsToFloat(points.law.z));
    if (load > 0.0) sum = vec4(sum.xyz + load * share, 1.0);
  }
  return sum;
}

PatchPush push_on_patch(ShapeIn shape, ContactLaw law, int patch_row, float dt) {
  PatchPush pushed = PatchPush(mat3(0.0), mat3(0.0));
  if (!(fetch_load_vec4(patch_load, patch_load_place, patch_row).w > 0.0)) return pushed;
  ivec3 who = fetch_load_ivec4(patch_corners, patch_corners_place, patch_row).xyz;
  PatchCorners first = first_corners(who);
  PatchCorners at = corners_now(who);
  vec3 inverse_masses = vec3(at.end_a.w, at.end_b.w, at.end_c.w);
  vec3 loads = vec3(at.way_a.w, at.way_b.w, at.way_c.w);
  ActingPoints points = points_of(shape, first, who, patch_row);
  for (int row = points.law.x; row < points.law.y; ++row) {
    vec3 share = point_share(points, row);
    float load = point_load(shape, first, share, intBitsToFloat(points.law.z));
    if (!(load > 0.0)) continue;
    vec3 parts = (1.0 / load) * (share * loads);  // into which each corner is split, times its share
    float inverse_mass = inner_product(parts, inverse_masses);
    if (!(inverse_mass > 0.0)) continue;
    ContactLaw own = law;
    own.compliance = law.compliance * (parts.x + parts.y + parts.z);
    vec3 end = point_end(at, share);
    vec3 way = point_way(at, share);
    Touch touch = touch_in_step(shape, own, end - way, end, way, inverse_mass, dt);
    if (!touch.touches) continue;
    vec3 shift = (1.0 / inverse_mass) * touch.shift;
    pushed.impulse = pushed.impulse + mat3(share.x * touch.impulse, share.y * touch.impulse, share.z * touch.impulse);
    pushed.shift = pushed.shift + mat3(share.x * shift, share.y * shift, share.z * shift);
  }
  return pushed;
}
