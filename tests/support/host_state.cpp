// SPDX-License-Identifier: MIT
#include "host_state.h"

#include <array>

namespace phymul::test {
namespace {

struct Named {
  GLenum value;
  const char* name;
  int count = 1;  ///< numbers that glGet gives
};
#define N(x) GL_##x, #x  // NOLINT(readability-identifier-naming): of this table alone

const std::vector<Named> numbers{{N(CURRENT_PROGRAM)},
                                 {N(VERTEX_ARRAY_BINDING)},
                                 {N(DRAW_FRAMEBUFFER_BINDING)},
                                 {N(READ_FRAMEBUFFER_BINDING)},
                                 {N(RENDERBUFFER_BINDING)},
                                 {N(ACTIVE_TEXTURE)},
                                 {N(VIEWPORT), 4},
                                 {N(SCISSOR_BOX), 4},
                                 {N(COLOR_CLEAR_VALUE), 4},
                                 {N(DEPTH_CLEAR_VALUE)},
                                 {N(STENCIL_CLEAR_VALUE)},
                                 {N(DEPTH_WRITEMASK)},
                                 {N(DEPTH_FUNC)},
                                 {N(DEPTH_RANGE), 2},
                                 {N(STENCIL_FUNC)},
                                 {N(STENCIL_REF)},
                                 {N(STENCIL_VALUE_MASK)},
                                 {N(STENCIL_WRITEMASK)},
                                 {N(CULL_FACE_MODE)},
                                 {N(FRONT_FACE)},
                                 {N(LINE_WIDTH)},
                                 {N(POLYGON_OFFSET_FACTOR)},
                                 {N(POLYGON_OFFSET_UNITS)},
                                 {N(BLEND_COLOR), 4},
                                 {N(BLEND_SRC_RGB)},
                                 {N(BLEND_DST_RGB)},
                                 {N(BLEND_EQUATION_RGB)},
                                 {N(SAMPLE_COVERAGE_VALUE)},
                                 {N(SAMPLE_COVERAGE_INVERT)},
                                 {N(READ_BUFFER)},
                                 {N(DRAW_BUFFER0)},
                                 {N(ARRAY_BUFFER_BINDING)},
                                 {N(ELEMENT_ARRAY_BUFFER_BINDING)},
                                 {N(PIXEL_PACK_BUFFER_BINDING)},
                                 {N(PIXEL_UNPACK_BUFFER_BINDING)},
                                 {N(UNIFORM_BUFFER_BINDING)},
                                 {N(COPY_READ_BUFFER)},
                                 {N(COPY_WRITE_BUFFER)},
                                 {N(TRANSFORM_FEEDBACK_BUFFER_BINDING)},
                                 {N(PACK_ALIGNMENT)},
                                 {N(PACK_ROW_LENGTH)},
                                 {N(PACK_SKIP_ROWS)},
                                 {N(PACK_SKIP_PIXELS)},
                                 {N(UNPACK_ALIGNMENT)},
                                 {N(UNPACK_ROW_LENGTH)},
                                 {N(UNPACK_SKIP_ROWS)},
                                 {N(UNPACK_SKIP_PIXELS)},
                                 {N(UNPACK_IMAGE_HEIGHT)},
                                 {N(UNPACK_SKIP_IMAGES)}};
const std::vector<Named> desktop_numbers{{N(POLYGON_MODE), 2},   {N(CLAMP_READ_COLOR)},  {N(PACK_SWAP_BYTES)},
                                         {N(PACK_LSB_FIRST)},    {N(PACK_IMAGE_HEIGHT)}, {N(PACK_SKIP_IMAGES)},
                                         {N(UNPACK_SWAP_BYTES)}, {N(UNPACK_LSB_FIRST)},  {N(LOGIC_OP_MODE)},
                                         {N(POINT_SIZE)},        {N(PROVOKING_VERTEX)},  {N(PRIMITIVE_RESTART_INDEX)}};
const std::vector<Named> switches{{N(DEPTH_TEST)},          {N(STENCIL_TEST)},    {N(SCISSOR_TEST)},
                                  {N(CULL_FACE)},           {N(DITHER)},          {N(RASTERIZER_DISCARD)},
                                  {N(POLYGON_OFFSET_FILL)}, {N(SAMPLE_COVERAGE)}, {N(SAMPLE_ALPHA_TO_COVERAGE)}};
const std::vector<Named> desktop_switches{{N(PRIMITIVE_RESTART)},  {N(SAMPLE_MASK)}, {N(FRAMEBUFFER_SRGB)},
                                          {N(COLOR_LOGIC_OP)},     {N(DEPTH_CLAMP)}, {N(POLYGON_SMOOTH)},
                                          {N(PROGRAM_POINT_SIZE)}, {N(LINE_SMOOTH)}, {N(CLIP_DISTANCE0)},
                                          {N(CLIP_DISTANCE5)},     {N(MULTISAMPLE)}};
#undef N

constexpr int units = 16;

template <class... Lists>
std::vector<Named> joined(const Lists&... lists) {
  std::vector<Named> all;
  (all.insert(all.end(), lists.begin(), lists.end()), ...);
  return all;
}

std::vector<Named> switches_of(const gl::ContextInfo& info) {
  std::vector<Named> all = info.es ? switches : joined(switches, desktop_switches);
  if (!info.core_profile) all.push_back({GL_ALPHA_TEST, "ALPHA_TEST"});
  return all;
}

bool has_clip_control(const gl::ContextInfo& info) {
  return info.es ? info.has("GL_EXT_clip_control") : info.at_least(4, 5) || info.has("GL_ARB_clip_control");
}

void set_clip_control(const gl::ContextInfo& info, GLenum origin, GLenum depth) {
  if (has_clip_control(info)) (info.es ? glClipControlEXT : glClipControl)(origin, depth);
}

bool has_indexed(const gl::ContextInfo& info) {
  return !info.es || info.at_least(3, 2);
}

void note_units(HostState& state) {
  GLint active = 0;
  glGetIntegerv(GL_ACTIVE_TEXTURE, &active);
  for (int i = 0; i < units; ++i) {
    glActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(i));
    GLint flat = 0, layered = 0, cube = 0, sampler = 0;
    glGetIntegerv(GL_TEXTURE_BINDING_2D, &flat);
    glGetIntegerv(GL_TEXTURE_BINDING_2D_ARRAY, &layered);
    glGetIntegerv(GL_TEXTURE_BINDING_CUBE_MAP, &cube);
    glGetIntegerv(GL_SAMPLER_BINDING, &sampler);
    state["unit " + std::to_string(i)] = {double(flat), double(layered), double(cube), double(sampler)};
  }
  glActiveTexture(static_cast<GLenum>(active));
}

void note_storage_buffers(HostState& state) {
  GLint bound = 0;
  glGetIntegerv(GL_SHADER_STORAGE_BUFFER_BINDING, &bound);
  state["storage buffer"] = {double(bound)};
  for (GLuint i = 0; i < 6; ++i) {
    GLint name = 0;
    GLint64 start = 0, size = 0;
    glGetIntegeri_v(GL_SHADER_STORAGE_BUFFER_BINDING, i, &name);
    glGetInteger64i_v(GL_SHADER_STORAGE_BUFFER_START, i, &start);
    glGetInteger64i_v(GL_SHADER_STORAGE_BUFFER_SIZE, i, &size);
    state["storage buffer " + std::to_string(i)] = {double(name), double(start), double(size)};
  }
}

void note_indexed(const gl::ContextInfo& info, HostState& state) {
  for (GLuint i = 0; i < 4; ++i) {
    GLint name = 0;
    GLint64 start = 0, size = 0;
    glGetIntegeri_v(GL_UNIFORM_BUFFER_BINDING, i, &name);
    glGetInteger64i_v(GL_UNIFORM_BUFFER_START, i, &start);
    glGetInteger64i_v(GL_UNIFORM_BUFFER_SIZE, i, &size);
    state["uniform buffer " + std::to_string(i)] = {double(name), double(start), double(size)};
  }
  for (GLuint i = 0; i < (has_indexed(info) ? 4u : 1u); ++i) {
    std::array<GLboolean, 4> mask{};
    GLboolean blend = GL_FALSE;
    if (has_indexed(info)) {
      glGetBooleani_v(GL_COLOR_WRITEMASK, i, mask.data());
      blend = glIsEnabledi(GL_BLEND, i);
    } else {
      glGetBooleanv(GL_COLOR_WRITEMASK, mask.data());
      blend = glIsEnabled(GL_BLEND);
    }
    state["draw buffer " + std::to_string(i)] = {double(mask[0]), double(mask[1]), double(mask[2]), double(mask[3]),
                                                 double(blend)};
  }
}

GLuint linked(const gl::ContextInfo& info, const char* vertex_source, const char* fragment_source) {
  const GLuint program = glCreateProgram();
  for (const auto& [kind, source] :
       {std::pair{GL_VERTEX_SHADER, vertex_source}, {GL_FRAGMENT_SHADER, fragment_source}}) {
    const char* const parts[] = {info.es ? "#version 300 es\n" : "#version 330 core\n", source};
    const GLuint shader = glCreateShader(static_cast<GLenum>(kind));
    glShaderSource(shader, 2, parts, nullptr);
    glCompileShader(shader);
    glAttachShader(program, shader);
    glDeleteShader(shader);
  }
  glLinkProgram(program);
  return program;
}

}  // namespace

HostState host_state(const gl::ContextInfo& info) {
  HostState state;
  for (const Named& number : info.es ? numbers : joined(numbers, desktop_numbers)) {
    std::array<GLfloat, 4> values{};
    glGetFloatv(number.value, values.data());
    state[number.name].assign(values.begin(), values.begin() + number.count);
  }
  if (has_clip_control(info)) {
    GLint origin = 0, depth = 0;
    glGetIntegerv(GL_CLIP_ORIGIN, &origin);
    glGetIntegerv(GL_CLIP_DEPTH_MODE, &depth);
    state["CLIP_ORIGIN"] = {double(origin)};
    state["CLIP_DEPTH_MODE"] = {double(depth)};
  }
  for (const Named& one : switches_of(info)) state[one.name] = {double(glIsEnabled(one.value))};
  note_units(state);
  note_indexed(info, state);
  if (info.computes()) note_storage_buffers(state);
  state["error"] = {double(glGetError())};
  return state;
}

std::string differences(const HostState& before, const HostState& after) {
  std::string text;
  const auto list = [](const std::vector<double>& values) {
    std::string all;
    for (const double value : values) all += " " + std::to_string(value);
    return all;
  };
  for (const auto& [name, values] : before) {
    if (after.at(name) != values) text += name + ":" + list(values) + " became" + list(after.at(name)) + "\n";
  }
  return text;
}

HostileHost::HostileHost(const gl::ContextInfo& info) : info_(info) {
  bind_objects();
  bind_textures();
  set_numbers();
  set_switches(true);
}

HostileHost::~HostileHost() {
  set_switches(false);
  glUseProgram(0);
  glDeleteProgram(program_);
  glDeleteVertexArrays(1, &vertex_array_);
  glDeleteRenderbuffers(1, &renderbuffer_);
  glDeleteFramebuffers(static_cast<GLsizei>(framebuffers_.size()), framebuffers_.data());
  glDeleteBuffers(static_cast<GLsizei>(buffers_.size()), buffers_.data());
  glDeleteTextures(static_cast<GLsizei>(textures_.size()), textures_.data());
  glDeleteSamplers(static_cast<GLsizei>(samplers_.size()), samplers_.data());
}

void HostileHost::bind_objects() {
  program_ = linked(info_, "void main() { gl_Position = vec4(0.0); }",
                    "out highp vec4 color; void main() { color = vec4(1.0); }");
  glUseProgram(program_);
  glGenVertexArrays(1, &vertex_array_);
  glBindVertexArray(vertex_array_);
  framebuffers_.resize(2);
  glGenFramebuffers(2, framebuffers_.data());
  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, framebuffers_[0]);
  glBindFramebuffer(GL_READ_FRAMEBUFFER, framebuffers_[1]);
  glGenRenderbuffers(1, &renderbuffer_);
  glBindRenderbuffer(GL_RENDERBUFFER, renderbuffer_);

  buffers_.resize(9);
  glGenBuffers(9, buffers_.data());
  const std::array targets{GL_ARRAY_BUFFER,     GL_ELEMENT_ARRAY_BUFFER, GL_PIXEL_PACK_BUFFER, GL_PIXEL_UNPACK_BUFFER,
                           GL_COPY_READ_BUFFER, GL_COPY_WRITE_BUFFER,    GL_UNIFORM_BUFFER};
  for (std::size_t i = 0; i < targets.size(); ++i) {
    glBindBuffer(static_cast<GLenum>(targets[i]), buffers_[i]);
    glBufferData(static_cast<GLenum>(targets[i]), 4096, nullptr, GL_STATIC_DRAW);
  }
  glBindBufferRange(GL_UNIFORM_BUFFER, 0, buffers_[6], 256, 512);
  glBindBufferBase(GL_UNIFORM_BUFFER, 2, buffers_[6]);
  glBindBuffer(GL_UNIFORM_BUFFER, buffers_[7]);
  if (!info_.computes()) return;
  glBindBuffer(GL_SHADER_STORAGE_BUFFER, buffers_[8]);
  glBufferData(GL_SHADER_STORAGE_BUFFER, 4096, nullptr, GL_STATIC_DRAW);
  for (const GLuint binding : {0u, 1u, 2u}) glBindBufferBase(GL_SHADER_STORAGE_BUFFER, binding, buffers_[8]);
  glBindBufferRange(GL_SHADER_STORAGE_BUFFER, 3, buffers_[6], 256, 512);
  glBindBuffer(GL_SHADER_STORAGE_BUFFER, buffers_[0]);
}

void HostileHost::bind_textures() {
  textures_.resize(3 * units);
  samplers_.resize(units);
  glGenTextures(3 * units, textures_.data());
  glGenSamplers(units, samplers_.data());
  for (std::size_t i = 0; i < units; ++i) {
    glActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(i));
    glBindTexture(GL_TEXTURE_2D, textures_[3 * i]);
    glBindTexture(GL_TEXTURE_2D_ARRAY, textures_[3 * i + 1]);
    glBindTexture(GL_TEXTURE_CUBE_MAP, textures_[3 * i + 2]);
    glBindSampler(static_cast<GLuint>(i), samplers_[i]);
  }
  glActiveTexture(GL_TEXTURE5);
}

void HostileHost::set_numbers() {
  glViewport(1, 2, 3, 4);
  glScissor(5, 6, 1, 1);
  glClearColor(0.25f, 0.5f, 0.75f, 1.0f);
  glClearDepthf(0.5f);
  glDepthFunc(GL_NEVER);
  glDepthMask(GL_FALSE);
  glDepthRangef(0.75f, 0.25f);
  set_clip_control(info_, GL_UPPER_LEFT, GL_ZERO_TO_ONE);
  glStencilFunc(GL_NEVER, 1, 3);
  glCullFace(GL_FRONT_AND_BACK);
  glPixelStorei(GL_PACK_ALIGNMENT, 1);
  glPixelStorei(GL_UNPACK_ALIGNMENT, 2);
  for (const GLenum name :
       {GL_PACK_ROW_LENGTH, GL_PACK_SKIP_ROWS, GL_PACK_SKIP_PIXELS, GL_UNPACK_ROW_LENGTH, GL_UNPACK_SKIP_ROWS,
        GL_UNPACK_SKIP_PIXELS, GL_UNPACK_IMAGE_HEIGHT, GL_UNPACK_SKIP_IMAGES}) {
    glPixelStorei(name, 7);
  }
  if (has_indexed(info_)) {
    glColorMaski(0, GL_FALSE, GL_TRUE, GL_FALSE, GL_TRUE);
    glColorMaski(1, GL_TRUE, GL_FALSE, GL_FALSE, GL_TRUE);
    glEnablei(GL_BLEND, 0);
    glEnablei(GL_BLEND, 2);
  } else {
    glColorMask(GL_FALSE, GL_TRUE, GL_FALSE, GL_TRUE);
    glEnable(GL_BLEND);
  }
  glBlendFunc(GL_ZERO, GL_ONE);
  if (info_.es) return;
  for (const GLenum name : {GL_PACK_SWAP_BYTES, GL_UNPACK_SWAP_BYTES, GL_PACK_LSB_FIRST, GL_UNPACK_LSB_FIRST}) {
    glPixelStorei(name, 1);
  }
  glPolygonMode(GL_FRONT_AND_BACK, GL_POINT);
  glClampColor(GL_CLAMP_READ_COLOR, GL_TRUE);
  glLogicOp(GL_INVERT);
  if (!info_.core_profile) glAlphaFunc(GL_NEVER, 0.0f);
}

/// A switch that a fresh context has on, dithering or multisampling, goes off.
void HostileHost::set_switches(bool on) {
  for (const Named& one : switches_of(info_)) {
    const bool fresh = one.value == GL_DITHER || one.value == GL_MULTISAMPLE;
    if (on != fresh) {
      glEnable(one.value);
    } else {
      glDisable(one.value);
    }
  }
}

void leave_a_mess() {
  GLuint name = 0;
  for (int i = 0; i < units; ++i) {
    glActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(i));
    glGenTextures(1, &name);
    glBindTexture(GL_TEXTURE_2D, name);
    glBindTexture(GL_TEXTURE_2D_ARRAY, 0);
    glBindSampler(static_cast<GLuint>(i), 0);
  }
  glUseProgram(0);
  glBindVertexArray(0);
  glBindFramebuffer(GL_FRAMEBUFFER, 0);
  glBindRenderbuffer(GL_RENDERBUFFER, 0);
  glGenBuffers(1, &name);
  for (const GLenum target : {GL_ARRAY_BUFFER, GL_PIXEL_PACK_BUFFER, GL_PIXEL_UNPACK_BUFFER, GL_UNIFORM_BUFFER,
                              GL_COPY_READ_BUFFER, GL_COPY_WRITE_BUFFER}) {
    glBindBuffer(target, name);
  }
  glBindBufferBase(GL_UNIFORM_BUFFER, 0, name);
  glBindBufferBase(GL_UNIFORM_BUFFER, 1, name);
  if (gl::read_context_info().computes()) {
    for (GLuint binding = 0; binding < 4; ++binding) glBindBufferBase(GL_SHADER_STORAGE_BUFFER, binding, name);
  }
  glViewport(0, 0, 99, 98);
  glScissor(0, 0, 97, 96);
  glClearColor(1, 1, 1, 1);
  glDepthFunc(GL_GREATER);
  glDepthRangef(0.5f, 0.25f);
  for (const GLenum on : {GL_BLEND, GL_DEPTH_TEST, GL_SCISSOR_TEST, GL_CULL_FACE}) glEnable(on);
  glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_FALSE);
  glPixelStorei(GL_PACK_ALIGNMENT, 8);
  for (const GLenum store :
       {GL_PACK_ROW_LENGTH, GL_PACK_SKIP_ROWS, GL_PACK_SKIP_PIXELS, GL_UNPACK_ROW_LENGTH, GL_UNPACK_SKIP_ROWS,
        GL_UNPACK_SKIP_PIXELS, GL_UNPACK_IMAGE_HEIGHT, GL_UNPACK_SKIP_IMAGES}) {
    glPixelStorei(store, 3);
  }
}

bool draws_well(const gl::ContextInfo& info) {
  GLuint texture = 0, framebuffer = 0, vertex_array = 0;
  glGenTextures(1, &texture);
  glBindTexture(GL_TEXTURE_2D_ARRAY, texture);
  using Layer = std::array<float, 4 * 8>;  // 4 x 2 texels
  std::array<Layer, 2> expected{}, got{};
  for (std::size_t i = 0; i < 64; ++i) expected[i / 32][i % 32] = 1.5f * static_cast<float>(i) - 7.0f;
  glTexImage3D(GL_TEXTURE_2D_ARRAY, 0, GL_RGBA32F, 4, 2, 2, 0, GL_RGBA, GL_FLOAT, expected.data());
  glGenFramebuffers(1, &framebuffer);
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
  glGenVertexArrays(1, &vertex_array);
  glBindVertexArray(vertex_array);
  const GLuint program = linked(
      info,
      "void main() { gl_Position = vec4(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0, 0.0, 1.0); }",
      "out highp vec4 texel; void main() { texel = vec4(-2.0, 16777213.0, -3.5, 3e30); }");
  glUseProgram(program);
  for (GLint i = 0; i < 2; ++i) {
    glFramebufferTextureLayer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, texture, 0, i);
    if (i == 1) {
      glViewport(0, 0, 4, 2);
      glDrawArrays(GL_TRIANGLES, 0, 3);
    }
    glReadPixels(0, 0, 4, 2, GL_RGBA, GL_FLOAT, got[static_cast<std::size_t>(i)].data());
  }
  for (std::size_t k = 0; k < 32; ++k) expected[1][k] = std::array{-2.0f, 16777213.0f, -3.5f, 3e30f}[k % 4];
  glUseProgram(0);
  glDeleteProgram(program);
  glDeleteVertexArrays(1, &vertex_array);
  glDeleteFramebuffers(1, &framebuffer);
  glDeleteTextures(1, &texture);
  return glGetError() == GL_NO_ERROR && got == expected;
}

}  // namespace phymul::test
