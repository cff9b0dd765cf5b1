// SPDX-License-Identifier: MIT
#include "guard_state.h"

#include <algorithm>
#include <initializer_list>

namespace phymul::gl {
namespace {

GLint integer_of(GLenum name) {
  GLint value = 0;
  glGetIntegerv(name, &value);
  return value;
}

void set(GLenum name, bool on) {
  if (on) {
    glEnable(name);
  } else {
    glDisable(name);
  }
}

void set_indexed(GLenum name, GLuint index, bool on) {
  if (on) {
    glEnablei(name, index);
  } else {
    glDisablei(name, index);
  }
}

constexpr std::initializer_list<std::pair<GLenum, GLenum>> buffer_targets{
    {GL_PIXEL_PACK_BUFFER, GL_PIXEL_PACK_BUFFER_BINDING}, {GL_PIXEL_UNPACK_BUFFER, GL_PIXEL_UNPACK_BUFFER_BINDING},
    {GL_ARRAY_BUFFER, GL_ARRAY_BUFFER_BINDING},           {GL_UNIFORM_BUFFER, GL_UNIFORM_BUFFER_BINDING},
    {GL_COPY_READ_BUFFER, GL_COPY_READ_BUFFER},           {GL_COPY_WRITE_BUFFER, GL_COPY_WRITE_BUFFER}};

/// Value of a fresh context.
struct PixelStore {
  GLenum name;
  GLint fresh;
  bool in_es;
};
constexpr std::initializer_list<PixelStore> pixel_stores{
    {GL_PACK_ALIGNMENT, 4, true},     {GL_PACK_ROW_LENGTH, 0, true},    {GL_PACK_SKIP_ROWS, 0, true},
    {GL_PACK_SKIP_PIXELS, 0, true},   {GL_UNPACK_ALIGNMENT, 4, true},   {GL_UNPACK_ROW_LENGTH, 0, true},
    {GL_UNPACK_SKIP_ROWS, 0, true},   {GL_UNPACK_SKIP_PIXELS, 0, true}, {GL_UNPACK_IMAGE_HEIGHT, 0, true},
    {GL_UNPACK_SKIP_IMAGES, 0, true}, {GL_PACK_SWAP_BYTES, 0, false},   {GL_PACK_LSB_FIRST, 0, false},
    {GL_PACK_IMAGE_HEIGHT, 0, false}, {GL_PACK_SKIP_IMAGES, 0, false},  {GL_UNPACK_SWAP_BYTES, 0, false},
    {GL_UNPACK_LSB_FIRST, 0, false}};

/// All off in a fresh context but dithering and multisampling, of which neither touches a float texture's texel.
std::vector<GLenum> switches_of(const ContextInfo& info) {
  std::vector<GLenum> names{
      GL_DEPTH_TEST,     GL_STENCIL_TEST,       GL_SCISSOR_TEST,        GL_CULL_FACE,
      GL_DITHER,         GL_RASTERIZER_DISCARD, GL_POLYGON_OFFSET_FILL, GL_SAMPLE_ALPHA_TO_COVERAGE,
      GL_SAMPLE_COVERAGE};
  if (info.es) {
    names.push_back(GL_PRIMITIVE_RESTART_FIXED_INDEX);
    if (info.at_least(3, 1)) names.push_back(GL_SAMPLE_MASK);
    return names;
  }
  names.insert(names.end(), {GL_PRIMITIVE_RESTART, GL_SAMPLE_MASK, GL_FRAMEBUFFER_SRGB, GL_COLOR_LOGIC_OP,
                             GL_DEPTH_CLAMP, GL_PROGRAM_POINT_SIZE, GL_POLYGON_SMOOTH, GL_LINE_SMOOTH});
  for (GLenum plane = 0; plane < 8; ++plane) names.push_back(GL_CLIP_DISTANCE0 + plane);
  if (info.at_least(4, 3)) names.push_back(GL_PRIMITIVE_RESTART_FIXED_INDEX);
  if (!info.core_profile) names.insert(names.end(), {GL_ALPHA_TEST, GL_POLYGON_STIPPLE});
  return names;
}

/// Where pictures stand upright and which depths are seen.
bool has_clip_control(const ContextInfo& info) {
  return info.es ? info.has("GL_EXT_clip_control") : info.at_least(4, 5) || info.has("GL_ARB_clip_control");
}

void set_clip_control(const ContextInfo& info, GLenum origin, GLenum depth) {
  if (!has_clip_control(info)) return;
  if (info.es) {
    glClipControlEXT(origin, depth);
  } else {
    glClipControl(origin, depth);
  }
}

void set_depth_range(const ContextInfo& info, GLfloat near, GLfloat far) {
  if (info.es) {
    glDepthRangef(near, far);
  } else {
    glDepthRange(static_cast<GLdouble>(near), static_cast<GLdouble>(far));
  }
}

}  // namespace

StateGuard::StateGuard(const ContextInfo& info) : info_(info) {
  save_objects();
  save_units();
  save_indexed_buffers();
  save_draw_buffers();
  save_switches();
  save_pixels();
  set_defaults();
}

StateGuard::~StateGuard() {
  restore_units();
  restore_indexed_buffers();
  restore_objects();
  for (const auto& [name, on] : switches_) set(name, on);
  restore_draw_buffers();
  restore_pixels();
}

bool StateGuard::has_indexed_switches() const {
  return !info_.es || info_.at_least(3, 2);
}

void StateGuard::save_objects() {
  program_ = integer_of(GL_CURRENT_PROGRAM);
  vertex_array_ = integer_of(GL_VERTEX_ARRAY_BINDING);
  draw_framebuffer_ = integer_of(GL_DRAW_FRAMEBUFFER_BINDING);
  read_framebuffer_ = integer_of(GL_READ_FRAMEBUFFER_BINDING);
  renderbuffer_ = integer_of(GL_RENDERBUFFER_BINDING);
  for (const auto& [target, binding] : buffer_targets) buffers_.emplace_back(target, integer_of(binding));
  glGetIntegerv(GL_VIEWPORT, viewport_.data());
  glGetIntegerv(GL_SCISSOR_BOX, scissor_.data());
  glGetFloatv(GL_COLOR_CLEAR_VALUE, clear_color_.data());
  glGetFloatv(GL_DEPTH_CLEAR_VALUE, &clear_depth_);
  glGetBooleanv(GL_DEPTH_WRITEMASK, &depth_mask_);
  depth_function_ = integer_of(GL_DEPTH_FUNC);
  glGetFloatv(GL_DEPTH_RANGE, depth_range_.data());
  if (has_clip_control(info_)) {
    clip_origin_ = integer_of(GL_CLIP_ORIGIN);
    clip_depth_ = integer_of(GL_CLIP_DEPTH_MODE);
  }
  if (info_.es) return;
  glGetIntegerv(GL_POLYGON_MODE, polygon_mode_.data());
  clamp_read_ = integer_of(GL_CLAMP_READ_COLOR);
  if (!info_.core_profile) clamp_fragment_ = integer_of(GL_CLAMP_FRAGMENT_COLOR);
}

void StateGuard::save_units() {
  active_unit_ = integer_of(GL_ACTIVE_TEXTURE);
  units_.resize(static_cast<std::size_t>(std::min(texture_units, info_.max_texture_units)));
  for (std::size_t i = 0; i < units_.size(); ++i) {
    glActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(i));
    units_[i] = {integer_of(GL_TEXTURE_BINDING_2D), integer_of(GL_TEXTURE_BINDING_2D_ARRAY),
                 integer_of(GL_SAMPLER_BINDING)};
  }
}

void StateGuard::save_indexed_buffers() {
  const auto save = [](GLenum binding, GLenum start, GLenum size, std::vector<IndexedBuffer>& buffers) {
    for (std::size_t i = 0; i < buffers.size(); ++i) {
      const GLuint index = static_cast<GLuint>(i);
      glGetIntegeri_v(binding, index, &buffers[i].name);
      glGetInteger64i_v(start, index, &buffers[i].start);
      glGetInteger64i_v(size, index, &buffers[i].size);
    }
  };
  uniform_buffers_.resize(uniform_buffers);
  save(GL_UNIFORM_BUFFER_BINDING, GL_UNIFORM_BUFFER_START, GL_UNIFORM_BUFFER_SIZE, uniform_buffers_);
  if (!info_.computes()) return;
  buffers_.emplace_back(GL_SHADER_STORAGE_BUFFER, integer_of(GL_SHADER_STORAGE_BUFFER_BINDING));
  const GLint bindings = integer_of(GL_MAX_SHADER_STORAGE_BUFFER_BINDINGS);
  storage_buffers_.resize(static_cast<std::size_t>(std::clamp(bindings, 0, storage_buffers)));
  save(GL_SHADER_STORAGE_BUFFER_BINDING, GL_SHADER_STORAGE_BUFFER_START, GL_SHADER_STORAGE_BUFFER_SIZE,
       storage_buffers_);
}

void StateGuard::save_draw_buffers() {
  draw_buffers_.resize(has_indexed_switches() ? static_cast<std::size_t>(info_.max_draw_buffers) : 1);
  if (!has_indexed_switches()) {
    glGetBooleanv(GL_COLOR_WRITEMASK, draw_buffers_[0].mask.data());
    draw_buffers_[0].blend = glIsEnabled(GL_BLEND);
    return;
  }
  for (std::size_t i = 0; i < draw_buffers_.size(); ++i) {
    glGetBooleani_v(GL_COLOR_WRITEMASK, static_cast<GLuint>(i), draw_buffers_[i].mask.data());
    draw_buffers_[i].blend = glIsEnabledi(GL_BLEND, static_cast<GLuint>(i));
  }
}

void StateGuard::save_switches() {
  for (const GLenum name : switches_of(info_)) switches_.emplace_back(name, glIsEnabled(name));
}

void StateGuard::save_pixels() {
  for (const PixelStore& store : pixel_stores) {
    if (store.in_es || !info_.es) pixels_.emplace_back(store.name, integer_of(store.name));
  }
}

void StateGuard::set_defaults() {
  glUseProgram(0);
  for (const auto& [target, name] : buffers_) glBindBuffer(target, 0);
  for (std::size_t i = 0; i < units_.size(); ++i) glBindSampler(static_cast<GLuint>(i), 0);
  glActiveTexture(GL_TEXTURE0);
  for (const auto& [name, on] : switches_) set(name, false);
  glDisable(GL_BLEND);
  glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
  glDepthMask(GL_TRUE);
  glDepthFunc(GL_LESS);
  set_depth_range(info_, 0.0f, 1.0f);
  set_clip_control(info_, GL_LOWER_LEFT, GL_NEGATIVE_ONE_TO_ONE);
  for (const PixelStore& store : pixel_stores) {
    if (store.in_es || !info_.es) glPixelStorei(store.name, store.fresh);
  }
  if (info_.es) return;
  glPolygonMode(GL_FRONT_AND_BACK, GL_FILL);
  glClampColor(GL_CLAMP_READ_COLOR, GL_FIXED_ONLY);
  if (!info_.core_profile) glClampColor(GL_CLAMP_FRAGMENT_COLOR, GL_FIXED_ONLY);
}

void StateGuard::restore_objects() const {
  glUseProgram(static_cast<GLuint>(program_));
  glBindVertexArray(static_cast<GLuint>(vertex_array_));
  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, static_cast<GLuint>(draw_framebuffer_));
  glBindFramebuffer(GL_READ_FRAMEBUFFER, static_cast<GLuint>(read_framebuffer_));
  glBindRenderbuffer(GL_RENDERBUFFER, static_cast<GLuint>(renderbuffer_));
  for (const auto& [target, name] : buffers_) glBindBuffer(target, static_cast<GLuint>(name));
  glViewport(viewport_[0], viewport_[1], viewport_[2], viewport_[3]);
  glScissor(scissor_[0], scissor_[1], scissor_[2], scissor_[3]);
  glClearColor(clear_color_[0], clear_color_[1], clear_color_[2], clear_color_[3]);
  if (info_.es) {
    glClearDepthf(clear_depth_);
  } else {
    glClearDepth(static_cast<GLdouble>(clear_depth_));
  }
  glDepthMask(depth_mask_);
  glDepthFunc(static_cast<GLenum>(depth_function_));
  set_depth_range(info_, depth_range_[0], depth_range_[1]);
  set_clip_control(info_, static_cast<GLenum>(clip_origin_), static_cast<GLenum>(clip_depth_));
  if (info_.es) return;
  glPolygonMode(GL_FRONT_AND_BACK, static_cast<GLenum>(polygon_mode_[0]));
  glClampColor(GL_CLAMP_READ_COLOR, static_cast<GLenum>(clamp_read_));
  if (!info_.core_profile) {
    if (polygon_mode_[0] != polygon_mode_[1]) {
      glPolygonMode(GL_FRONT, static_cast<GLenum>(polygon_mode_[0]));
      glPolygonMode(GL_BACK, static_cast<GLenum>(polygon_mode_[1]));
    }
    glClampColor(GL_CLAMP_FRAGMENT_COLOR, static_cast<GLenum>(clamp_fragment_));
  }
}

void StateGuard::restore_units() const {
  for (std::size_t i = 0; i < units_.size(); ++i) {
    glActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(i));
    glBindTexture(GL_TEXTURE_2D, static_cast<GLuint>(units_[i].texture_2d));
    glBindTexture(GL_TEXTURE_2D_ARRAY, static_cast<GLuint>(units_[i].texture_2d_array));
    glBindSampler(static_cast<GLuint>(i), static_cast<GLuint>(units_[i].sampler));
  }
  glActiveTexture(static_cast<GLenum>(active_unit_));
}

void StateGuard::restore_indexed_buffers() const {
  const auto restore = [](GLenum target, const std::vector<IndexedBuffer>& buffers) {
    for (std::size_t i = 0; i < buffers.size(); ++i) {
      const IndexedBuffer& buffer = buffers[i];
      const GLuint index = static_cast<GLuint>(i), name = static_cast<GLuint>(buffer.name);
      if (buffer.size > 0) {
        glBindBufferRange(target, index, name, static_cast<GLintptr>(buffer.start),
                          static_cast<GLsizeiptr>(buffer.size));
      } else {
        glBindBufferBase(target, index, name);
      }
    }
  };
  restore(GL_UNIFORM_BUFFER, uniform_buffers_);
  restore(GL_SHADER_STORAGE_BUFFER, storage_buffers_);
}

void StateGuard::restore_draw_buffers() const {
  const auto& first = draw_buffers_[0];
  if (!has_indexed_switches()) {
    glColorMask(first.mask[0], first.mask[1], first.mask[2], first.mask[3]);
    set(GL_BLEND, first.blend);
    return;
  }
  for (std::size_t i = 0; i < draw_buffers_.size(); ++i) {
    const DrawBuffer& buffer = draw_buffers_[i];
    const GLuint index = static_cast<GLuint>(i);
    glColorMaski(index, buffer.mask[0], buffer.mask[1], buffer.mask[2], buffer.mask[3]);
    set_indexed(GL_BLEND, index, buffer.blend);
  }
}

void StateGuard::restore_pixels() const {
  for (const auto& [name, value] : pixels_) glPixelStorei(name, value);
}

}  // namespace phymul::gl
