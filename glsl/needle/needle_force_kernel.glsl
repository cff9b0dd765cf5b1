// SPDX-License-Identifier: MIT
//
// What a needle does to the particles around it in one step, and they to its hub: NeedlePath::act of src/cpu, by one
// group. Needs needle_nodes.glsl and needle_settle.glsl.

layout(local_size_x = GROUP) in;

uniform int tool_sums_place;

vec4 hub_force, hub_torque;  // of the lane's particles, N and N m; w: how many

// Of an impulse on particle i, N s; `felt` by the hub.
void push(int i, vec3 impulse, vec3 felt) {
  vec4 motion = fetch_load_vec4(free_velocity, free_velocity_place, i);
  vec4 force = fetch_load_vec4(pushed_force, pushed_force_place, i);
  float ease = fetch_load_vec4(pushed_shift, pushed_shift_place, i).w;
  load_rows[free_velocity_place + i] = floatBitsToInt(vec4(motion.xyz + ease * impulse, motion.w));
  load_rows[pushed_force_place + i] = floatBitsToInt(vec4(force.xyz + inverse_dt * impulse, force.w));
  vec3 reaction = -inverse_dt * felt;
  hub_force = hub_force + vec4(reaction, 0.0);
  hub_torque = hub_torque + vec4(cross_product(place_of(i) - gone, reaction), 0.0);
}

vec3 taken(int i, vec3 impulse) {
  int axes = int(fetch_load_vec4(free_velocity, free_velocity_place, i).w);
  return vec3((axes & 1) != 0 ? 0.0 : impulse.x, (axes & 2) != 0 ? 0.0 : impulse.y, (axes & 4) != 0 ? 0.0 : impulse.z);
}

// The part of friction around a shaft that turns: a torque on the particles around the node.
void twist(int lane, int k) {
  if (!on_shaft(k) || node_limit[k] == 0.0) return;
  int end = around(k);
  vec4 sum = vec4(0.0);  // way that the node moves along the axis, moment of inertia
  for (int j = lane; j < end; j += GROUP) {
    int i = particle_of(k, j);
    vec3 arm = across(place_of(i) - gone);
    sum += weight_of(k, j) * vec4(inner_product(end_axis, dt * motion_of(i)), inner_product(arm, arm), 0.0, 0.0);
  }
  sum = sum_of_lanes(lane, sum);
  float slide = sum.x - inner_product(end_axis, gone) + inner_product(gain, node_place[k].xyz);
  float all = sqrt(slide * slide + turned * turned);
  if (sum.y > 0.1 * needle_radius * needle_radius) {
    float torque = node_limit[k] * needle_radius * (turned / all);
    for (int j = lane; j < end; j += GROUP) {
      int i = particle_of(k, j);
      if (is_held(i)) continue;
      vec3 around_axis = cross_product(end_axis, across(place_of(i) - gone));
      vec3 impulse = taken(i, (torque * (1.0 / sum.y) * weight_of(k, j)) * around_axis);
      push(i, impulse, impulse);
    }
  }
  if (lane == k) own_limit *= abs(slide) / all;
  wait_for_group();
}

void give_particles(int lane) {
  wait_for_group();
  if (lane < node_count) {
    vec3 along = (own_rubbed - own_pushed) * end_axis;
    node_motion[lane] = vec4(own_side + along, on_shaft(lane) || own_pushed > 0.0 ? 1.0 : 0.0);
  }
  wait_for_group();
  for (int k = 0; k < node_count; ++k) {
    int end = around(k);
    vec4 impulse = node_motion[k];
    if (lane == 0 && impulse.w > 0.0) hub_force.w += float(end);
    for (int j = lane; j < end; j += GROUP) {
      int i = particle_of(k, j);
      if (is_held(i)) continue;
      vec3 share = weight_of(k, j) * impulse.xyz;
      push(i, taken(i, share), share);
    }
    wait_for_group();
  }
}

void act(int lane) {
  for (int pass = 0; pass < 2; ++pass) {
    gather(lane);
    if (pass > 0) break;
    begin_limits(lane);
    if (turned == 0.0) break;
    for (int k = 0; k < node_count; ++k) twist(lane, k);
  }
  settle(lane);
  give_particles(lane);
#ifdef BENDING
  if (bending_stiffness > 0.0) shaft_loads = store_loads();
#endif
  if (lane < node_count) {
    needle_words[node_words(lane) + 1] = own_limit > 0.0 && abs(own_rubbed) >= own_limit ? 1 : 0;
  }
}

// Rows of the first place, which is all that tool_sums_kernel.glsl finds of a needle.
void tell(vec4 force, vec4 torque) {
  int at = tool_sums_place + 4 * needle_tool * place_count;
  vec4 sum = vec4(force.xyz, 0.0);
  vec4 turning = vec4(torque.xyz, 0.0);
  if (number > 1) {
    sum = intBitsToFloat(load_rows[at]) + sum;
    turning = intBitsToFloat(load_rows[at + 1]) + turning;
  }
  load_rows[at] = floatBitsToInt(sum);
  load_rows[at + 1] = floatBitsToInt(turning);
  load_rows[at + 2] = floatBitsToInt(force);
  load_rows[at + 3] = floatBitsToInt(torque);
}

void main() {
  int lane = int(gl_LocalInvocationID.x);
  begin_needle();
  begin_motion();
  hub_force = vec4(0.0);
  hub_torque = vec4(0.0);
  shaft_loads = 0;
  wait_for_group();
  if (node_count > 0) {
    act(lane);
    hub_force = sum_of_lanes(lane, hub_force);
    hub_torque = sum_of_lanes(lane, hub_torque);
  }
  if (lane > 0) return;
  needle_words[state_place + HEADER_LOADS] = shaft_loads;
  tell(hub_force, hub_torque);
}
