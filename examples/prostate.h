// SPDX-License-Identifier: MIT
//
// A gland of 50 x 30 x 40 mm in soft tissue, as probe_on_prostate presses and pierces it. Axes: x to the patient's
// left, y to the front, z to the feet: a probe in the rectum presses along +y, needles from the perineum go along -z.
#pragma once

#include <phymul/phymul.h>

#include "ellipsoid_body.h"
#include "example_run.h"

struct Prostate {
  explicit Prostate(bool quick);

  EllipsoidShape shape;
  phymul::Model model;
  std::vector<phymul::Index> held;  ///< the outer side where it lies on bone and pelvic wall: in front, and above

  /// The cells on one side of a plane of symmetry of the lattice, which the shell's shift bends.
  std::vector<char> half(const phymul::Vec3& normal) const;
  phymul::Simulation simulation() const;  ///< of this model, held where it is
};

/// A probe presses on the gland through the tissue behind it and goes back.
void press_with_probe(const Prostate& prostate, const ExampleOptions& options);
/// Three needles, each to its own target, in three orders.
void insert_in_orders(const Prostate& prostate, const ExampleOptions& options);
