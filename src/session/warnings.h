// SPDX-License-Identifier: MIT
#pragma once

#include <phymul/scene.h>

#include <string>
#include <vector>

namespace phymul {

/// What a user has probably not meant, a sentence each: no material, quantities in other units than SI, parts that
/// nothing holds. `takes_material`: the law of the body can use one.
std::vector<std::string> warnings_of(const Model& model, const Scene& scene, bool takes_material);

/// Adds a sentence if a tool touches a body with cuts at its particles; adds it only once.
void look_for_tools_beyond_cuts(const Model& model, const Scene& scene, std::vector<std::string>& found);

/// Adds a sentence if bodies that can touch each other overlap at rest: the deepest pair, and by how much.
void look_for_overlaps(const Model& model, const Scene& scene, std::vector<std::string>& found);

}  // namespace phymul
