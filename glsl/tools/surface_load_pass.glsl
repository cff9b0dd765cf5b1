// SPDX-License-Identifier: MIT
//
// Per patch, what its points load its corners with before the first round. Needs surface_law.glsl.

RESULT(0, vec4, load_now);

void load_row(int patch_row) {
  load_now = load_of_patch(tool_shape(acting_tool), patch_row);
}

PASS_MAIN(load_row)
