// SPDX-License-Identifier: MIT
//
// The words and scales around a picture. Places and sizes in pixels.
#pragma once

#include <cairo.h>
#include <phymul/model.h>

#include <span>
#include <string>

inline constexpr phymul::Colour held_colour{0.1, 0.1, 0.1, 1.0};
inline constexpr phymul::Colour driven_colour{0.84, 0.15, 0.16, 1.0};
inline constexpr phymul::Colour attractor_colour{0.74, 0.16, 0.52, 1.0};  // that of phymul::Display

void draw_title(cairo_t* c, double x, const std::string& title, const std::string& subtitle);

/// Colours from 0 to full_scale, m, upward from y + height to y, with five labels.
void draw_colour_bar(cairo_t* c, double x, double y, double height, double full_scale);

/// A bar of a round length, 1, 2 or 5 times a power of ten, at most `most` wide; scale in pixels per metre. Returns
/// where it ends.
double draw_length_bar(cairo_t* c, double x, double y, double most, double scale);

/// What a mark means.
struct KeyEntry {
  enum class Mark { ball, square, line, dashes, cross } mark;
  phymul::Colour colour;
  std::string words;
};
/// One entry beside the other, from x on.
void draw_key(cairo_t* c, double x, double y, std::span<const KeyEntry> entries);
