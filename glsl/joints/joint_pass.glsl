// SPDX-License-Identifier: MIT
//
// Per spring of the scene's joints, its force in this step. Needs joint_law.glsl.

PASS_MAIN(joint_row)
