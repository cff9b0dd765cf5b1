// SPDX-License-Identifier: MIT
//
// The kernels of the instruction set that is being compiled.
#pragma once

#include "averaged_runs.h"
#include "base_terms.h"
#include "enumerated_terms.h"
#include "move.h"
#include "spring_terms.h"
#include "volume_terms.h"

namespace phymul::cpu::PHYMUL_ISA {

constexpr simd::Kernels all_kernels(const char* name) {
  using enum simd::BaseUse;
  return {name,
          lanes,
          {{base_slices<conservative, false>, base_slices<conservative, true>},
           {base_slices<averaged, false>, base_slices<averaged, true>},
           {base_slices<attractor, false>, base_slices<attractor, true>}},
          {enumerated_slices<false>, enumerated_slices<true>},
          {{volume_rows<false, false>, volume_rows<false, true>}, {volume_rows<true, false>, volume_rows<true, true>}},
          spring_slices,
          spread_displacements,
          {{{averaged_stresses<ShapeMemory<false>>, averaged_stresses<ShapeMemory<true>>},
            {averaged_stresses<NeoHookean<false>>, averaged_stresses<NeoHookean<true>>}},
           {{run_stresses<ShapeMemory<false>>, run_stresses<ShapeMemory<true>>},
            {run_stresses<NeoHookean<false>>, run_stresses<NeoHookean<true>>}}},
          {averaged_forces, run_forces},
          move_slices};
}

}  // namespace phymul::cpu::PHYMUL_ISA
