// SPDX-License-Identifier: MIT
//
// Twin of src/base/vector3.h. Written out, because the order in which dot() and length() add is the driver's.

float inner_product(vec3 a, vec3 b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}

vec3 cross_product(vec3 a, vec3 b) {
  return vec3(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}
