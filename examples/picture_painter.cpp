// SPDX-License-Identifier: MIT
#include "picture_painter.h"

#include <phymul/monitor.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "body_surface.h"
#include "picture_legend.h"

namespace {

using phymul::Index;
using phymul::Vec3;
using phymul::VecList;

Vec3 normal_of(const Face& face, const VecList& x) {
  Vec3 sum = Vec3::Zero();
  for (std::size_t k = 0; k < face.corners.size(); ++k) {
    sum += x[face.corners[k]].cross(x[face.corners[(k + 1) % face.corners.size()]]);
  }
  return sum.stableNormalized();
}

class Painter {
 public:
  Painter(cairo_t* canvas, const phymul::Model& model, const phymul::State& state, const phymul::Camera& camera,
          const PictureOptions& options, int width, int height)
      : c_(canvas),
        model_(model),
        state_(state),
        x_(state.position),
        options_(options),
        camera_(camera),
        axes_(axes_of(camera)),
        light_((axes_.towards_eye + 0.6 * axes_.up - 0.5 * axes_.right).normalized()),
        width_(width),
        height_(height),
        surface_(surface_of(model)) {}

  void paint() {
    cairo_set_line_join(c_, CAIRO_LINE_JOIN_ROUND);
    paint_ghost(0.9);
    surface_.faces.empty() ? paint_links() : paint_faces();
    paint_ghost(0.3);
    paint_marks(options_.fixed, held_colour, false);
    paint_marks(options_.driven, driven_colour, true);
  }

 private:
  Vec3 seen(const Vec3& x) const { return to_pixel(camera_, x, width_, height_); }
  phymul::Colour colour_at(double displacement) const {
    return phymul::displacement_colour(options_.full_scale > 0.0 ? displacement / options_.full_scale : 0.0);
  }

  void line(const Vec3& from, const Vec3& to) {
    const Vec3 a = seen(from);
    const Vec3 b = seen(to);
    cairo_move_to(c_, a.x(), a.y());
    cairo_line_to(c_, b.x(), b.y());
    cairo_stroke(c_);
  }

  /// Painter's order: the faces farthest from the eye first.
  void paint_faces() {
    std::vector<std::pair<double, const Face*>> order;
    for (const Face& face : surface_.faces) {
      double depth = 0.0;
      for (const Index i : face.corners) depth += axes_.towards_eye.dot(x_[i]);
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
    return phymul::pixels_per_metre(camera_, camera_.target, height_) * sum /
           static_cast<double>(std::max<std::size_t>(surface_.edges.size(), 1));
  }

  void paint_face(const Face& face, double line_strength) {
    double displacement = 0.0;
    for (const Index i : face.corners) displacement += (x_[i] - model_.rest[i]).norm();
    const phymul::Colour colour = colour_at(displacement / static_cast<double>(face.corners.size()));
    // Both sides are lit: faces of a plane body or of a turned cell may look away.
    const double lit = model_.dimension == 2 ? 1.0 : 0.65 + 0.35 * std::abs(normal_of(face, x_).dot(light_));
    for (const Index i : face.corners) {
      const Vec3 p = seen(x_[i]);
      cairo_line_to(c_, p.x(), p.y());
    }
    cairo_close_path(c_);
    cairo_set_source_rgb(c_, lit * colour[0], lit * colour[1], lit * colour[2]);
    cairo_fill_preserve(c_);
    cairo_set_source_rgba(c_, 0, 0, 0, line_strength);
    cairo_stroke(c_);
  }

  void paint_links() {
    cairo_set_line_width(c_, 1.2);
    for (const SurfaceEdge& edge : surface_.edges) {
      const auto [a, b] = edge.ends;
      const phymul::Colour colour =
          colour_at(((x_[a] - model_.rest[a]).norm() + (x_[b] - model_.rest[b]).norm()) / 2.0);
      cairo_set_source_rgb(c_, colour[0], colour[1], colour[2]);
      line(x_[a], x_[b]);
    }
  }

  /// The rest shape's contour: edges between a face that looks at the eye and one that does not, and open edges.
  void paint_ghost(double strength) {
    if (displacement_norms(model_, state_).max == 0.0) return;
    const double dash[] = {6.0, 4.0};
    cairo_set_dash(c_, dash, 2, 0.0);
    cairo_set_line_width(c_, 1.4);
    cairo_set_source_rgba(c_, 0.45, 0.45, 0.45, surface_.faces.empty() ? 0.3 * strength : strength);
    const auto looks_here = [&](int face) {
      return normal_of(surface_.faces[static_cast<std::size_t>(face)], model_.rest).dot(axes_.towards_eye) > 1e-9;
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
  void paint_marks(const std::vector<Index>& particles, const phymul::Colour& colour, bool round) {
    std::vector<char> visible(x_.size(), surface_.faces.empty() || model_.dimension == 2 ? 1 : 0);
    for (const Face& face : surface_.faces) {
      if (normal_of(face, x_).dot(axes_.towards_eye) <= 0.0) continue;
      for (const Index i : face.corners) visible[static_cast<std::size_t>(i)] = 1;
    }
    constexpr double half = 3.5;
    for (const Index i : particles) {
      if (!visible[static_cast<std::size_t>(i)]) continue;
      const Vec3 p = seen(x_[i]);
      cairo_new_sub_path(c_);
      round ? cairo_arc(c_, p.x(), p.y(), half, 0.0, 6.2832)
            : cairo_rectangle(c_, p.x() - half, p.y() - half, 2 * half, 2 * half);
      cairo_set_source_rgb(c_, colour[0], colour[1], colour[2]);
      cairo_fill_preserve(c_);
      cairo_set_source_rgb(c_, 1, 1, 1);
      cairo_set_line_width(c_, 1.0);
      cairo_stroke(c_);
    }
  }

  cairo_t* c_;
  const phymul::Model& model_;
  const phymul::State& state_;
  const VecList& x_;
  const PictureOptions& options_;
  const phymul::Camera& camera_;
  const phymul::CameraAxes axes_;
  const Vec3 light_;
  const int width_, height_;
  const BodySurface surface_;
};

}  // namespace

void paint_body(cairo_t* canvas, const phymul::Model& model, const phymul::State& state, const phymul::Camera& camera,
                const PictureOptions& options, int width, int height) {
  Painter(canvas, model, state, camera, options, width, height).paint();
}
