// SPDX-License-Identifier: MIT
//
// Draws a body to a PNG file with cairo, for reports and first looks; no GPU, no window.
#pragma once

#include <phymul/model.h>
#include <phymul/state.h>

#include <cstdint>
#include <string>
#include <vector>

struct PictureOptions {
  std::string title;
  std::string subtitle;
  std::vector<phymul::Index> fixed;   ///< particles to mark as held
  std::vector<phymul::Index> driven;  ///< particles to mark as moved by hand
  double full_scale = 0.0;            ///< displacement at the end of the colour scale, m; 0: the state's largest
  /// States that must fit in, too: pictures drawn with the same `frame` can be laid over each other.
  phymul::VecList frame;
  phymul::Vec3 eye{0.75, -1.0, 0.45};  ///< direction from the body to the eye; 2-D bodies are seen along -z
  int width = 900;                     ///< pixels
  int height = 1000;
};

/// Surface of the body at a state: faces coloured by displacement and shaded by a light, the rest shape as an outline.
/// Throws phymul::Error when the file cannot be written.
void draw_picture(const phymul::Model& model, const phymul::State& state, const PictureOptions& options,
                  const std::string& path);
