// SPDX-License-Identifier: MIT
//
// Sixteen rows to one, added. Needs fetch.glsl.

uniform sampler2D terms;
uniform int terms_log2;
uniform int source_count;

layout(location = 0) out vec4 total;
invariant total;

void main() {
  int row = own_row();
  if (row >= row_count) discard;
  vec4 sum = vec4(0.0);
  int end = min(16 * row + 16, source_count);
  for (int source = 16 * row; source < end; ++source) sum = sum + fetch(terms, terms_log2, source);
  total = sum;
}
