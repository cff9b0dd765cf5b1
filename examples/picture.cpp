// SPDX-License-Identifier: MIT
#include "picture.h"

#include <cairo.h>
#include <phymul/error.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>

#include "body_surface.h"
#include "colour_map.h"
#include "picture_legend.h"

namespace {

using phymul::Index;
using phymul::Vec3;
using phymul::VecList;

using Surface = std::unique_ptr<cairo_surface_t, decltype(&cairo_surface_destroy)>;
using Context = std::unique_ptr<cairo_t, decltype(&cairo_destroy)>;

constexpr double top_margin = 90.0;     // pixels: title
constexpr double bottom_margin = 70.0;  // length bar
constexpr double side_margin = 40.0;
constexpr double bar_margin = 150.0;  // colour bar on the right

/// Orthographic view: x to the right and y down in pixels, z towards the eye in metres.
class View {
 public:
  View(const Vec3& eye, const VecList& all, const PictureOptions& options) : towards_(eye.normalized()) {
    const Vec3 up_hint = std::abs(towards_.z()) > 0.99 ? Vec3(Vec3::UnitY()) : Vec3(Vec3::UnitZ());
    right_ = up_hint.cross(towards_).normalized();
    up_ = towards_.cross(right_);
    Vec3 low = turned(all.front());
    Vec3 high = low;
    for (const Vec3& x : all) {
      low = low.cwiseMin(turned(x));
      high = high.cwiseMax(turned(x));
    }
    const double width = options.width - side_margin - bar_margin;
    const double height = options.height - top_margin - bottom_margin;
    const Vec3 size = high - low;
    scale_ = std::min(width / std::max(size.x(), 1e-300), height / std::max(size.y(), 1e-300));
    if (!std::isfinite(scale_) || scale_ > 1e290) scale_ = 1.0;  // a single point
    offset_ = {side_margin + width / 2.0 - scale_ * (low.x() + high.x()) / 2.0,
               top_margin + height / 2.0 + scale_ * (low.y() + high.y()) / 2.0, 0.0};
  }

  Vec3 operator()(const Vec3& x) const {
    const Vec3 t = turned(x);
    return {offset_.x() + scale_ * t.x(), offset_.y() - scale_ * t.y(), t.z()};
  }
  const Vec3& towards() const { return towards_; }
  Vec3 light() const { return (towards_ + 0.6 * up_ - 0.5 * right_).normalized(); }
  double scale() const { return scale_; }  ///< pixels per metre

 private:
  Vec3 turned(const Vec3& x) const { return {right_.dot(x), up_.dot(x), towards_.dot(x)}; }

  Vec3 towards_, right_, up_, offset_;
  double scale_ = 1.0;
};

Vec3 normal_of(const Face& face, const VecList& x) {
  Vec3 sum = Vec3::Zero();
  for (std::size_t k = 0; k < face.corners.size(); ++k) {
    sum += x[face.corners[k]].cross(x[face.corners[(k + 1) % face.corners.size()]]);
  }
  return sum.stableNormalized();
}

class Painter {
 public:
  Painter(const phymul::Model& model, const phymul::State& state, const PictureOptions& options)
      : model_(model),
        x_(state.position),
        options_(options),
        surface_(surface_of(model)),
        view_(model.dimension == 2 ? Vec3(Vec3::UnitZ()) : options.eye, all_points(), options),
        canvas_(cairo_image_surface_create(CAIRO_FORMAT_RGB24, options.width, options.height), cairo_surface_destroy),
        context_(cairo_create(canvas_.get()), cairo_destroy),
        c_(context_.get()) {
    for (std::size_t i = 0; i < x_.size(); ++i) largest_ = std::max(largest_, (x_[i] - model.rest[i]).norm());
    full_scale_ = options.full_scale > 0.0 ? options.full_scale : largest_;
  }

  void paint() {
    cairo_set_source_rgb(c_, 1, 1, 1);
    cairo_paint(c_);
    cairo_set_line_join(c_, CAIRO_LINE_JOIN_ROUND);
    paint_ghost(0.9);
    surface_.faces.empty() ? paint_links() : paint_faces();
    paint_ghost(0.3);
    paint_marks(options_.fixed, held_colour, false);
    paint_marks(options_.driven, driven_colour, true);
    paint_legend();
  }

  void save(const std::string& path) {
    const std::string part = path + ".part";
    const cairo_status_t status = cairo_surface_write_to_png(canvas_.get(), part.c_str());
    std::error_code problem;
    if (status == CAIRO_STATUS_SUCCESS) std::filesystem::rename(part, path, problem);
    if (status != CAIRO_STATUS_SUCCESS || problem) {
      std::filesystem::remove(part, problem);
      throw phymul::Error(path + ": cannot be written: " + cairo_status_to_string(status));
    }
  }

 private:
  VecList all_points() const {
    VecList all = model_.rest;
    all.insert(all.end(), x_.begin(), x_.end());
    all.insert(all.end(), options_.frame.begin(), options_.frame.end());
    return all;
  }

  Rgb colour_at(double displacement) const { return viridis(full_scale_ > 0.0 ? displacement / full_scale_ : 0.0); }

  void line(const Vec3& from, const Vec3& to) {
    const Vec3 a = view_(from);
    const Vec3 b = view_(to);
    cairo_move_to(c_, a.x(), a.y());
    cairo_line_to(c_, b.x(), b.y());
    cairo_stroke(c_);
  }

  /// Painter's order: the faces farthest from the eye first.
  void paint_faces() {
    std::vector<std::pair<double, const Face*>> order;
    for (const Face& face : surface_.faces) {
      double depth = 0.0;
      for (const Index i : face.corners) depth += view_(x_[i]).z();
      order.emplace_back(depth / static_cast<double>(face.corners.size()), &face);
    }
    std::sort(order.begin(), order.end());
    cairo_set_line_width(c_, 0.8);
    const double line_strength = 0.35 * std::min(1.0, mean_edge_pixels() / 15.0);  // a fine mesh would be all lines
    for (const auto& [depth, face] : order) paint_face(*face, line_strength);
  }

  double mean_edge_pixels() const {
    double sum = 0.0;
    for (const SurfaceEdge& edge : surface_.edges)
      sum += (model_.rest[edge.ends[0]] - model_.rest[edge.ends[1]]).norm();
    return view_.scale() * sum / static_cast<double>(std::max<std::size_t>(surface_.edges.size(), 1));
  }

  void paint_face(const Face& face, double line_strength) {
    double displacement = 0.0;
    for (const Index i : face.corners) displacement += (x_[i] - model_.rest[i]).norm();
    const Rgb colour = colour_at(displacement / static_cast<double>(face.corners.size()));
    // Both sides are lit: faces of a plane body or of a turned cell may look away.
    const double lit = model_.dimension == 2 ? 1.0 : 0.65 + 0.35 * std::abs(normal_of(face, x_).dot(view_.light()));
    for (const Index i : face.corners) {
      const Vec3 p = view_(x_[i]);
      cairo_line_to(c_, p.x(), p.y());
    }
    cairo_close_path(c_);
    cairo_set_source_rgb(c_, lit * colour.red, lit * colour.green, lit * colour.blue);
    cairo_fill_preserve(c_);
    cairo_set_source_rgba(c_, 0, 0, 0, line_strength);
    cairo_stroke(c_);
  }

  void paint_links() {
    cairo_set_line_width(c_, 1.2);
    for (const SurfaceEdge& edge : surface_.edges) {
      const auto [a, b] = edge.ends;
      const Rgb colour = colour_at(((x_[a] - model_.rest[a]).norm() + (x_[b] - model_.rest[b]).norm()) / 2.0);
      cairo_set_source_rgb(c_, colour.red, colour.green, colour.blue);
      line(x_[a], x_[b]);
    }
  }

  /// The rest shape's contour: edges between a face that looks at the eye and one that does not, and open edges.
  void paint_ghost(double strength) {
    if (largest_ == 0.0) return;
    const double dash[] = {6.0, 4.0};
    cairo_set_dash(c_, dash, 2, 0.0);
    cairo_set_line_width(c_, 1.4);
    cairo_set_source_rgba(c_, 0.45, 0.45, 0.45, surface_.faces.empty() ? 0.3 * strength : strength);
    const auto looks_here = [&](int face) {
      return normal_of(surface_.faces[static_cast<std::size_t>(face)], model_.rest).dot(view_.towards()) > 1e-9;
    };
    for (const SurfaceEdge& edge : surface_.edges) {
      const bool open = edge.faces[0] < 0 || edge.faces[1] < 0;
      if (open || looks_here(edge.faces[0]) != looks_here(edge.faces[1])) {
        line(model_.rest[edge.ends[0]], model_.rest[edge.ends[1]]);
      }
    }
    cairo_set_dash(c_, nullptr, 0, 0.0);
  }

  /// Marks particles of faces that look at the eye; all of them where there are no faces.
  void paint_marks(const std::vector<Index>& particles, const Rgb& colour, bool round) {
    std::vector<char> visible(x_.size(), surface_.faces.empty() || model_.dimension == 2 ? 1 : 0);
    for (const Face& face : surface_.faces) {
      if (normal_of(face, x_).dot(view_.towards()) <= 0.0) continue;
      for (const Index i : face.corners) visible[static_cast<std::size_t>(i)] = 1;
    }
    constexpr double half = 3.5;
    for (const Index i : particles) {
      if (!visible[static_cast<std::size_t>(i)]) continue;
      const Vec3 p = view_(x_[i]);
      cairo_new_sub_path(c_);
      round ? cairo_arc(c_, p.x(), p.y(), half, 0.0, 6.2832)
            : cairo_rectangle(c_, p.x() - half, p.y() - half, 2 * half, 2 * half);
      cairo_set_source_rgb(c_, colour.red, colour.green, colour.blue);
      cairo_fill_preserve(c_);
      cairo_set_source_rgb(c_, 1, 1, 1);
      cairo_set_line_width(c_, 1.0);
      cairo_stroke(c_);
    }
  }

  void paint_legend() {
    draw_title(c_, side_margin, options_.title, options_.subtitle);
    const double top = top_margin + 40.0;
    draw_colour_bar(c_, options_.width - bar_margin + 50.0, top, std::min(320.0, options_.height - top - bottom_margin),
                    full_scale_);
    const double y = options_.height - 30.0;
    const double end = draw_length_bar(c_, side_margin, y, 0.25 * options_.width, view_.scale());
    draw_key(c_, end + 90.0, y, {!options_.fixed.empty(), !options_.driven.empty(), largest_ > 0.0});
  }

  const phymul::Model& model_;
  const VecList& x_;
  const PictureOptions& options_;
  BodySurface surface_;
  View view_;
  Surface canvas_;
  Context context_;
  cairo_t* c_;
  double largest_ = 0.0;     // m
  double full_scale_ = 0.0;  // m
};

}  // namespace

void draw_picture(const phymul::Model& model, const phymul::State& state, const PictureOptions& options,
                  const std::string& path) {
  if (model.rest.empty() || state.position.size() != model.rest.size() || !phymul::is_finite(state)) {
    throw phymul::Error(path + ": expected a state of the model with finite positions; nothing was drawn");
  }
  Painter painter(model, state, options);
  painter.paint();
  painter.save(path);
}
