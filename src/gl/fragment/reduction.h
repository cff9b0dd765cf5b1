// SPDX-License-Identifier: MIT
//
// Reduction: rows brought down to one, `branch` to one a draw; or so for each of several lists.
#pragma once

#include <vector>

#include "gl/objects/pass.h"

namespace phymul::gl {

class Reduction {
 public:
  struct Result {
    const char* input;  ///< as later draws read it
    TexelFormat format = TexelFormat::rgba32f;
  };
  /// `rows` of a list; `what`: the name of the textures.
  Reduction(int rows, int branch, std::vector<Result> results, const char* what, int lists = 1);

  /// `first` has what it reads in place; `further` reads results.
  void draw(Pass& first, Pass& further);
  void draw(Pass& pass) { draw(pass, pass); }

  const Texture& result(std::size_t k = 0) const { return levels_.back().results[k]; }
  /// A row for each list.
  const Framebuffer& target() const { return levels_.back().target; }

 private:
  struct Level {
    std::vector<Texture> results;
    Framebuffer target;
    int rows = 0;
  };
  int rows_, lists_;
  std::vector<Result> results_;
  std::vector<Level> levels_;
};

}  // namespace phymul::gl
