// SPDX-License-Identifier: MIT
//
// Pictures in PNG files: a body, whole, cut open or transparent, and the tools in it, with a title, scales and a key.
// Drawn by the processor (raster.h), so that they are the same on every machine.
#pragma once

#include <phymul/model.h>
#include <phymul/solver.h>

#include <string>
#include <vector>

#include "body_surface.h"
#include "picture_legend.h"

inline constexpr phymul::Colour needle_colour{0.36, 0.40, 0.44, 1.0};
inline constexpr phymul::Colour probe_colour{0.93, 0.70, 0.30, 1.0};
inline constexpr phymul::Colour target_colour{0.84, 0.15, 0.16, 1.0};
inline constexpr phymul::Colour planned_colour{0.10, 0.50, 0.25, 1.0};
inline constexpr phymul::Colour organ_colour{0.75, 0.25, 0.10, 1.0};

struct PictureTool {
  phymul::ToolShape shape;
  phymul::ToolPose pose;
  phymul::Colour colour;
  std::string words;  ///< in the key; empty: not there
};

/// A point to see through everything: a ball, or a cross of lines.
struct PicturePoint {
  phymul::Vec3 place;  ///< m
  phymul::Colour colour;
  bool cross = false;
};

struct ScenePictureOptions {
  std::string title, subtitle;
  double full_scale = 0.0;  ///< displacement at the end of the colour scale, m; 0: the largest of the state
  /// What must fit in; empty: rest shape and state. Pictures with the same frame can be laid over each other.
  phymul::VecList frame{};
  phymul::Vec3 eye{0.5, -1.0, 0.4};             ///< direction from the body to the eye; 2-D bodies are seen along -z
  std::vector<phymul::Index> held{}, driven{};  ///< particles to mark
  bool mesh = true;                             ///< edges of the surface's faces
  bool inside = false;           ///< a transparent surface; particles are balls, links between neighbours rods
  phymul::VecList attractors{};  ///< [N] or empty, with `inside` only: the place that each particle is drawn to
  std::vector<PictureTool> tools{};
  std::vector<PicturePoint> points{};
  std::vector<KeyEntry> key{};  ///< what the points and the outline mean
  int width = 720, height = 560;
};

class ScenePictures {
 public:
  /// `shown`: [cells] which to draw, or empty: all. Edges of their surface between two particles of `outline` are drawn
  /// as a line: where one part of the body ends and another begins. The model must outlive it.
  explicit ScenePictures(const phymul::Model& model, std::vector<char> shown = {},
                         const std::vector<phymul::Index>& outline = {});

  /// Throws phymul::Error if the state is not finite, or if the file cannot be written.
  void draw(const phymul::State& state, const ScenePictureOptions& options, const std::string& path) const;

 private:
  const phymul::Model& model_;
  BodySurface surface_;
  std::vector<char> on_surface_, on_outline_;  // [particles]
};

/// The tissue that cuts and removals have left, with the faces of cuts (tissue_surface), as it is now.
void draw_tissue(const phymul::Model& model, const phymul::State& state, const ScenePictureOptions& options,
                 const std::string& path);

/// Cells whose middle lies on that side of the plane to which the normal points: what is left of a body cut open.
std::vector<char> cells_beyond(const phymul::Model& model, const phymul::Vec3& point, const phymul::Vec3& normal);
