// SPDX-License-Identifier: MIT
#include "canvas.h"

#include <phymul/error.h>

#include <cstring>
#include <filesystem>

Canvas::Canvas(int width, int height)
    : surface_(cairo_image_surface_create(CAIRO_FORMAT_RGB24, width, height)), cairo_(cairo_create(surface_)) {
  cairo_set_source_rgb(cairo_, 1, 1, 1);
  cairo_paint(cairo_);
}

Canvas::~Canvas() {
  cairo_destroy(cairo_);
  cairo_surface_destroy(surface_);
}

void Canvas::put(const phymul::Image& image, int left, int top) {
  cairo_surface_flush(surface_);
  const int stride = cairo_image_surface_get_stride(surface_);
  for (int y = 0; y < image.height; ++y) {
    unsigned char* out = cairo_image_surface_get_data(surface_) + (top + y) * stride + 4 * left;
    for (int x = 0; x < image.width; ++x, out += 4) {
      const std::uint8_t* in = image.pixel(x, y);
      const auto rgb = static_cast<std::uint32_t>(in[0] << 16 | in[1] << 8 | in[2]);
      std::memcpy(out, &rgb, sizeof rgb);
    }
  }
  cairo_surface_mark_dirty(surface_);
}

void Canvas::save(const std::string& path) const {
  const std::string part = path + ".part";
  const cairo_status_t status = cairo_surface_write_to_png(surface_, part.c_str());
  std::error_code problem;
  if (status == CAIRO_STATUS_SUCCESS) std::filesystem::rename(part, path, problem);
  if (status != CAIRO_STATUS_SUCCESS || problem) {
    const std::string why = problem ? problem.message() : cairo_status_to_string(status);
    std::filesystem::remove(part, problem);
    throw phymul::Error(phymul::ErrorCode::file_access, path + ": cannot be written: " + why);
  }
}
