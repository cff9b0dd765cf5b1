// SPDX-License-Identifier: MIT
#pragma once

#include <phymul/model.h>

namespace phymul {

/// Throws Error unless the constants lie where the material model can reach them.
void require_in_range(const Material& material);

}  // namespace phymul
