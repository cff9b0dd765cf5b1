// SPDX-License-Identifier: MIT
//
// What the host adds to an open step (src/gl/solver/device_solver.h): a row for each particle that something pushes, by
// ascending rows of particles.

TABLE_INTS(push_rows, push_rows_place);        // of the particle
TABLE_FLOATS(push_forces, push_forces_place);  // N, over this step
TABLE_FLOATS(push_shifts, push_shifts_place);  // m, besides, which is no velocity
uniform int push_count;

// -1: nothing pushes particle i.
int push_row(int i) {
  int low = 0;
  int high = push_count;
  while (low < high) {
    int middle = (low + high) / 2;
    if (fetch_load_ivec4(push_rows, push_rows_place, middle).x < i) {
      low = middle + 1;
    } else {
      high = middle;
    }
  }
  if (low >= push_count) return -1;
  return fetch_load_ivec4(push_rows, push_rows_place, low).x == i ? low : -1;
}
