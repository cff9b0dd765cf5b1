// SPDX-License-Identifier: MIT
#include "fragment_volumes.h"

namespace phymul::gl {

FragmentVolumes::FragmentVolumes(const FloatVolumes& volumes)
    : count_(volumes.count()), particles_(static_cast<int>(volumes.ranges.size())) {
  tables_.add("kept_laws", volumes.laws);
  tables_.add("kept_ranges", volumes.ranges);
  tables_.add("kept_around", volumes.around);
  tables_.add("kept_facets", volumes.facets);
  tables_.add("kept_edges", volumes.edges);
  tables_.add("kept_nodes", volumes.nodes);
  for (Texture& texture : free_) texture = Texture::target(particles_, "free steps");
  along_ = Texture::target(particles_, "ways of kept volumes");
  free_target_ = Framebuffer({{&free_[0]}, {&free_[1]}, {&free_[2]}});
  along_target_ = Framebuffer({{&along_}});
  for (const Int4& nodes : volumes.levels) {
    Level& level = levels_.emplace_back();
    level.first_node = nodes[0];
    level.rows = nodes[1] - nodes[0];
    level.sums = Texture::target(level.rows, "sums of kept volumes");
    level.target = Framebuffer({{&level.sums}});
  }
  for (std::size_t turn = 0; turn < roots_.size(); ++turn) {
    roots_[turn] = Texture::target(count_, "ways of kept volumes");
    root_targets_[turn] = Framebuffer({{&roots_[turn]}});
  }
}

void FragmentVolumes::bind(Pass& pass) const {
  tables_.bind(pass);
  pass.input("kept_along", along_);
  pass.input("free_displacement", free_[0]);
  pass.input("free_velocity", free_[1]);
  pass.input("free_acceleration", free_[2]);
}

void FragmentVolumes::follow_gradient(Pass& along) {
  along.set_rows(along_, particles_);
  along.draw(along_target_);
}

void FragmentVolumes::sum(Pass& facets, Pass& sums) {
  for (std::size_t k = 0; k < levels_.size(); ++k) {
    Pass& pass = k == 0 ? facets : sums;
    if (k == 0) {
      pass.input("displacement", free_[0]);
    } else {
      pass.input("kept_sums", levels_[k - 1].sums);
      pass.set("kept_first_source", levels_[k - 1].first_node);
    }
    pass.set("kept_first_node", levels_[k].first_node);
    pass.set_rows(levels_[k].sums, levels_[k].rows);
    pass.draw(levels_[k].target);
  }
}

void FragmentVolumes::find_roots(Pass& roots, int batch_step) {
  roots.input("kept_sums", levels_.back().sums);
  roots.input("kept_roots", roots_[turn_]);
  turn_ = 1 - turn_;
  roots.set("kept_first_total", 0);
  roots.set("kept_step", batch_step);
  roots.set_rows(roots_[turn_], count_);
  roots.draw(root_targets_[turn_]);
}

void FragmentVolumes::bind_roots(Pass& step) const {
  step.input("kept_roots", roots_[turn_]);
}

void FragmentVolumes::copy(std::size_t offset) const {
  root_targets_[turn_].read(0, GL_RGBA, GL_FLOAT, reinterpret_cast<void*>(offset));  // an offset in the buffer
}

}  // namespace phymul::gl
