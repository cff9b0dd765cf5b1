// SPDX-License-Identifier: MIT
//
// Per particle, the net force, N: the third of the thesis' four passes. Needs net_force.glsl.

layout(location = 0) out vec4 net;
invariant net;

void main() {
  int i = own_row();
  if (i >= row_count) discard;
  net = net_force(i);
}
