// SPDX-License-Identifier: MIT
//
// Twin of src/interaction/contact_tool.h. Needs kernel_language.glsl and distance_to_shape.glsl.

struct ContactLaw {
  float friction, compliance;
  bool placed;
};

struct Touch {
  bool touches;
  vec3 impulse, shift;
};

struct Depth {
  float depth;
  vec3 normal;
};

bool first_hit(ShapeIn shape, vec3 q0, vec3 way, float far, out float share) {
  share = 0.0;
  for (int k = 0; k < 64; ++k) {
    float phi = distance_to(shape, q0 + share * way).phi;
    if (phi <= 1e-6 * far) return true;
    share = share + quotient(phi, far);
    if (share >= 1.0) return false;
  }
  return true;
}

Depth depth_after(ShapeIn shape, vec3 q0, vec3 q1, vec3 way, float phi0) {
  Distance end = distance_to(shape, q1);
  Depth nearest = Depth(-end.phi, end.normal);
  float far = sqrt(inner_product(way, way));
  if (far <= 0.5 * shape.thickness || phi0 > far) return nearest;
  float share;
  if (!first_hit(shape, q0, way, far, share)) return nearest;
  vec3 at = q0 + share * way;
  vec3 normal = distance_to(shape, at).normal;
  float past = inner_product(at - q1, normal);
  if (past <= 0.0) return nearest;
  vec3 beyond = past * normal;
  Distance left = distance_to(shape, q1 + beyond);
  if (left.phi < 0.0) beyond = beyond - left.phi * left.normal;
  float depth = sqrt(inner_product(beyond, beyond));
  return Depth(depth, (1.0 / depth) * beyond);
}

Touch touch_in_step(ShapeIn shape, ContactLaw law, vec3 q0, vec3 q1, vec3 way, float inverse_mass, float dt) {
  float phi0 = distance_to(shape, q0).phi;
  Depth found = depth_after(shape, q0, q1, way, phi0);
  if (!(found.depth > 0.0)) return Touch(false, vec3(0.0), vec3(0.0));
  float before = 0.0;
  if (law.placed && law.compliance == 0.0 && phi0 < 0.0) before = -phi0 < found.depth ? -phi0 : found.depth;
  float normal_impulse = quotient((found.depth - before) * dt, law.compliance + dt * dt * inverse_mass);
  Touch touch = Touch(true, normal_impulse * found.normal, before * found.normal);
  if (law.friction == 0.0) return touch;
  vec3 slide = way - inner_product(way, found.normal) * found.normal;
  float far = sqrt(inner_product(slide, slide));
  float to_stop = quotient(far, dt * inverse_mass);
  float most = law.friction * normal_impulse;
  if (to_stop <= most) {
    touch.impulse = touch.impulse - (1.0 / (dt * inverse_mass)) * slide;
  } else {
    touch.impulse = touch.impulse - quotient(most, far) * slide;
  }
  return touch;
}
