// SPDX-License-Identifier: MIT
//
// The springs of joints, as in src/device/float_scene.h. Needs tables.glsl.

TABLE_INTS(joint_springs, joint_springs_place);  // first row of anchor a, of anchor b, their end; tool
TABLE_INTS(joint_anchors, joint_anchors_place);  // particle, bits of its weight
TABLE_FLOATS(joint_places, joint_places_place);  // three rows a spring
TABLE_FLOATS(joint_laws, joint_laws_place);      // two: k, c, breaking force, 1: slack; L, |R| - L
