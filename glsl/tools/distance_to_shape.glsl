// SPDX-License-Identifier: MIT
//
// Twin of src/interaction/distance_to_shape.h. Needs kernel_language.glsl, and tool_tables.glsl where TOOL_GRIDS is defined.
// SHAPE_SPHERE ... SHAPE_GRID: ShapeKind of src/interaction.

struct ShapeIn {
  int kind;
  vec3 size;
  float margin, thickness;
#ifdef TOOL_GRIDS
  ivec3 count;
  int first_value;
  vec3 origin;
  float spacing;
#endif
};

struct Distance {
  float phi;
  vec3 normal;
};

float at_least(float a, float b) {
  return a < b ? b : a;
}
float at_most(float a, float b) {
  return b < a ? b : a;
}

Distance distance_from_point(vec3 q, float radius) {
  float far = sqrt(inner_product(q, q));
  if (!(far > 0.0)) return Distance(-radius, vec3(0.0, 0.0, 1.0));
  return Distance(far - radius, (1.0 / far) * q);
}

Distance distance_from_box(vec3 q, vec3 half_size) {
  vec3 side = vec3(q.x < 0.0 ? -1.0 : 1.0, q.y < 0.0 ? -1.0 : 1.0, q.z < 0.0 ? -1.0 : 1.0);
  vec3 d = side * q - half_size;
  if (d.x <= 0.0 && d.y <= 0.0 && d.z <= 0.0) {
    if (d.x >= d.y && d.x >= d.z) return Distance(d.x, vec3(side.x, 0.0, 0.0));
    if (d.y >= d.z) return Distance(d.y, vec3(0.0, side.y, 0.0));
    return Distance(d.z, vec3(0.0, 0.0, side.z));
  }
  vec3 beyond = vec3(at_least(d.x, 0.0), at_least(d.y, 0.0), at_least(d.z, 0.0));
  float far = sqrt(inner_product(beyond, beyond));
  return Distance(far, ((1.0 / far) * side) * beyond);
}

#ifdef TOOL_GRIDS
int cell_along(float s, int n) {
  return int(s) < n - 1 ? int(s) : n - 2;
}

float grid_value(ShapeIn shape, ivec3 at) {
  int row = (at.z * shape.count.y + at.y) * shape.count.x + at.x;
  return fetch_load_float(tool_grid, tool_grid_place, shape.first_value + row);
}

Distance distance_in_grid(vec3 q, ShapeIn shape) {
  float inverse = 1.0 / shape.spacing;
  vec3 local = inverse * (q - shape.origin);
  vec3 inside = vec3(at_least(0.0, at_most(local.x, float(shape.count.x - 1))),
                     at_least(0.0, at_most(local.y, float(shape.count.y - 1))),
                     at_least(0.0, at_most(local.z, float(shape.count.z - 1))));
  ivec3 cell = ivec3(cell_along(inside.x, shape.count.x), cell_along(inside.y, shape.count.y),
                     cell_along(inside.z, shape.count.z));
  float x = inside.x - float(cell.x);
  float y = inside.y - float(cell.y);
  float z = inside.z - float(cell.z);
  float v000 = grid_value(shape, cell);
  float v100 = grid_value(shape, cell + ivec3(1, 0, 0));
  float v010 = grid_value(shape, cell + ivec3(0, 1, 0));
  float v110 = grid_value(shape, cell + ivec3(1, 1, 0));
  float v001 = grid_value(shape, cell + ivec3(0, 0, 1));
  float v101 = grid_value(shape, cell + ivec3(1, 0, 1));
  float v011 = grid_value(shape, cell + ivec3(0, 1, 1));
  float v111 = grid_value(shape, cell + ivec3(1, 1, 1));
  float v00 = v000 + x * (v100 - v000);
  float v10 = v010 + x * (v110 - v010);
  float v01 = v001 + x * (v101 - v001);
  float v11 = v011 + x * (v111 - v011);
  float w0 = v00 + y * (v10 - v00);
  float w1 = v01 + y * (v11 - v01);
  float dx0 = (v100 - v000) + y * ((v110 - v010) - (v100 - v000));
  float dx1 = (v101 - v001) + y * ((v111 - v011) - (v101 - v001));
  vec3 slope = vec3(dx0 + z * (dx1 - dx0), (v10 - v00) + z * ((v11 - v01) - (v10 - v00)), w1 - w0);
  float phi = w0 + z * (w1 - w0);
  vec3 way = shape.spacing * (local - inside);
  float beyond = sqrt(inner_product(way, way));
  if (beyond > 0.0) {
    phi = phi + beyond;
    slope = way;
  }
  float steepness = sqrt(inner_product(slope, slope));
  return Distance(phi, steepness > 0.0 ? (1.0 / steepness) * slope : vec3(0.0, 0.0, 1.0));
}
#endif

Distance distance_to(ShapeIn shape, vec3 q) {
  Distance found = Distance(q.z, vec3(0.0, 0.0, 1.0));  // from a half-space
  if (shape.kind == SHAPE_SPHERE) {
    found = distance_from_point(q, shape.size.x);
  } else if (shape.kind == SHAPE_CAPSULE) {
    found = distance_from_point(vec3(q.x, q.y, q.z - at_least(0.0, at_most(q.z, shape.size.y))), shape.size.x);
  } else if (shape.kind == SHAPE_BOX) {
    found = distance_from_box(q, shape.size);
#ifdef TOOL_GRIDS
  } else if (shape.kind == SHAPE_GRID) {
    found = distance_in_grid(q, shape);
#endif
  }
  found.phi = found.phi - shape.margin;
  return found;
}
