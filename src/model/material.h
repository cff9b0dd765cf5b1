// SPDX-License-Identifier: MIT
#pragma once

#include <phymul/model.h>

namespace phymul {

/// Throws Error for constants of dissipation out of their range.
void require_dissipation_in_range(const Material& material);

/// Throws Error unless the constants lie where the material model can reach them, those of dissipation included.
void require_in_range(const Material& material);

/// Orders the materials by their first cell, and forgets those that no cell has: setting one again and again does not
/// pile them up.
void drop_unused_materials(Model& model);

}  // namespace phymul
