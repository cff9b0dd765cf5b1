// SPDX-License-Identifier: MIT
#pragma once

#include <phymul/scene.h>

#include <string>
#include <vector>

namespace phymul {

/// Adds a sentence if bodies that can touch each other overlap at rest: the deepest pair, and by how much.
void look_for_overlaps(const Model& model, const Scene& scene, std::vector<std::string>& found);

}  // namespace phymul
