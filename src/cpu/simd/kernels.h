// SPDX-License-Identifier: MIT
//
// The kernels of the instruction set that is being compiled.
#pragma once

#include "averaged_runs.h"
#include "base_terms.h"
#include "enumerated_terms.h"
#include "move.h"
#include "row_terms.h"

namespace phymul::cpu::PHYMUL_ISA {

template <template <bool bounded_volume> class... Each>
constexpr void set_stresses(simd::Kernels& kernels, EnergyList<Each...>) {
  static_assert(sizeof...(Each) <= simd::most_energies);
  int row = 0;
  ((kernels.averaged_stresses[0][row][0] = averaged_stresses<Each<false>>,
    kernels.averaged_stresses[0][row][1] = averaged_stresses<Each<true>>,
    kernels.averaged_stresses[1][row][0] = run_stresses<Each<false>>,
    kernels.averaged_stresses[1][row][1] = run_stresses<Each<true>>,
    kernels.averaged_tangents[0][row][0] = averaged_stresses<TangentOf<Each<false>>>,
    kernels.averaged_tangents[0][row][1] = averaged_stresses<TangentOf<Each<true>>>,
    kernels.averaged_tangents[1][row][0] = run_stresses<TangentOf<Each<false>>>,
    kernels.averaged_tangents[1][row++][1] = run_stresses<TangentOf<Each<true>>>),
   ...);
}

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
      wall_rows,
      spring_slices,
      spread_displacements,
      {},
      {},
      {averaged_stresses<StressNearRest>, run_stresses<StressNearRest>},
      {add_dissipation, run_dissipation},
      {scale_stresses, scale_run_stresses},
      {averaged_forces, run_forces},
      move_slices};
  set_stresses(kernels, Energies{});
  static_assert(StressNearRest::energy_constants == simd::constants_near_rest);
  return kernels;
}

}  // namespace phymul::cpu::PHYMUL_ISA
