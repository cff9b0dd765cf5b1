// SPDX-License-Identifier: MIT
//
// The kernels of the instruction set that is being compiled.
#pragma once

#include "base_terms.h"
#include "enumerated_terms.h"
#include "grid_rows.h"
#include "hexahedron_terms.h"
#include "move.h"
#include "other_terms.h"
#include "simplex_terms.h"
#include "star_rows.h"

namespace phymul::cpu::PHYMUL_ISA {

template <bool bounded>
void lattice_terms(const simd::Job& job) {
  if (job.stars.count > 0) star_runs<bounded>(job);
  if (job.boxes.count > 0) box_rows<bounded>(job);
  if (job.grid.count > 0) grid_rows<bounded>(job);
}

constexpr simd::Kernels all_kernels(const char* name) {
  using enum simd::BaseUse;
  return {name,
          lanes,
          {{{base_slices<conservative, false, false>, base_slices<conservative, false, true>},
            {base_slices<conservative, true, false>, base_slices<conservative, true, true>}},
           {{base_slices<averaged, false, false>, base_slices<averaged, false, true>},
            {base_slices<averaged, true, false>, base_slices<averaged, true, true>}},
           {{base_slices<attractor, false, false>, base_slices<attractor, false, true>},
            {base_slices<attractor, true, false>, base_slices<attractor, true, true>}}},
          {enumerated_slices<false>, enumerated_slices<true>},
          {{volume_rows<false, false>, volume_rows<false, true>}, {volume_rows<true, false>, volume_rows<true, true>}},
          {cell_rows<false>, cell_rows<true>},
          spring_slices,
          {hexahedron_rows<false>, hexahedron_rows<true>},
          {lattice_terms<false>, lattice_terms<true>},
          {simplex_rows<false>, simplex_rows<true>},
          move_slices};
}

}  // namespace phymul::cpu::PHYMUL_ISA
