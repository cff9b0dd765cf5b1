// SPDX-License-Identifier: MIT
#include "pass.h"

#include <phymul/error.h>

#include <algorithm>

#include "gl/context/guard_state.h"

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

namespace {

constexpr unsigned passes_between_looks = 256;
constexpr GLenum gpu_disjoint = 0x8FBB;  // GL_GPU_DISJOINT_EXT, which the desktop's headers lack

}  // namespace

thread_local PassTimer* PassTimer::current_ = nullptr;

/// llvmpipe (Mesa 22.3) times what it rasterizes: a dispatch of 2 ms counts as 2 ns. It is done when the call returns,
/// so the thread's clock has it.
PassTimer::PassTimer(const ContextInfo& info, Profile& profile)
    : profile_(profile), es_(info.es), times_dispatches_(!info.software) {
  if (es_ && !info.has("GL_EXT_disjoint_timer_query")) return;
  GLint bits = 0;
  glGetQueryiv(GL_TIME_ELAPSED, GL_QUERY_COUNTER_BITS, &bits);
  const char* name = es_ ? "glGetQueryObjectui64vEXT" : "glGetQueryObjectui64v";
  get_result_ = reinterpret_cast<decltype(get_result_)>(eglGetProcAddress(name));
  has_queries_ = bits > 0 && get_result_;
  if (es_) static_cast<void>(was_disturbed());  // asking forgets what was before
}

PassTimer::~PassTimer() {
  for (const Pending& pending : pending_) idle_.push_back(pending.query);
  if (!idle_.empty()) glDeleteQueries(static_cast<GLsizei>(idle_.size()), idle_.data());
}

void PassTimer::begin(const std::string& pass, Work work) {
  row_ = profile_.row(pass);
  query_ = 0;
  if (has_queries_ && (work == Work::draw || times_dispatches_)) {
    if (++passes_ % passes_between_looks == 0) collect(false);
    GLint of_host = 0;
    glGetQueryiv(GL_TIME_ELAPSED, GL_CURRENT_QUERY, &of_host);
    if (of_host != 0) {
      profile_.lose_device(row_);
    } else {
      if (idle_.empty()) glGenQueries(1, &idle_.emplace_back());
      query_ = idle_.back();
      idle_.pop_back();
      glBeginQuery(GL_TIME_ELAPSED, query_);
    }
  }
  laps_ = Laps(&profile_);
}

void PassTimer::end() {
  laps_.end(row_);
  if (query_ == 0) return;
  glEndQuery(GL_TIME_ELAPSED);
  pending_.push_back({query_, row_});
}

void PassTimer::collect(bool wait) {
  std::size_t arrived = 0;
  for (; arrived < pending_.size(); ++arrived) {
    GLuint is_there = GL_TRUE;
    if (!wait) glGetQueryObjectuiv(pending_[arrived].query, GL_QUERY_RESULT_AVAILABLE, &is_there);
    if (is_there == GL_FALSE) break;
  }
  if (arrived == 0) return;
  for (std::size_t k = 0; k < arrived; ++k) {
    const auto [query, row] = pending_[k];
    GLuint64 nanoseconds = 0;
    get_result_(query, GL_QUERY_RESULT, &nanoseconds);
    profile_.add_device(row, 1e-9 * static_cast<double>(nanoseconds));
    idle_.push_back(query);
  }
  if (was_disturbed()) {
    for (const Pending& pending : pending_) profile_.lose_device(pending.row);
  }
  pending_.erase(pending_.begin(), pending_.begin() + static_cast<std::ptrdiff_t>(arrived));
}

/// Did something (a change of the device's clock) make the times since the last call worthless?
bool PassTimer::was_disturbed() const {
  if (!es_) return false;
  GLint disturbed = 0;
  glGetIntegerv(gpu_disjoint, &disturbed);
  return disturbed != 0;
}

}  // namespace phymul::gl
