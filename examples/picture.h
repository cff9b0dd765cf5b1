// SPDX-License-Identifier: MIT
//
// Pictures of a body in PNG files, with a title, scales and a key: the body by OpenGL (phymul/display.h) where the
// machine has it, else with cairo; the words around it always with cairo.
#pragma once

#include <phymul/display.h>
#include <phymul/model.h>
#include <phymul/state.h>

#include <memory>
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
  // By OpenGL only.
  double particle_radius = 0.0;     ///< m; 0: as Display takes it
  bool inside = false;              ///< the surface lets through; particles and links between neighbours show
  phymul::VecList attractors = {};  ///< [N] or empty: where each particle is drawn to
};

class BodyPictures {
 public:
  enum class Way { best, opengl, cairo };

  /// The model must outlive it. Throws phymul::Error for Way::opengl where there is none.
  explicit BodyPictures(const phymul::Model& model, Way way = Way::best);
  ~BodyPictures();

  /// Throws phymul::Error when the file cannot be written.
  void draw(const phymul::State& state, const PictureOptions& options, const std::string& path);

  /// "OpenGL, on <renderer>", or "cairo: <why there is no OpenGL>".
  const std::string& drawn_by() const { return drawn_by_; }

 private:
  const phymul::Model& model_;
  std::unique_ptr<phymul::Display> display_;  // null: cairo
  std::string drawn_by_;
};
