// SPDX-License-Identifier: MIT
//
// What the particles do to the tools in a step, a row for each tool and particle, added up over the steps of a batch:
// what step_pass.glsl has in hand when tools have touched a particle, and has no place to tell. Drawn only, after
// reaction_pass.glsl; needs free_step.glsl and touch_tools.glsl.

STORED_LAYERS(net, net_place);
STORED(tool_forces, tool_forces_place);    // the sums so far
STORED(tool_torques, tool_torques_place);
OF_STEP(int, batch_step);  // counts from 1
uniform int particle_rows;

RESULT(0, vec4, force_sum);
RESULT(1, vec4, torque_sum);
RESULT(2, vec4, last_force);  // w: 1 where it touched
RESULT(3, vec4, last_torque);

void tool_row(int row) {
  int told = row / particle_rows;
  int i = row - told * particle_rows;
  vec3 u = fetch_changing(displacement, displacement_place, i).xyz;
  vec3 v = fetch_changing(velocity, velocity_place, i).xyz;
  vec3 moved = u;
  float inverse_mass = fetch_vec4(particle, particle_place, i).x;
  vec3 F = fetch_layer(net, net_place, i, 0).xyz;
  withheld = fetch_layer(net, net_place, i, 1).xyz;
  free_step(i, acceleration(F, inverse_mass, gravity), moved, v);
  TouchedParticle touched = untouched(i, u, v, fixed_axes(i));
  vec4 held = fetch_load_vec4(tool_held, tool_held_place, i);
  Reaction reaction = no_reaction;
  for (int tool = 0; tool <= told; ++tool) reaction = touch_tool(tool, held, instant, touched, dt, inverse_dt);
  last_force = vec4(reaction.force, reaction.touches ? 1.0 : 0.0);
  last_torque = vec4(reaction.torque, 0.0);
  force_sum = last_force;
  torque_sum = last_torque;
  if (batch_step == 1) return;
  force_sum = fetch_changing(tool_forces, tool_forces_place, row) + last_force;
  torque_sum = fetch_changing(tool_torques, tool_torques_place, row) + last_torque;
}

PASS_MAIN(tool_row)
