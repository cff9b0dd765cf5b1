// SPDX-License-Identifier: MIT
#include <cstdio>

namespace phymul {

int steps_of_all_bodies = 0;

void step() {
  std::fprintf(stderr, "%d steps\n", ++steps_of_all_bodies);
}

}  // namespace phymul
