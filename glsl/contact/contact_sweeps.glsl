// SPDX-License-Identifier: MIT
//
// What the phases of the sweeps go through, a row for each particle of a surface and, behind them, for each meeting.
// Needs contact_surfaces.glsl.

STORED(pressing, pressing_place);  // m/s, with the impulses so far, axes that take none; of a meeting: N s so far across
                                   // the normal, along it
STORED(pushing, pushing_place);    // N s, sum of the impulses; most phases that a step of the batch has taken
TABLE_INTS(turns, turns_place);    // entry of the contact whose turn it is (-1: of none any more, -2: it takes no pushes
                                   // and nobody waits for it); sweeps done; first entry; first step of the batch that was
                                   // not done when the next one began, 0: none

const int done_with = -1;
const int unmoved = -2;
