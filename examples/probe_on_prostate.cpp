// SPDX-License-Identifier: MIT
//
// probe_on_prostate [--out DIR] [--quick]: a stiff gland in soft tissue. A probe presses it from behind; then three
// needles go to three targets in it, in three orders. Writes forces, how far the gland and the targets moved, and
// pictures of the body cut open.
#include "prostate.h"

int main(int argc, char** argv) {
  return run_example(argc, argv, "A probe and three needles in a prostate: forces as CSV, and pictures.",
                     [](const ExampleOptions& options) {
                       const Prostate prostate(options.quick);
                       std::printf("%d particles\n", prostate.model.particle_count());
                       press_with_probe(prostate, options);
                       insert_in_orders(prostate, options);
                     });
}
