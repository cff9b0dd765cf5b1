// SPDX-License-Identifier: MIT
#include "instruction_set.h"

#include <phymul/error.h>

#include <cstdlib>
#include <string>

#include "base/compiler.h"

namespace phymul::cpu::simd {

std::vector<const Kernels*> usable_kernels() {
  std::vector<const Kernels*> usable{&portable_kernels};
#if defined(PHYMUL_AVX2_KERNELS)
  if (PHYMUL_PROCESSOR_HAS("avx2") && PHYMUL_PROCESSOR_HAS("fma")) usable.push_back(&avx2_kernels);
#endif
#if defined(PHYMUL_AVX512_KERNELS)
  if (PHYMUL_PROCESSOR_HAS("avx512f") && PHYMUL_PROCESSOR_HAS("avx512dq") && PHYMUL_PROCESSOR_HAS("avx512vl") &&
      PHYMUL_PROCESSOR_HAS("avx512bw")) {
    usable.push_back(&avx512_kernels);
  }
#endif
#if defined(PHYMUL_NEON_KERNELS)
  usable.push_back(&neon_kernels);  // every 64-bit ARM has it
#endif
  return usable;
}

const Kernels& chosen_kernels() {
  const std::vector<const Kernels*> usable = usable_kernels();
  const char* asked = std::getenv("PHYMUL_CPU_ISA");
  if (asked == nullptr || *asked == '\0') return *usable.back();
  std::string names;
  for (const Kernels* kernels : usable) {
    if (std::string(asked) == kernels->name) return *kernels;
    names += (names.empty() ? "" : ", ") + std::string(kernels->name);
  }
  throw Error("PHYMUL_CPU_ISA is \"" + std::string(asked) + "\"; this build on this processor can run: " + names);
}

}  // namespace phymul::cpu::simd
