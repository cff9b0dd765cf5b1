// SPDX-License-Identifier: MIT
#include "reduction.h"

#include <utility>

namespace phymul::gl {

Reduction::Reduction(int rows, int branch, std::vector<Result> results, const char* what, int lists)
    : rows_(rows), lists_(lists), results_(std::move(results)) {
  do {
    rows = (rows + branch - 1) / branch;
    Level& level = levels_.emplace_back();
    level.rows = rows;
    for (const Result& result : results_) {
      level.results.push_back(Texture::target(std::int64_t{lists_} * rows, result.format, what));
    }
    std::vector<Attachment> attachments;
    for (const Texture& texture : level.results) attachments.push_back({&texture});
    level.target = Framebuffer(attachments);
  } while (rows > 1);
}

void Reduction::draw(Pass& first, Pass& further) {
  int source = rows_;
  for (std::size_t k = 0; k < levels_.size(); ++k) {
    const Level& level = levels_[k];
    Pass& pass = k == 0 ? first : further;
    for (std::size_t r = 0; k > 0 && r < results_.size(); ++r) {
      pass.input(results_[r].input, levels_[k - 1].results[r]);
    }
    pass.set("source_count", source);
    pass.set("result_count", level.rows);
    pass.set_rows(level.results.front(), lists_ * level.rows);
    pass.draw(level.target);
    source = level.rows;
  }
}

}  // namespace phymul::gl
