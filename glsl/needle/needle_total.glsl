// SPDX-License-Identifier: MIT
//
// Of the particles around the place of a node: how many, and their moments. Needs needle_weights.glsl.

STORED(around_0, around_0_place);  // the one row that needle_around_pass.glsl ends with
STORED(around_1, around_1_place);
STORED(around_2, around_2_place);

int total_found() {
  return int(fetch_changing(around_1, around_1_place, 0).w);
}

mat4 total_moments() {
  return moments_of(fetch_changing(around_0, around_0_place, 0), fetch_changing(around_1, around_1_place, 0).xyz,
                    fetch_changing(around_2, around_2_place, 0).xyz);
}
