// SPDX-License-Identifier: MIT
//
// A spring of a joint in one step: its force, and what a tool feels of it about its place at the step's end, summed over
// the steps of a batch. Needs joint_tables.glsl, spring.glsl, joint.glsl; tool_tables.glsl where JOINT_TOOLS is defined.

RESULT(0, vec4, joint_force);       // N, on anchor a; 1: broken from the next step on
RESULT(1, vec4, joint_torque);      // N m, on the tool; length, m
RESULT(2, vec4, joint_force_sum);   // N
RESULT(3, vec4, joint_torque_sum);  // N m

uniform float inverse_dt;    // 1/s
uniform int joint_instant;   // whose places the step starts from; 0: sums begin
uniform int tools_at_once;   // 1: tools are at the step's end already, and have no speed

struct Way {
  vec3 from, speed;
};

// Weighted means of displacements and velocities.
Way mean_way(int first, int end) {
  Way way = Way(vec3(0.0), vec3(0.0));
  for (int row = first; row < end; ++row) {
    ivec4 anchor = fetch_load_ivec4(joint_anchors, joint_anchors_place, row);
    float weight = intBitsToFloat(anchor.y);
    way.from = way.from + weight * displaced(anchor.x);
    way.speed = way.speed + weight * fetch_changing(velocity, velocity_place, anchor.x).xyz;
  }
  return way;
}

#ifdef JOINT_TOOLS
vec4 joint_tool_row(int tool, int row) {
  return fetch_load_vec4(tool_frames, tool_frames_place, TOOL_FRAME_ROWS * (joint_instant * tool_count + tool) + row);
}

struct ToolAnchor {
  vec3 high, low, offset;  // place of the tool; of the anchor from there, m
  vec3 speed, arm;         // m/s; from the tool's place at the step's end, m
};

ToolAnchor tool_anchor(int tool, vec3 point) {
  vec4 x = joint_tool_row(tool, 0), y = joint_tool_row(tool, 1), z = joint_tool_row(tool, 2);
  vec4 dx = joint_tool_row(tool, 4), dy = joint_tool_row(tool, 5), dz = joint_tool_row(tool, 6);
  vec3 gone = vec3(dx.w, dy.w, dz.w);
  vec3 moved = gone + (point.x * dx.xyz + point.y * dy.xyz + point.z * dz.xyz);
  vec3 offset = point.x * x.xyz + point.y * y.xyz + point.z * z.xyz;
  vec3 speed = inverse_dt * moved;
  if (tools_at_once != 0) {
    offset = offset + moved;
    speed = vec3(0.0);
  }
  return ToolAnchor(vec3(x.w, y.w, z.w), joint_tool_row(tool, 3).xyz, offset, speed, offset - gone);
}
#endif

void joint_row(int s) {
  ivec4 ends = fetch_load_ivec4(joint_springs, joint_springs_place, s);
  vec4 law = fetch_load_vec4(joint_laws, joint_laws_place, 2 * s);
  vec2 lengths = fetch_load_vec4(joint_laws, joint_laws_place, 2 * s + 1).xy;
  vec3 R = fetch_load_vec4(joint_places, joint_places_place, 3 * s).xyz;
  Way a = mean_way(ends.x, ends.y);
  Way b = mean_way(ends.y, ends.z);
  vec3 d = b.from - a.from;
  vec3 r = R + d;
  vec3 v = b.speed - a.speed;
#ifdef JOINT_TOOLS
  vec3 arm = vec3(0.0);
  if (ends.w != 0) {  // R is the larger part of where the particles are at rest
    vec3 low = fetch_load_vec4(joint_places, joint_places_place, 3 * s + 1).xyz;
    vec3 point = fetch_load_vec4(joint_places, joint_places_place, 3 * s + 2).xyz;
    ToolAnchor at = tool_anchor(abs(ends.w) - 1, point);
    r = ((at.high - R) + (at.low - low)) + (at.offset - (a.from + b.from));
    v = at.speed - (a.speed + b.speed);
    arm = at.arm;
    if (ends.w < 0) {
      r = -r;
      v = -v;
    }
  }
#endif
#if DIMENSION == 2
  r.z = 0.0;
  v.z = 0.0;
#endif
  float length_now = sqrt(inner_product(r, r));
  float stretch = spring_stretch(R, d, r, length_now) + lengths.y;
#ifdef JOINT_TOOLS
  if (ends.w != 0) stretch = length_now - lengths.x;
#endif
  bool broken = fetch_load_layer(joint_state, joint_state_place, s, 0).w > 0.0;
  bool pulls = !broken;
#ifdef JOINT_TOOLS
  if (ends.w != 0 && joint_tool_row(abs(ends.w) - 1, 3).w < 0.0) pulls = false;
#endif
  vec3 f = vec3(0.0);
  if (pulls) f = joint_pull(r, v, length_now, stretch, law.x, law.y, lengths.x == 0.0, law.w > 0.0);
  bool breaks = inner_product(f, f) > law.z * law.z;
  joint_force = vec4(f, broken || breaks ? 1.0 : 0.0);
  vec3 torque = vec3(0.0);
#ifdef JOINT_TOOLS
  if (ends.w != 0) torque = cross_product(arm, ends.w > 0 ? -f : f);
#endif
  joint_torque = vec4(torque, length_now);
  joint_force_sum = vec4(f, 0.0);
  joint_torque_sum = vec4(torque, 0.0);
  if (joint_instant == 0) return;
  joint_force_sum = joint_force_sum + fetch_load_layer(joint_state, joint_state_place, s, 2);
  joint_torque_sum = joint_torque_sum + fetch_load_layer(joint_state, joint_state_place, s, 3);
}
