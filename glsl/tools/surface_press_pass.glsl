// SPDX-License-Identifier: MIT
//
// What a round gives the corners of a patch. The first patch_count rows are impulses, the next ones shifts. Drawn only;
// needs surface_law.glsl.

RESULT(0, vec4, push_a);
RESULT(1, vec4, push_b);
RESULT(2, vec4, push_c);

void press_row(int row) {
  bool shifts = row >= patch_count;
  PatchPush push = push_on_patch(tool_shape(acting_tool), tool_contact(acting_tool, instant),
                                 shifts ? row - patch_count : row, dt);
  push_a = vec4(shifts ? push.shift[0] : push.impulse[0], 0.0);
  push_b = vec4(shifts ? push.shift[1] : push.impulse[1], 0.0);
  push_c = vec4(shifts ? push.shift[2] : push.impulse[2], 0.0);
}

PASS_MAIN(press_row)
