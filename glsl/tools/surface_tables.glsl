// SPDX-License-Identifier: MIT
//
// Where tools with ToolContact::surface touch, as in src/device/float_surfaces.h, and what passes of a step write of one
// such tool. Rows by patch are triangles, or particles of bodies that have none. Needs tables.glsl.

TABLE_INTS(patch_corners, patch_corners_place);  // rows of particles
TABLE_INTS(patch_laws, patch_laws_place);        // of a tool and patch: first and end row of its points; bits of the
                                                 // area that each stands for, m^2
TABLE_FLOATS(patch_points, patch_points_place);  // shares of the corners
TABLE_INTS(patch_ranges, patch_ranges_place);    // of a particle: first and end row of patch_around
TABLE_INTS(patch_around, patch_around_place);    // patch, which corner of it

// By particle, in the tool's frame. Of the round to come, but for the first two; those of before a patch's first round
// say which of its points are pressed.
STORED(first_end, first_end_place);      // where it would be at the step's end, m; 1/m, 1/kg, 0 where it is imposed or held
STORED(first_way, first_way_place);      // its way there, m
STORED(corner_end, corner_end_place);    // likewise, with what past rounds gave
STORED(corner_way, corner_way_place);    // likewise; sum over the points that touch of share times load, m^3
STORED(corner_given, corner_given_place);  // N s in the world, of all rounds
STORED(corner_shift, corner_shift_place);  // m in the world, likewise

STORED(patch_load, patch_load_place);         // m^3 by corner: share times load of its points; 1 where any is pressed
STORED_LAYERS(patch_push, patch_push_place);  // by corner, of a round: N s; patch_count rows on: kg m, besides

uniform int acting_tool;
uniform int patch_count;
uniform int first_law;     // of the tool, in patch_laws
uniform int round_shifts;  // 0: rounds give no kg m, and nobody wrote them
