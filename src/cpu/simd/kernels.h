// SPDX-License-Identifier: MIT
//
// The kernels of the instruction set that is being compiled.
#pragma once

#include "base_terms.h"
#include "enumerated_terms.h"
#include "hexahedron_terms.h"
#include "move.h"
#include "other_terms.h"
#include "simplex_terms.h"
#include "star_terms.h"

namespace phymul::cpu::PHYMUL_ISA {

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
          {star_runs<false>, star_runs<true>},
          {box_rows<false>, box_rows<true>},
          {simplex_rows<false>, simplex_rows<true>},
          move_slices};
}

}  // namespace phymul::cpu::PHYMUL_ISA
