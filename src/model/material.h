// SPDX-License-Identifier: MIT
#pragma once

#include <phymul/model.h>

namespace phymul {

/// Throws Error unless the constants lie where the material model can reach them.
void require_in_range(const Material& material);

/// Orders the materials by their first cell, and forgets those that no cell has: setting one again and again does not
/// pile them up.
void drop_unused_materials(Model& model);

}  // namespace phymul
