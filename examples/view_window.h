// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <utility>

struct GLFWwindow;
class ViewInput;

/// A window whose OpenGL context is current on this thread as long as it lives; one a process.
class ViewWindow {
 public:
  /// Throws phymul::Error where there is no screen, or none with OpenGL 3.3.
  ViewWindow(int width, int height, bool hidden);
  ViewWindow(const ViewWindow&) = delete;
  ViewWindow& operator=(const ViewWindow&) = delete;
  ~ViewWindow();

  void listen(ViewInput& input);  ///< keys, buttons, wheel go there from now on
  bool closing() const;
  void close();
  std::pair<int, int> size() const;          ///< pixels
  double pixels_per_point() const;           ///< the mouse counts in points
  void save(const std::string& path) const;  ///< the picture drawn last, before swap()
  void swap();                               ///< shows it, and hears the input
  void title(const std::string& text);

 private:
  GLFWwindow* window_ = nullptr;
};
