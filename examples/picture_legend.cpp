// SPDX-License-Identifier: MIT
#include "picture_legend.h"

#include <phymul/display.h>

#include <cmath>
#include <cstdio>
#include <utility>

namespace {

void text(cairo_t* c, double x, double y, double size, const std::string& words, bool bold = false) {
  cairo_select_font_face(c, "sans-serif", CAIRO_FONT_SLANT_NORMAL,
                         bold ? CAIRO_FONT_WEIGHT_BOLD : CAIRO_FONT_WEIGHT_NORMAL);
  cairo_set_font_size(c, size);
  cairo_set_source_rgb(c, 0.1, 0.1, 0.1);
  cairo_move_to(c, x, y);
  cairo_show_text(c, words.c_str());
}

std::string short_number(double value) {
  char buffer[32];
  std::snprintf(buffer, sizeof buffer, "%.3g", value);
  return buffer;
}

std::pair<const char*, double> unit_for(double length) {
  if (length >= 1.0) return {"m", 1.0};
  if (length >= 1e-4 || length == 0.0) return {"mm", 1e-3};
  if (length >= 1e-7) return {"\u00b5m", 1e-6};
  return {"nm", 1e-9};
}

void set_colour(cairo_t* c, const phymul::Colour& colour) {
  cairo_set_source_rgb(c, colour[0], colour[1], colour[2]);
}

/// In the colour that is set. Returns how much longer it is than a ball.
double draw_mark(cairo_t* c, double x, double y, KeyEntry::Mark mark) {
  using Mark = KeyEntry::Mark;
  if (mark == Mark::ball || mark == Mark::square) {
    mark == Mark::ball ? cairo_arc(c, x, y, 3.5, 0.0, 6.2832) : cairo_rectangle(c, x - 3.5, y - 3.5, 7.0, 7.0);
    cairo_fill(c);
    return 0.0;
  }
  cairo_set_line_width(c, 2.0);
  if (mark == Mark::cross) {
    for (const double side : {-1.0, 1.0}) {
      cairo_move_to(c, x - 4.0, y - side * 4.0);
      cairo_line_to(c, x + 4.0, y + side * 4.0);
    }
    cairo_stroke(c);
    return 0.0;
  }
  const double dash[] = {6.0, 4.0};
  if (mark == Mark::dashes) cairo_set_dash(c, dash, 2, 0.0);
  cairo_move_to(c, x - 4.0, y);
  cairo_line_to(c, x + 22.0, y);
  cairo_stroke(c);
  cairo_set_dash(c, nullptr, 0, 0.0);
  return 20.0;
}

}  // namespace

void draw_title(cairo_t* c, double x, const std::string& title, const std::string& subtitle) {
  text(c, x, 38, 22, title, true);
  text(c, x, 64, 15, subtitle);
}

void draw_colour_bar(cairo_t* c, double x, double y, double height, double full_scale) {
  cairo_pattern_t* ramp = cairo_pattern_create_linear(0.0, y + height, 0.0, y);
  for (int k = 0; k <= 16; ++k) {
    const phymul::Colour colour = phymul::displacement_colour(k / 16.0);
    cairo_pattern_add_color_stop_rgb(ramp, k / 16.0, colour[0], colour[1], colour[2]);
  }
  cairo_rectangle(c, x, y, 22.0, height);
  cairo_set_source(c, ramp);
  cairo_fill(c);
  cairo_pattern_destroy(ramp);
  const auto [unit, metres] = unit_for(full_scale);
  text(c, x - 30.0, y - 28.0, 13, "displacement");
  text(c, x - 30.0, y - 12.0, 13, std::string("in ") + unit);
  for (int k = 0; k <= 4; ++k) {
    text(c, x + 29.0, y + height * (1.0 - k / 4.0) + 4.5, 13, short_number(full_scale * k / 4.0 / metres));
  }
}

double draw_length_bar(cairo_t* c, double x, double y, double most, double scale) {
  const double longest = most / scale;
  const double power = std::pow(10.0, std::floor(std::log10(longest)));
  const double length = longest / power >= 5.0 ? 5.0 * power : longest / power >= 2.0 ? 2.0 * power : power;
  const double end = x + length * scale;
  cairo_set_source_rgb(c, 0.1, 0.1, 0.1);
  cairo_set_line_width(c, 2.0);
  for (const double tick : {x, end}) {
    cairo_move_to(c, tick, y - 5.0);
    cairo_line_to(c, tick, y + 5.0);
  }
  cairo_move_to(c, x, y);
  cairo_line_to(c, end, y);
  cairo_stroke(c);
  const auto [unit, metres] = unit_for(length);
  text(c, end + 10.0, y + 5.0, 13, short_number(length / metres) + ' ' + unit);
  return end;
}

void draw_key(cairo_t* c, double x, double y, std::span<const KeyEntry> entries) {
  for (const KeyEntry& entry : entries) {
    cairo_new_path(c);
    set_colour(c, entry.colour);
    x += draw_mark(c, x, y, entry.mark);
    text(c, x + 10.0, y + 5.0, 13, entry.words);
    cairo_text_extents_t size;
    cairo_text_extents(c, entry.words.c_str(), &size);
    x += size.x_advance + 34.0;
  }
}
