// SPDX-License-Identifier: MIT
//
// What steps have to tell, brought down to two rows a group: events and largest. From what step_pass.glsl wrote, then
// from the groups' rows. Needs tables.glsl and report_events.glsl.

layout(local_size_x = GROUP) in;

TABLE_INTS(order, order_place);  // row of the model of a place
uniform int pair;                // below 0: rows of groups
uniform int source_count, source_place, report_place;

shared ivec4 group_events[GROUP];
shared vec4 group_largest[GROUP];

void add_source(int row, inout ivec4 events, inout vec4 largest) {
  if (pair < 0) {
    merge_events(events, changing_rows[source_place + 2 * row]);
    merge_largest(largest, intBitsToFloat(changing_rows[source_place + 2 * row + 1]));
    return;
  }
  vec4 u = fetch_changing(displacement, displacement_place, row);
  vec4 v = fetch_changing(velocity, velocity_place, row);
  merge_events(events, events_of(u, v, fetch_int(order, order_place, row)));
  merge_largest(largest, fetch_changing(measured, measured_place, row));
}

void main() {
  displacement_place = pair_place(max(pair, 0));
  velocity_place = displacement_place + place_count;
  int lane = int(gl_LocalInvocationID.x);
  ivec4 events = ivec4(never, never, never, 0);
  vec4 largest = vec4(0.0);
  int stride = int(gl_NumWorkGroups.x) * GROUP;
  for (int row = int(gl_WorkGroupID.x) * GROUP + lane; row < source_count; row += stride) {
    add_source(row, events, largest);
  }
  group_events[lane] = events;
  group_largest[lane] = largest;
  for (int half_of = GROUP / 2; half_of > 0; half_of /= 2) {
    memoryBarrierShared();
    barrier();
    if (lane < half_of) {
      merge_events(events, group_events[lane + half_of]);
      merge_largest(largest, group_largest[lane + half_of]);
      group_events[lane] = events;
      group_largest[lane] = largest;
    }
  }
  if (lane > 0) return;
  changing_rows[report_place + 2 * int(gl_WorkGroupID.x)] = events;
  changing_rows[report_place + 2 * int(gl_WorkGroupID.x) + 1] = floatBitsToInt(largest);
}
