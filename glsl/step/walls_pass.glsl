// SPDX-License-Identifier: MIT
//
// Per triangle of a wall, the forces on vertices 1 to 5 of its patch, N: rows have the first four, and the fourth
// components of three of them the fifth, so that four rows are enough. Needs tables.glsl and wall.glsl.

RESULT(0, vec4, wall_on_1);
RESULT(1, vec4, wall_on_2);
RESULT(2, vec4, wall_on_3);
RESULT(3, vec4, wall_on_4);

void wall_row(int row) {
  ivec4 first = fetch_ivec4(wall, wall_place, 2 * row);
  ivec4 last = fetch_ivec4(wall, wall_place, 2 * row + 1);
  int law = WALL_TEXELS * row;
  vec4 tangent1 = fetch_vec4(wall_law, wall_law_place, law);
  vec4 tangent2 = fetch_vec4(wall_law, wall_law_place, law + 1);
  vec4 second[3];  // and bending of 11 11, 22 22, 12 12
  for (int ab = 0; ab < 3; ++ab) second[ab] = fetch_vec4(wall_law, wall_law_place, law + 2 + ab);
  vec4 weight[5];  // g_1, g_2, h_11, h_22
  for (int k = 0; k < 5; ++k) weight[k] = fetch_vec4(wall_law, wall_law_place, law + 5 + k);
  vec4 twist = fetch_vec4(wall_law, wall_law_place, law + 10);
  vec4 mixed = fetch_vec4(wall_law, wall_law_place, law + 11);  // h_12 of vertex 5; bending of 22 12, 11 12, 11 22
  float h12[5] = float[5](twist.x, twist.y, twist.z, twist.w, mixed.x);

  vec3 u_0 = displaced(first.x);
  vec3 d[5] = vec3[5](displaced(first.y) - u_0, displaced(first.z) - u_0, displaced(first.w) - u_0,
                      displaced(last.x) - u_0, displaced(last.y) - u_0);
  vec3 H1 = vec3(0.0);
  vec3 H2 = vec3(0.0);
  for (int k = 0; k < 5; ++k) {
    H1 = H1 + weight[k].x * d[k];
    H2 = H2 + weight[k].y * d[k];
  }
  WallFrame now = wall_frame(tangent1.xyz, tangent2.xyz, H1, H2);
  vec3 change = vec3(inner_product(now.turn, second[0].xyz), inner_product(now.turn, second[1].xyz),
                     inner_product(now.turn, second[2].xyz));
  for (int k = 0; k < 5; ++k) {
    change = change + inner_product(now.normal, d[k]) * vec3(weight[k].z, weight[k].w, h12[k]);
  }
  vec3 moment = vec3(second[0].w * change.x + mixed.w * change.y + mixed.z * change.z,
                     mixed.w * change.x + second[1].w * change.y + mixed.y * change.z,
                     mixed.z * change.x + mixed.y * change.y + second[2].w * change.z);
  vec3 by_normal = moment.x * second[0].xyz + moment.y * second[1].xyz + moment.z * second[2].xyz;
  float share[5];
  for (int k = 0; k < 5; ++k) {
    share[k] = inner_product(vec3(weight[k].z, weight[k].w, h12[k]), moment);
    by_normal = by_normal + share[k] * d[k];
  }
  WallStress stress = wall_stress(now, tangent1.xyz, tangent2.xyz, H1, H2, tangent1.w, tangent2.w);
  vec3 P1, P2;
  wall_pulls(now, stress, by_normal, P1, P2);
  vec3 force[5];
  for (int k = 0; k < 5; ++k) force[k] = -(weight[k].x * P1 + weight[k].y * P2 + share[k] * now.normal);
  wall_on_1 = vec4(force[0], force[4].x);
  wall_on_2 = vec4(force[1], force[4].y);
  wall_on_3 = vec4(force[2], force[4].z);
  wall_on_4 = vec4(force[3], 0.0);
}

PASS_MAIN(wall_row)
