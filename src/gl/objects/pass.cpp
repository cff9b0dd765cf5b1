// SPDX-License-Identifier: MIT
#include "pass.h"

#include <phymul/error.h>

#include <algorithm>

#include "gl/context/guard_state.h"
#include "pass_timer.h"

namespace phymul::gl {

Pass::Pass(const ShaderLibrary& library, const ShaderRequest& request)
    : name_(request.name()), program_(library, request) {}

void Pass::input(const char* name, const Texture& texture) {
  for (Input& input : inputs_) {
    if (input.name != name) continue;
    input.texture = texture.id();
    if (input.log2_width == texture.log2_width()) return;
    input.log2_width = texture.log2_width();
    glUseProgram(program_.id());
    glUniform1i(input.place_location, input.log2_width);
    return;
  }
  if (std::find(unused_.begin(), unused_.end(), name) != unused_.end()) return;
  const GLint sampler = program_.uniform(name);
  if (sampler < 0) {
    unused_.emplace_back(name);
    return;
  }
  if (inputs_.size() == StateGuard::texture_units) {
    throw Error(name_ + " reads more than the " + std::to_string(StateGuard::texture_units) +
                " textures that every driver binds at a time");
  }
  const GLint place_location = program_.uniform((std::string(name) + "_place").c_str());
  glUseProgram(program_.id());
  glUniform1i(sampler, static_cast<GLint>(inputs_.size()));
  glUniform1i(place_location, texture.log2_width());
  inputs_.push_back({name, texture.id(), texture.kind(), texture.log2_width(), place_location});
}

void Pass::set_rows(const Texture& target, int rows) {
  set("target_log2", target.log2_width());
  set("row_count", rows);
  lines_ = (rows + target.shape().width - 1) / target.shape().width;
}

void Pass::draw(const Framebuffer& target) {
  const PassTimer::Timed timed(name_, PassTimer::Work::draw);
  glUseProgram(program_.id());
  for (std::size_t unit = 0; unit < inputs_.size(); ++unit) {
    glActiveTexture(static_cast<GLenum>(GL_TEXTURE0 + unit));
    glBindTexture(inputs_[unit].kind, inputs_[unit].texture);
  }
  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, target.id());
  glViewport(0, 0, target.shape().width, lines_);
  glDrawArrays(GL_TRIANGLES, 0, 3);
}

}  // namespace phymul::gl
