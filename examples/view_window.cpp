// SPDX-License-Identifier: MIT
#include "view_window.h"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <phymul/error.h>

#include <algorithm>

#include "canvas.h"
#include "view_input.h"

namespace {

/// The sentence of GLFW's last error.
std::string reason() {
  const char* text = nullptr;
  glfwGetError(&text);
  return text ? text : "no reason given";
}

ViewInput& input_of(GLFWwindow* window) {
  return *static_cast<ViewInput*>(glfwGetWindowUserPointer(window));
}

// The one GL function an example needs: what is in the window.
using ReadPixels = void (*)(int, int, int, int, unsigned, unsigned, void*);
using PixelStore = void (*)(unsigned, int);
constexpr unsigned gl_rgba = 0x1908, gl_unsigned_byte = 0x1401, gl_pack_alignment = 0x0D05;

}  // namespace

ViewWindow::ViewWindow(int width, int height, bool hidden) {
  if (glfwInit() != GLFW_TRUE) throw phymul::Error("no window system: " + reason());
  glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 3);
  glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 3);
  glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
  glfwWindowHint(GLFW_OPENGL_FORWARD_COMPAT, GLFW_TRUE);
  glfwWindowHint(GLFW_SAMPLES, 4);
  glfwWindowHint(GLFW_VISIBLE, hidden ? GLFW_FALSE : GLFW_TRUE);
  window_ = glfwCreateWindow(width, height, "phymul", nullptr, nullptr);
  if (!window_) {
    const std::string why = reason();
    glfwTerminate();
    throw phymul::Error("no window with OpenGL 3.3: " + why);
  }
  glfwMakeContextCurrent(window_);
  glfwSwapInterval(hidden ? 0 : 1);
}

ViewWindow::~ViewWindow() {
  glfwDestroyWindow(window_);
  glfwTerminate();
}

void ViewWindow::listen(ViewInput& input) {
  glfwSetWindowUserPointer(window_, &input);
  glfwSetKeyCallback(window_, [](GLFWwindow* window, int key, int, int action, int) {
    if (action != GLFW_RELEASE) input_of(window).key(key);
  });
  glfwSetMouseButtonCallback(window_, [](GLFWwindow* window, int button, int action, int) {
    input_of(window).button(button, action == GLFW_PRESS);
  });
  glfwSetCursorPosCallback(window_, [](GLFWwindow* window, double x, double y) { input_of(window).cursor(x, y); });
  glfwSetScrollCallback(window_, [](GLFWwindow* window, double, double y) { input_of(window).wheel(y); });
}

bool ViewWindow::closing() const {
  return glfwWindowShouldClose(window_) == GLFW_TRUE;
}

void ViewWindow::close() {
  glfwSetWindowShouldClose(window_, GLFW_TRUE);
}

std::pair<int, int> ViewWindow::size() const {
  std::pair<int, int> pixels;
  glfwGetFramebufferSize(window_, &pixels.first, &pixels.second);
  return pixels;
}

double ViewWindow::pixels_per_point() const {
  int width = 0, height = 0;
  glfwGetWindowSize(window_, &width, &height);
  return width > 0 ? static_cast<double>(size().first) / width : 1.0;
}

void ViewWindow::save(const std::string& path) const {
  const auto [width, height] = size();
  const auto store = reinterpret_cast<PixelStore>(glfwGetProcAddress("glPixelStorei"));
  const auto read = reinterpret_cast<ReadPixels>(glfwGetProcAddress("glReadPixels"));
  if (!store || !read) throw phymul::Error("the window's OpenGL has no glReadPixels");
  phymul::Image image{width, height, std::vector<std::uint8_t>(4 * static_cast<std::size_t>(width) * height)};
  store(gl_pack_alignment, 4);
  read(0, 0, width, height, gl_rgba, gl_unsigned_byte, image.rgba.data());
  const auto row = [&](int y) { return image.rgba.begin() + 4 * std::ptrdiff_t{width} * y; };
  for (int y = 0; y < height / 2; ++y)
    std::swap_ranges(row(y), row(y + 1), row(height - 1 - y));  // GL's is upside down
  Canvas canvas(width, height);
  canvas.put(image, 0, 0);
  canvas.save(path);
}

void ViewWindow::swap() {
  glfwSwapBuffers(window_);
  glfwPollEvents();
}

void ViewWindow::title(const std::string& text) {
  glfwSetWindowTitle(window_, text.c_str());
}
