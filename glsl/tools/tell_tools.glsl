// SPDX-License-Identifier: MIT
//
// What a particle does to a tool, added up over the steps of a batch: four rows of loads for each tool and place, sum of
// forces and of torques, and both in the last step, w of that force 1 where it touched. No other invocation reads or
// writes them meanwhile. Dispatched only; needs touch_tools.glsl.

uniform int tool_sums_place;

bool telling_last;

PRECISE vec4 told_force;
PRECISE vec4 told_torque;

void tell_tool(int tool, int i, Reaction reaction, bool first) {
  int at = tool_sums_place + 4 * (tool * place_count + i);
  if (reaction.touches || first) {
    told_force = vec4(reaction.force, 0.0);
    told_torque = vec4(reaction.torque, 0.0);
    if (!first) {
      told_force = intBitsToFloat(load_rows[at]) + told_force;
      told_torque = intBitsToFloat(load_rows[at + 1]) + told_torque;
    }
    load_rows[at] = floatBitsToInt(told_force);
    load_rows[at + 1] = floatBitsToInt(told_torque);
  }
  if (!telling_last) return;
  told_force = vec4(reaction.force, reaction.touches ? 1.0 : 0.0);
  told_torque = vec4(reaction.torque, 0.0);
  load_rows[at + 2] = floatBitsToInt(told_force);
  load_rows[at + 3] = floatBitsToInt(told_torque);
}

#define TELL_TOOL(tool, i, reaction) tell_tool(tool, i, reaction, batch_step == 1)
