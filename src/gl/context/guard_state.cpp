// SPDX-License-Identifier: MIT
#include "guard_state.h"

#include <algorithm>
#include <array>
#include <initializer_list>
#include <utility>

namespace phymul::gl {
namespace {

void set(GLenum name, bool on) {
  on ? glEnable(name) : glDisable(name);
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
    if (!in_browser) names.push_back(GL_PRIMITIVE_RESTART_FIXED_INDEX);  // always on there, and no name for it
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
  if (in_browser) return false;  // browsers name the extension, but Emscripten 3.1.6 has no function for it
  return info.es ? info.has("GL_EXT_clip_control") : info.at_least(4, 5) || info.has("GL_ARB_clip_control");
}

/// OpenGL 3.3 has these two by numbers of double precision only.
void set_depth_range(bool es, GLfloat near, GLfloat far) {
  es ? glDepthRangef(near, far) : glDepthRange(static_cast<GLdouble>(near), static_cast<GLdouble>(far));
}
void set_clear_depth(bool es, GLfloat depth) {
  es ? glClearDepthf(depth) : glClearDepth(static_cast<GLdouble>(depth));
}

}  // namespace

StateGuard::StateGuard(const ContextInfo& info) : info_(info) {
  keep_bindings();  // comes back last: indexed bindings change those of their targets
  keep_units();
  keep_indexed_buffers(GL_UNIFORM_BUFFER, GL_UNIFORM_BUFFER_BINDING, GL_UNIFORM_BUFFER_START, GL_UNIFORM_BUFFER_SIZE,
                       uniform_buffers);
  if (info_.computes()) {
    const GLint bindings = integer_of(GL_MAX_SHADER_STORAGE_BUFFER_BINDINGS);
    keep_indexed_buffers(GL_SHADER_STORAGE_BUFFER, GL_SHADER_STORAGE_BUFFER_BINDING, GL_SHADER_STORAGE_BUFFER_START,
                         GL_SHADER_STORAGE_BUFFER_SIZE, std::clamp(bindings, 0, storage_buffers));
  }
  keep_numbers();
  if (has_clip_control(info_)) keep_clip_control();
  if (!info_.es) keep_desktop_numbers();
  keep_draw_buffers();
  keep_switches();
  keep_pixel_stores();
}

StateGuard::~StateGuard() {
  for (auto restore = restore_.rbegin(); restore != restore_.rend(); ++restore) (*restore)();
}

template <class Set>
void StateGuard::keep(GLenum name, Set set) {
  later([set, value = integer_of(name)] { set(static_cast<GLuint>(value)); });
}

void StateGuard::keep_bindings() {
  keep(GL_CURRENT_PROGRAM, [](GLuint name) { glUseProgram(name); });
  keep(GL_VERTEX_ARRAY_BINDING, [](GLuint name) { glBindVertexArray(name); });
  keep(GL_DRAW_FRAMEBUFFER_BINDING, [](GLuint name) { glBindFramebuffer(GL_DRAW_FRAMEBUFFER, name); });
  keep(GL_READ_FRAMEBUFFER_BINDING, [](GLuint name) { glBindFramebuffer(GL_READ_FRAMEBUFFER, name); });
  keep(GL_RENDERBUFFER_BINDING, [](GLuint name) { glBindRenderbuffer(GL_RENDERBUFFER, name); });
  glUseProgram(0);
  const auto keep_buffer = [this](GLenum target, GLenum binding) {
    keep(binding, [target](GLuint name) { glBindBuffer(target, name); });
    glBindBuffer(target, 0);
  };
  for (const auto& [target, binding] : buffer_targets) keep_buffer(target, binding);
  if (info_.computes()) keep_buffer(GL_SHADER_STORAGE_BUFFER, GL_SHADER_STORAGE_BUFFER_BINDING);
}

void StateGuard::keep_units() {
  keep(GL_ACTIVE_TEXTURE, [](GLuint unit) { glActiveTexture(unit); });
  for (int k = 0; k < texture_units; ++k) {
    const auto unit = static_cast<GLuint>(k);
    glActiveTexture(GL_TEXTURE0 + unit);
    keep(GL_TEXTURE_BINDING_2D, [](GLuint name) { glBindTexture(GL_TEXTURE_2D, name); });
    keep(GL_TEXTURE_BINDING_2D_ARRAY, [](GLuint name) { glBindTexture(GL_TEXTURE_2D_ARRAY, name); });
    keep(GL_SAMPLER_BINDING, [unit](GLuint name) { glBindSampler(unit, name); });
    later([unit] { glActiveTexture(GL_TEXTURE0 + unit); });
    glBindSampler(unit, 0);
  }
  glActiveTexture(GL_TEXTURE0);
}

void StateGuard::keep_indexed_buffers(GLenum target, GLenum binding, GLenum start, GLenum size, GLint count) {
  for (GLuint index = 0; index < static_cast<GLuint>(count); ++index) {
    GLint name = 0;
    GLint64 first = 0, bytes = 0;
    glGetIntegeri_v(binding, index, &name);
    glGetInteger64i_v(start, index, &first);
    glGetInteger64i_v(size, index, &bytes);
    later([=] {
      if (bytes > 0) {
        glBindBufferRange(target, index, static_cast<GLuint>(name), static_cast<GLintptr>(first),
                          static_cast<GLsizeiptr>(bytes));
      } else {
        glBindBufferBase(target, index, static_cast<GLuint>(name));
      }
    });
  }
}

void StateGuard::keep_numbers() {
  std::array<GLint, 4> viewport{}, scissor{};
  std::array<GLfloat, 4> clear{};
  std::array<GLfloat, 2> range{};
  GLfloat clear_depth = 1.0f;
  GLboolean depth_mask = GL_TRUE;
  glGetIntegerv(GL_VIEWPORT, viewport.data());
  glGetIntegerv(GL_SCISSOR_BOX, scissor.data());
  glGetFloatv(GL_COLOR_CLEAR_VALUE, clear.data());
  glGetFloatv(GL_DEPTH_CLEAR_VALUE, &clear_depth);
  glGetBooleanv(GL_DEPTH_WRITEMASK, &depth_mask);
  glGetFloatv(GL_DEPTH_RANGE, range.data());
  keep(GL_DEPTH_FUNC, [](GLuint function) { glDepthFunc(function); });
  later([=, es = info_.es] {
    glViewport(viewport[0], viewport[1], viewport[2], viewport[3]);
    glScissor(scissor[0], scissor[1], scissor[2], scissor[3]);
    glClearColor(clear[0], clear[1], clear[2], clear[3]);
    set_clear_depth(es, clear_depth);
    glDepthMask(depth_mask);
    set_depth_range(es, range[0], range[1]);
  });
  glDepthMask(GL_TRUE);
  glDepthFunc(GL_LESS);
  set_depth_range(info_.es, 0.0f, 1.0f);
}

void StateGuard::keep_clip_control() {
  const auto set = info_.es ? glClipControlEXT : glClipControl;
  const auto origin = static_cast<GLenum>(integer_of(GL_CLIP_ORIGIN)),
             depth = static_cast<GLenum>(integer_of(GL_CLIP_DEPTH_MODE));
  later([=] { set(origin, depth); });
  set(GL_LOWER_LEFT, GL_NEGATIVE_ONE_TO_ONE);
}

void StateGuard::keep_desktop_numbers() {
  std::array<GLint, 2> mode{GL_FILL, GL_FILL};
  glGetIntegerv(GL_POLYGON_MODE, mode.data());
  later([mode, core = info_.core_profile] {
    glPolygonMode(GL_FRONT_AND_BACK, static_cast<GLenum>(mode[0]));
    if (core || mode[0] == mode[1]) return;  // a core profile has one mode, and drivers tell it once or twice
    glPolygonMode(GL_FRONT, static_cast<GLenum>(mode[0]));
    glPolygonMode(GL_BACK, static_cast<GLenum>(mode[1]));
  });
  glPolygonMode(GL_FRONT_AND_BACK, GL_FILL);
  keep(GL_CLAMP_READ_COLOR, [](GLuint value) { glClampColor(GL_CLAMP_READ_COLOR, value); });
  glClampColor(GL_CLAMP_READ_COLOR, GL_FIXED_ONLY);
  if (info_.core_profile) return;
  keep(GL_CLAMP_FRAGMENT_COLOR, [](GLuint value) { glClampColor(GL_CLAMP_FRAGMENT_COLOR, value); });
  glClampColor(GL_CLAMP_FRAGMENT_COLOR, GL_FIXED_ONLY);
}

void StateGuard::keep_draw_buffers() {
  const bool indexed = !info_.es || info_.at_least(3, 2);
  std::array<GLboolean, 4> mask{};
  for (GLuint index = 0; index < (indexed ? static_cast<GLuint>(info_.max_draw_buffers) : 1); ++index) {
    if (!indexed) {
      glGetBooleanv(GL_COLOR_WRITEMASK, mask.data());
      later([mask, blend = glIsEnabled(GL_BLEND)] {
        glColorMask(mask[0], mask[1], mask[2], mask[3]);
        set(GL_BLEND, blend);
      });
      continue;
    }
    glGetBooleani_v(GL_COLOR_WRITEMASK, index, mask.data());
    later([mask, index, blend = glIsEnabledi(GL_BLEND, index)] {
      glColorMaski(index, mask[0], mask[1], mask[2], mask[3]);
      (blend ? glEnablei : glDisablei)(GL_BLEND, index);
    });
  }
  glDisable(GL_BLEND);
  glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
}

void StateGuard::keep_switches() {
  for (const GLenum name : switches_of(info_)) {
    later([name, on = glIsEnabled(name)] { set(name, on); });
    glDisable(name);
  }
}

void StateGuard::keep_pixel_stores() {
  for (const PixelStore& store : pixel_stores) {
    if (info_.es && !store.in_es) continue;
    keep(store.name, [name = store.name](GLuint value) { glPixelStorei(name, static_cast<GLint>(value)); });
    glPixelStorei(store.name, store.fresh);
  }
}

}  // namespace phymul::gl
