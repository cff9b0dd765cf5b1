// SPDX-License-Identifier: MIT
//
// Of one group, dispatched alone: what others wrote before is there after.

void wait_for_all() {
  memoryBarrierBuffer();
  barrier();
}
