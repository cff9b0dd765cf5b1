// SPDX-License-Identifier: MIT
//
// The passes of a tool that touches surfaces, a lane for each row. One of SURFACE_START, SURFACE_LOAD, SURFACE_GATHER,
// SURFACE_PRESS, SURFACE_PUSH and SURFACE_END is defined, and the file surface_..._pass.glsl of that name stands before
// it; but PRESS, whose rows are six, needs surface_law.glsl. END needs tell_tools.glsl. Dispatched only.

layout(local_size_x = GROUP) in;

uniform int pair, number, measuring;
#ifdef SURFACE_END
OF_STEP(int, batch_step);  // counts from 1
#endif

void store_row(int at, vec4 value) {
  load_rows[at] = floatBitsToInt(value);
}

#ifdef SURFACE_PRESS
PRECISE PatchPush pushed_now;

void store_push(int at, mat3 push) {
  for (int corner = 0; corner < 3; ++corner) store_row(patch_push_place + 4 * at + corner, vec4(push[corner], 0.0));
}
#endif

void main() {
  int row = own_group() * GROUP + int(gl_LocalInvocationID.x);
#if defined(SURFACE_LOAD) || defined(SURFACE_PRESS)
  if (row >= patch_count) return;
#else
  if (row >= particle_count) return;
#endif
  displacement_place = pair_place(pair);
  instant = number - 1;
#if defined(SURFACE_START)
  start_row(row);
  store_row(first_end_place + row, end_before);
  store_row(first_way_place + row, way_before);
#elif defined(SURFACE_LOAD)
  load_row(row);
  store_row(patch_load_place + row, load_now);
#elif defined(SURFACE_PRESS)
  pushed_now = push_on_patch(tool_shape(acting_tool), tool_contact(acting_tool, instant), row, dt);
  store_push(row, pushed_now.impulse);
  if (round_shifts != 0) store_push(patch_count + row, pushed_now.shift);
#elif defined(SURFACE_GATHER) || defined(SURFACE_PUSH)
#ifdef SURFACE_GATHER
  gather_row(row);
#else
  push_row(row);
#endif
  store_row(corner_end_place + row, end_now);
  store_row(corner_way_place + row, way_now);
  store_row(corner_given_place + row, given_now);
  store_row(corner_shift_place + row, shift_now);
#else
  if (fetch_load_vec4(tool_held, tool_held_place, row).w >= 0.0) return;  // free_kernel.glsl told of it
  batch_step = number;
  telling_last = measuring != 0;
  end_row(row);
  store_row(pushed_force_place + row, force_after);
  store_row(free_velocity_place + row, velocity_after);
  store_row(pushed_shift_place + row, shift_after);
  Reaction reaction = no_reaction;
  if (force_after.w > 0.0) cut_elastic_force(row);  // for what it withholds
  if (given_by_tool.w > 0.0) {
    TouchedParticle touched = untouched(row, displaced(row), velocity_after.xyz, int(velocity_after.w));
    vec3 force = inverse_dt * given_by_tool.xyz + borne(touched, given_by_tool.xyz);
    reaction = react(tool_frame(acting_tool, instant + 1), touched, force);
  }
  TELL_TOOL(acting_tool, row, reaction);
#endif
}
