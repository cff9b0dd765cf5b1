// SPDX-License-Identifier: MIT
#include "view_input.h"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <phymul/error.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "view_simulation.h"
#include "view_window.h"

namespace {

using phymul::Vec3;

constexpr double view_angle = 0.5;         // rad
constexpr double radians_a_pixel = 0.008;  // of a turn
constexpr double zoom = 1.15;              // a notch
constexpr double scale_share = 0.15;       // of the body's size: displacement at the end of the colours

}  // namespace

ViewInput::ViewInput(ViewSimulation& simulation, ViewWindow& window)
    : simulation_(simulation),
      window_(window),
      drag_(simulation.sim()),
      scalpel_(simulation.sim(), simulation.model()),
      full_scale_(scale_share * body_size(simulation.model())) {
  layers_.full_scale = full_scale_;
  look_at_body();
}

void ViewInput::look_at_body() {
  const auto [width, height] = window_.size();
  const phymul::Model& model = simulation_.model();
  const Vec3 towards_eye = model.dimension == 2 ? Vec3(0, 0, 1) : Vec3(0.5, -1.0, 0.45);
  camera_ = phymul::framing(model.rest, towards_eye, static_cast<double>(width) / std::max(height, 1), view_angle);
  camera_.eye += 0.4 * (camera_.eye - camera_.target);  // room to pull
}

void ViewInput::key(int key) {
  switch (key) {
    case GLFW_KEY_SPACE:
      paused_ = !paused_;
      break;
    case GLFW_KEY_N:
      paused_ = true;
      simulation_.step(1);
      break;
    case GLFW_KEY_R:
      let_go();
      simulation_.reset();
      break;
    case GLFW_KEY_X:
      let_go();
      cutting_ = !cutting_ && simulation_.can_be_cut();
      if (!simulation_.can_be_cut()) {
        std::fprintf(stderr, "phymul-view: only a body of tetrahedra with a material can be cut\n");
      }
      break;
    case GLFW_KEY_Z:
      let_go();
      simulation_.undo_cut();
      break;
    case GLFW_KEY_K:
      simulation_.change_skin();
      mark_dragged();
      break;
    case GLFW_KEY_B:
      let_go();  // what holds and cuts is in the scene of the present one
      try {
        simulation_.next_backend();
      } catch (const phymul::Error& error) {
        std::fprintf(stderr, "phymul-view: %s\n", error.what());
      }
      break;
    case GLFW_KEY_F:
      look_at_body();
      break;
    case GLFW_KEY_Q:
    case GLFW_KEY_ESCAPE:
      window_.close();
      break;
    default:
      layer_key(key);
  }
}

void ViewInput::layer_key(int key) {
  const auto toggle = [](bool& layer) { layer = !layer; };
  if (key == GLFW_KEY_S) toggle(layers_.surface);
  if (key == GLFW_KEY_E) toggle(layers_.edges);
  if (key == GLFW_KEY_L) toggle(layers_.links);
  if (key == GLFW_KEY_P) toggle(layers_.particles);
  if (key == GLFW_KEY_A) toggle(layers_.attractors);
  if (key == GLFW_KEY_O) toggle(layers_.rest_shape);
  if (key == GLFW_KEY_T) layers_.surface_opacity = layers_.surface_opacity < 1.0 ? 1.0 : 0.3;
  if (key == GLFW_KEY_C) layers_.full_scale = layers_.full_scale > 0.0 ? 0.0 : full_scale_;
  if (key == GLFW_KEY_EQUAL || key == GLFW_KEY_KP_ADD) layers_.full_scale = full_scale_ *= 1.25;
  if (key == GLFW_KEY_MINUS || key == GLFW_KEY_KP_SUBTRACT) layers_.full_scale = full_scale_ /= 1.25;
}

void ViewInput::button(int button, bool pressed) {
  if (button == GLFW_MOUSE_BUTTON_LEFT) {
    const auto [width, height] = window_.size();
    const double scale = window_.pixels_per_point();
    let_go();
    if (cutting_ && pressed) {
      simulation_.begin_cut();
      scalpel_.begin(scale * x_, scale * y_);
    } else {
      turning_ = pressed && !drag_.take(camera_, scale * x_, scale * y_, width, height);
    }
    mark_dragged();
  } else {
    shifting_ = pressed;
  }
}

void ViewInput::let_go() {
  drag_.release();
  scalpel_.end();
  mark_dragged();
}

void ViewInput::mark_dragged() {
  layers_.marks.clear();
  // A skin's points have other numbers.
  if (drag_.holds() && !simulation_.shows_skin()) layers_.marks = {{{drag_.particle()}, {0.84, 0.15, 0.16, 1.0}}};
}

void ViewInput::cursor(double x, double y) {
  const double across = x - x_, downward = y - y_;
  x_ = x;
  y_ = y;
  if (turning_) orbit(across, -downward);
  if (shifting_) shift(across, -downward);
}

void ViewInput::orbit(double across, double upward) {
  const phymul::CameraAxes axes = axes_of(camera_);
  const Vec3 back = camera_.eye - camera_.target;
  const double height = std::asin(std::clamp(axes.towards_eye.dot(camera_.up.normalized()), -1.0, 1.0));
  const double tilt = std::clamp(height - radians_a_pixel * upward, -1.5, 1.5) - height;  // never over the top
  camera_.eye = camera_.target + Eigen::AngleAxisd(-radians_a_pixel * across, camera_.up.normalized()) *
                                     (Eigen::AngleAxisd(-tilt, axes.right) * back);
}

void ViewInput::shift(double across, double upward) {
  const phymul::CameraAxes axes = axes_of(camera_);
  const double scale = window_.pixels_per_point() / pixels_per_metre(camera_, camera_.target, window_.size().second);
  const Vec3 way = -scale * (across * axes.right + upward * axes.up);
  camera_.eye += way;
  camera_.target += way;
}

void ViewInput::wheel(double notches) {
  camera_.eye = camera_.target + std::pow(zoom, -notches) * (camera_.eye - camera_.target);
}

void ViewInput::advance(double wall_time, bool keep_up) {
  const auto [width, height] = window_.size();
  const double x = window_.pixels_per_point() * x_, y = window_.pixels_per_point() * y_;
  drag_.move(camera_, x, y, width, height);
  if (paused_ || !simulation_.failure().empty()) return;
  scalpel_.move(camera_, x, y, width, height);
  simulation_.advance(wall_time, keep_up);
}

std::string ViewInput::title() const {
  std::string text = simulation_.model().name.empty() ? "phymul" : simulation_.model().name;
  text += ": " + simulation_.status();
  if (cutting_) text += " [scalpel]";
  if (paused_) text += " [paused]";
  if (!simulation_.failure().empty()) text += " [stopped: " + simulation_.failure() + "; r: back to rest]";
  return text;
}
