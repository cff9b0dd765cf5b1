// SPDX-License-Identifier: MIT
//
// The kernels of the instruction set that is being compiled.
#pragma once

#include "averaged_terms.h"
#include "base_terms.h"
#include "enumerated_terms.h"
#include "move.h"
#include "spring_terms.h"
#include "volume_terms.h"

namespace phymul::cpu::PHYMUL_ISA {

constexpr simd::Kernels all_kernels(const char* name) {
  using enum simd::BaseUse;
  simd::Kernels kernels{
      name,
      lanes,
      {{base_slices<conservative, false>, base_slices<conservative, true>},
       {base_slices<averaged, false>, base_slices<averaged, true>},
       {base_slices<attractor, false>, base_slices<attractor, true>}},
      {enumerated_slices<false>, enumerated_slices<true>},
      {{volume_rows<false, false>, volume_rows<false, true>}, {volume_rows<true, false>, volume_rows<true, true>}},
      spring_slices,
      {},
      averaged_forces,
      move_slices};
  set_stresses(kernels, Energies{});
  return kernels;
}

}  // namespace phymul::cpu::PHYMUL_ISA
