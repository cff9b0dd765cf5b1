// SPDX-License-Identifier: MIT
#pragma once

#include <phymul/scene.h>

#include <string>
#include <vector>

namespace phymul {

/// What a user has probably not meant, a sentence each: no material, quantities in other units than SI, parts that
/// nothing holds.
std::vector<std::string> warnings_of(const Model& model, const Scene& scene);

}  // namespace phymul
