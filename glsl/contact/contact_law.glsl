// SPDX-License-Identifier: MIT
//
// What a contact does: press() and part() of BodyContacts in src/interaction. Needs kernel_language.glsl.

uniform float friction, inverse_dt;
uniform float parted_share, largest_parting;  // of an overlap; of an edge
uniform float least_mobility;                 // of ContactSurface

struct Meeting {  // of a particle and the corners of a triangle
  mat4x3 v, open;  // m/s; 1 along axes that take pushes
  mat4x3 given;    // N s
  vec4 ease;       // 1/kg
  vec4 weight;     // 1, and what the corners have of the nearest point, negative
};

vec3 open_axes(float w) {
  int axes = int(w);
  return vec3((axes & 1) != 0 ? 0.0 : 1.0, (axes & 2) != 0 ? 0.0 : 1.0, (axes & 4) != 0 ? 0.0 : 1.0);
}

// 1/kg, of the relative velocity along a unit direction.
float mobility(Meeting m, vec3 along) {
  vec3 q = along * along;
  vec4 open = vec4(inner_product(q, m.open[0]), inner_product(q, m.open[1]), inner_product(q, m.open[2]),
                   inner_product(q, m.open[3]));
  vec4 each = m.weight * m.weight * m.ease * open;
  return each.x + each.y + each.z + each.w;
}

vec3 relative(Meeting m) {
  return m.v[0] + m.weight.y * m.v[1] + m.weight.z * m.v[2] + m.weight.w * m.v[3];
}

void give(inout Meeting m, vec3 impulse) {
  mat4x3 taken = mat4x3(m.open[0] * impulse, m.weight.y * m.open[1] * impulse, m.weight.z * m.open[2] * impulse,
                        m.weight.w * m.open[3] * impulse);
  m.given = m.given + taken;
  m.v[0] = m.v[0] + m.ease.x * taken[0];
  m.v[1] = m.v[1] + m.ease.y * taken[1];
  m.v[2] = m.v[2] + m.ease.z * taken[2];
  m.v[3] = m.v[3] + m.ease.w * taken[3];
}

// `done`: N s so far, across the normal and along it. False where nothing changes.
bool push_apart(inout Meeting m, vec3 normal, float gap, inout vec4 done) {
  float along_normal = mobility(m, normal);
  vec4 unbound = m.weight * m.weight * m.ease;
  if (along_normal <= least_mobility * (unbound.x + unbound.y + unbound.z + unbound.w)) return false;
  float lacking = -max(gap, 0.0) * inverse_dt - inner_product(normal, relative(m));
  float pressed = max(done.w + lacking / along_normal, 0.0);
  if (pressed == 0.0 && done == vec4(0.0)) return false;
  give(m, (pressed - done.w) * normal);
  done.w = pressed;
  if (friction == 0.0) return true;
  vec3 after = relative(m);
  vec3 sliding = after - inner_product(normal, after) * normal;
  float speed = sqrt(inner_product(sliding, sliding));
  vec3 rubbed = done.xyz;
  if (speed > 0.0) {
    float ease = mobility(m, sliding * (1.0 / speed));
    if (ease > 0.0) rubbed = rubbed - sliding * (1.0 / ease);
  }
  float most = friction * pressed;
  float size = sqrt(inner_product(rubbed, rubbed));
  if (size > most) rubbed = rubbed * (most / size);
  give(m, rubbed - done.xyz);
  done.xyz = rubbed;
  return true;
}

// 1/kg, of a particle along the normal; ease: 1/kg.
float eased(float axes, float ease, float share, vec3 normal) {
  return share * share * ease * inner_product(open_axes(axes), normal * normal);
}

// The way by which an overlap parts in a step, over what those that meet have of eased() together, m kg.
float parting(float gap, float edge, float eased_together) {
  return min(-parted_share * gap, largest_parting * edge) / eased_together;
}
