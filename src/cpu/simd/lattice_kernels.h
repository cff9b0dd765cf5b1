// SPDX-License-Identifier: MIT
//
// The kernels of hexahedra and lattices of boxes, for the instruction set that is being compiled.
#pragma once

#include "grid_rows.h"
#include "hexahedron_terms.h"
#include "star_rows.h"

namespace phymul::cpu::PHYMUL_ISA {

template <bool bounded>
void lattice_terms(const simd::Job& job) {
  if (job.stars.count > 0) star_runs<bounded>(job);
  if (job.boxes.count > 0) box_rows<bounded>(job);
  if (job.grid.count > 0) grid_rows<bounded>(job);
}

template void hexahedron_rows<false>(const simd::Job&);
template void hexahedron_rows<true>(const simd::Job&);
template void lattice_terms<false>(const simd::Job&);
template void lattice_terms<true>(const simd::Job&);

}  // namespace phymul::cpu::PHYMUL_ISA
