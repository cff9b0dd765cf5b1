// SPDX-License-Identifier: MIT
//
// Where a step is open between its forces and its motion: what free_pass.glsl leaves, contacts change or the host is
// asked about, and step_pass.glsl ends. By place, among the rows of the loads.

TABLE_FLOATS(pushed_force, pushed_force_place);    // N, with what pushes over dt; 1 where the elastic part was cut
TABLE_FLOATS(free_velocity, free_velocity_place);  // m/s: it would go to x + dt v; axes on which nothing pushes it
TABLE_FLOATS(pushed_shift, pushed_shift_place);    // m, besides, which is no velocity; 1/m, 1/kg; with HOST_STEP the
                                                   // force withheld, N
