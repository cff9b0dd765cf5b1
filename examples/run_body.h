// SPDX-License-Identifier: MIT
//
// The body and the scene that the options of phymul-run describe.
#pragma once

#include <phymul/model.h>
#include <phymul/scene.h>

#include <string>
#include <vector>

#include "run_options.h"

/// The body without the materials and groups of the options. Throws phymul::Error as the readers do.
phymul::Model read_shape(const RunOptions& options);

/// Adds groups and sets materials. Throws phymul::Error for a body without volume cells or an unknown group.
void dress_shape(const RunOptions& options, phymul::Model& model);

/// Along the planes of the options, after all materials are set. Throws phymul::Error that begins with "--cut: ".
phymul::Model cut_along_planes(const RunOptions& options, phymul::Model model);

phymul::Model read_body(const RunOptions& options);  ///< all three

/// Adds what acts on the body. `notes`: what reading the loads found, unless null. Throws phymul::Error.
void fill_scene(const RunOptions& options, const phymul::Model& model, phymul::Scene& scene,
                std::vector<std::string>* notes);
