// SPDX-License-Identifier: MIT
//
// One line longer than
// the limit here.
