// SPDX-License-Identifier: MIT
//
// The body of a picture with cairo: no GPU, no driver.
#pragma once

#include <cairo.h>

#include "picture.h"

/// Surface of the body at a state in width x height pixels from the canvas' origin: faces coloured by displacement and
/// shaded by a light, the rest shape as an outline. For cameras with parallel rays.
void paint_body(cairo_t* canvas, const phymul::Model& model, const phymul::State& state, const phymul::Camera& camera,
                const PictureOptions& options, int width, int height);
