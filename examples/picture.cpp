// SPDX-License-Identifier: MIT
#include "picture.h"

#include <phymul/error.h>
#include <phymul/monitor.h>

#include <algorithm>

#include "canvas.h"
#include "picture_legend.h"
#include "picture_painter.h"

namespace {

using phymul::VecList;

constexpr int top_margin = 90;     // pixels: title
constexpr int bottom_margin = 70;  // length bar
constexpr int side_margin = 40;
constexpr int bar_margin = 150;  // colour bar on the right

VecList all_points(const phymul::Model& model, const phymul::State& state, const PictureOptions& options) {
  VecList all = model.rest;
  for (const VecList* list : {&state.position, &options.attractors, &options.frame}) {
    all.insert(all.end(), list->begin(), list->end());
  }
  return all;
}

phymul::DisplayOptions layers(const PictureOptions& options) {
  phymul::DisplayOptions shown;
  shown.full_scale = options.full_scale;
  shown.particle_radius = options.particle_radius;
  shown.attractors = !options.attractors.empty();
  if (options.inside) {
    shown.surface_opacity = 0.3;
    shown.edges = false;
    shown.links = shown.particles = true;
  }
  shown.marks = {{options.fixed, held_colour}, {options.driven, driven_colour}};
  return shown;
}

/// Marks by cairo are squares where particles are held.
std::vector<KeyEntry> key_of(const PictureOptions& options, bool by_opengl, bool deformed) {
  using Mark = KeyEntry::Mark;
  std::vector<KeyEntry> key;
  if (!options.fixed.empty()) key.push_back({by_opengl ? Mark::ball : Mark::square, held_colour, "held"});
  if (!options.driven.empty()) key.push_back({Mark::ball, driven_colour, "driven"});
  if (by_opengl && !options.attractors.empty()) key.push_back({Mark::ball, attractor_colour, "attractors"});
  if (deformed) key.push_back({Mark::dashes, {0.45, 0.45, 0.45, 1.0}, "rest shape"});
  return key;
}

}  // namespace

BodyPictures::BodyPictures(const phymul::Model& model, Way way) : model_(model) {
  if (way == Way::cairo) {
    drawn_by_ = "cairo";
    return;
  }
  try {
    display_ = phymul::make_display(model);
    drawn_by_ = "OpenGL, on " + display_->device();
  } catch (const phymul::Error& error) {
    if (way == Way::opengl) throw;
    drawn_by_ = std::string("cairo: ") + error.what();
  }
}

BodyPictures::~BodyPictures() = default;

void BodyPictures::draw(const phymul::State& state, const PictureOptions& given, const std::string& path) {
  if (model_.rest.empty() || state.position.size() != model_.rest.size() || !phymul::is_finite(state)) {
    throw phymul::Error(path + ": expected a state of the model with finite positions; nothing was drawn");
  }
  PictureOptions options = given;
  const double largest = displacement_norms(model_, state).max;
  if (options.full_scale <= 0.0) options.full_scale = largest;
  const bool deformed = largest > 1e-3 * options.full_scale;  // else the rest shape's outline would lie on the body's
  const int width = std::max(options.width - side_margin - bar_margin, 1);
  const int height = std::max(options.height - top_margin - bottom_margin, 1);
  const phymul::Vec3 eye = model_.dimension == 2 ? phymul::Vec3(phymul::Vec3::UnitZ()) : options.eye;
  const double aspect = static_cast<double>(width) / height;
  phymul::Camera camera = phymul::framing(all_points(model_, state, options), eye, aspect);
  const double ball = options.particle_radius > 0.0 ? options.particle_radius : 0.08 * mean_spacing(model_);
  camera.view_height += 2.6 * ball * std::max(1.0, 1.0 / aspect);  // marks are balls, and larger

  Canvas canvas(options.width, options.height);
  if (display_) {
    phymul::DisplayOptions shown = layers(options);
    shown.rest_shape = deformed;
    display_->show(state.position, options.attractors);
    canvas.put(display_->render(camera, shown, width, height), side_margin, top_margin);
  } else {
    cairo_save(canvas.cairo());
    cairo_translate(canvas.cairo(), side_margin, top_margin);
    paint_body(canvas.cairo(), model_, state, camera, options, width, height);
    cairo_restore(canvas.cairo());
  }
  draw_title(canvas.cairo(), side_margin, options.title, options.subtitle);
  const double top = top_margin + 40.0;
  draw_colour_bar(canvas.cairo(), options.width - bar_margin + 50.0, top,
                  std::min(320.0, options.height - top - bottom_margin), options.full_scale);
  const double y = options.height - 30.0;
  const double end = draw_length_bar(canvas.cairo(), side_margin, y, 0.25 * options.width,
                                     phymul::pixels_per_metre(camera, camera.target, height));
  draw_key(canvas.cairo(), end + 90.0, y, key_of(options, display_ != nullptr, deformed));
  canvas.save(path);
}
