// SPDX-License-Identifier: MIT
//
// The tools of a scene, as in src/device/float_tools.h, which TOOL_LAW_ROWS, TOOL_FRAME_ROWS and TOOL_GRID_UNIT are
// from. Needs tables.glsl.

TABLE_FLOATS(tool_laws, tool_laws_place);  // of a tool: size, kind; margin, thickness, friction, compliance;
                                           // of a grid: origin, spacing; corners along x, y, z, first value / unit
TABLE_FLOATS(tool_frames, tool_frames_place);  // of a tool and instant: axes and the larger part of its place;
                                               // the smaller part, 1 where it was put there, -1: nothing pulls it;
                                               // what axes and place gain up to the next instant
TABLE_FLOATS(tool_rest, tool_rest_place);  // two rows a particle: X_i from the middle, m, as a sum
TABLE_FLOATS(tool_held, tool_held_place);  // place in the frame of the tool that holds it, that tool; -1: none
#ifdef TOOL_GRIDS
TABLE_FLOATS(tool_grid, tool_grid_place);  // m
#endif
uniform int tool_count;
