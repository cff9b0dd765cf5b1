// SPDX-License-Identifier: MIT
//
// The kernels of the instruction set that is being compiled: all but those of lattice_kernels.h, which a file of their
// own compiles, since each half takes a compiler long.
#pragma once

#include "averaged_terms.h"
#include "base_terms.h"
#include "cell_terms.h"
#include "enumerated_terms.h"
#include "move.h"
#include "simplex_terms.h"
#include "spring_terms.h"
#include "volume_terms.h"

namespace phymul::cpu::PHYMUL_ISA {

// See lattice_kernels.h.
template <bool bounded>
void hexahedron_rows(const simd::Job& job);
template <bool bounded>
void lattice_terms(const simd::Job& job);

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
          {averaged_stresses<false>, averaged_stresses<true>},
          averaged_forces,
          move_slices};
}

}  // namespace phymul::cpu::PHYMUL_ISA
