// SPDX-License-Identifier: MIT
#include "body_drawing.h"

#include <phymul/error.h>

#include <algorithm>
#include <array>
#include <bit>
#include <string>
#include <type_traits>
#include <utility>

#include "gl/context/context.h"
#include "gl/context/gl_api.h"
#include "gl/objects/pass.h"
#include "gl/solver/device_solver.h"

namespace phymul::gl {
namespace {

/// PictureTarget: a framebuffer for one picture, several pixels a pixel, whose mean smooths every kind of edge: those
/// of triangles, of balls that a shader cuts out, of dashes.
class PictureTarget {
 public:
  /// Throws Error where the driver has no room for it.
  PictureTarget(int width, int height);
  PictureTarget(const PictureTarget&) = delete;
  PictureTarget& operator=(const PictureTarget&) = delete;
  ~PictureTarget();

  GLuint framebuffer() const { return framebuffer_; }
  int factor() const { return factor_; }  ///< pixels of the target along a side of a pixel of the picture

  /// Waits for the device.
  Image read() const;

 private:
  void release() noexcept;

  int width_, height_, factor_;
  GLuint framebuffer_ = 0;
  GLuint buffers_[2] = {0, 0};  // colour, depth
};

constexpr int best_factor = 3;

/// The largest factor up to the best one that the driver has room for.
int factor_for(int width, int height) {
  if (width < 1 || height < 1) {
    throw Error("Display: expected a picture of at least 1 x 1 pixels, got " + std::to_string(width) + " x " +
                std::to_string(height));
  }
  std::array<GLint, 2> view{};
  glGetIntegerv(GL_MAX_VIEWPORT_DIMS, view.data());
  const GLint largest = std::min({integer_of(GL_MAX_RENDERBUFFER_SIZE), view[0], view[1]});
  const int factor = std::min(best_factor, largest / std::max(width, height));
  if (factor < 1) {
    throw Error("Display: a picture of " + std::to_string(width) + " x " + std::to_string(height) +
                " pixels is larger than this driver draws, at most " + std::to_string(largest) + " a side");
  }
  return factor;
}

PictureTarget::PictureTarget(int width, int height)
    : width_(width), height_(height), factor_(factor_for(width, height)) {
  forget_errors();
  glGenRenderbuffers(2, buffers_);
  const std::array<GLenum, 2> formats{GL_RGBA8, GL_DEPTH_COMPONENT24};
  for (std::size_t k = 0; k < formats.size(); ++k) {
    glBindRenderbuffer(GL_RENDERBUFFER, buffers_[k]);
    glRenderbufferStorage(GL_RENDERBUFFER, formats[k], width * factor_, height * factor_);
  }
  glBindRenderbuffer(GL_RENDERBUFFER, 0);
  glGenFramebuffers(1, &framebuffer_);
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_);
  glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, buffers_[0]);
  glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER, buffers_[1]);
  const GLenum error = glGetError();
  if (error == GL_NO_ERROR && glCheckFramebufferStatus(GL_FRAMEBUFFER) == GL_FRAMEBUFFER_COMPLETE) return;
  release();
  throw Error(ErrorCode::out_of_memory, "Display: the driver has no room for a picture of " +
                                            std::to_string(width * factor_) + " x " + std::to_string(height * factor_) +
                                            " pixels, 8 bytes each; ask for a smaller one");
}

PictureTarget::~PictureTarget() {
  release();
}

void PictureTarget::release() noexcept {
  glBindFramebuffer(GL_FRAMEBUFFER, 0);
  if (framebuffer_ != 0) glDeleteFramebuffers(1, &framebuffer_);
  glDeleteRenderbuffers(2, buffers_);
}

Image PictureTarget::read() const {
  const auto wide = static_cast<std::size_t>(width_ * factor_), high = static_cast<std::size_t>(height_ * factor_);
  std::vector<std::uint8_t> fine(4 * wide * high);
  glBindFramebuffer(GL_READ_FRAMEBUFFER, framebuffer_);
  glReadBuffer(GL_COLOR_ATTACHMENT0);
  glBindBuffer(GL_PIXEL_PACK_BUFFER, 0);
  glPixelStorei(GL_PACK_ALIGNMENT, 4);
  glPixelStorei(GL_PACK_ROW_LENGTH, 0);
  glReadPixels(0, 0, width_ * factor_, height_ * factor_, GL_RGBA, GL_UNSIGNED_BYTE, fine.data());

  Image image{width_, height_, std::vector<std::uint8_t>(4 * static_cast<std::size_t>(width_) * height_)};
  const auto factor = static_cast<std::size_t>(factor_);
  const unsigned samples = static_cast<unsigned>(factor * factor);
  std::uint8_t* out = image.rgba.data();
  for (std::size_t y = 0; y < static_cast<std::size_t>(height_); ++y) {
    const std::size_t bottom = high - factor * (y + 1);  // GL counts rows from below
    for (std::size_t x = 0; x < static_cast<std::size_t>(width_); ++x) {
      std::array<unsigned, 4> sum{};
      for (std::size_t row = 0; row < factor; ++row) {
        const std::uint8_t* in = &fine[4 * ((bottom + row) * wide + factor * x)];
        for (std::size_t k = 0; k < 4 * factor; ++k) sum[k % 4] += in[k];
      }
      for (const unsigned channel : sum) *out++ = static_cast<std::uint8_t>((channel + samples / 2) / samples);
    }
  }
  return image;
}

/// What drawing changes and StateGuard leaves alone, of the current context.
class BlendGuard {
 public:
  BlendGuard() {
    for (std::size_t k = 0; k < names.size(); ++k) glGetIntegerv(names[k], &value_[k]);
  }
  BlendGuard(const BlendGuard&) = delete;
  BlendGuard& operator=(const BlendGuard&) = delete;
  ~BlendGuard() {
    const auto value = [this](std::size_t k) { return static_cast<GLenum>(value_[k]); };
    glBlendFuncSeparate(value(0), value(1), value(2), value(3));
    glBlendEquationSeparate(value(4), value(5));
    glCullFace(value(6));
    glFrontFace(value(7));
    // Passes that follow in this context need these off, and a host's own values come back with StateGuard.
    for (const GLenum name : {GL_BLEND, GL_SCISSOR_TEST, GL_DEPTH_TEST, GL_CULL_FACE}) glDisable(name);
    glDepthMask(GL_TRUE);
  }

 private:
  static constexpr std::array<GLenum, 8> names{GL_BLEND_SRC_RGB,   GL_BLEND_DST_RGB,      GL_BLEND_SRC_ALPHA,
                                               GL_BLEND_DST_ALPHA, GL_BLEND_EQUATION_RGB, GL_BLEND_EQUATION_ALPHA,
                                               GL_CULL_FACE_MODE,  GL_FRONT_FACE};
  std::array<GLint, 8> value_{};
};

/// What lives in the context.
struct Objects {
  Objects(const Model& model, const ShaderLibrary& library, const VisibleSkin* skin)
      : body(skin ? skin->surface : model, library, skin ? &skin->skin : nullptr) {}

  EmptyVertexArray vertices;
  BodyDrawing body;
  Texture position, attractor;  // of what is uploaded
};

class GlDisplay final : public Display {
 public:
  GlDisplay(const Model& model, const Solver* solver, std::shared_ptr<const VisibleSkin> skin, const GlOptions& options)
      : model_(model),
        solver_(solver),
        skin_(std::move(skin)),
        user_(dynamic_cast<const DeviceSolver*>(solver)),
        options_(options) {
    open();
    try {
      if (!solver) show(model.rest, {});
    } catch (...) {
      drop();  // the destructor of what was not made does not run
      throw;
    }
  }

  ~GlDisplay() override { drop(); }

  Image render(const Camera& camera, const DisplayOptions& options, int width, int height) override {
    return with_placement(options.attractors, [&](const Placement& placement) {
      const PictureTarget target(width, height);
      const int factor = target.factor();
      objects_->body.draw(placement, camera, options,
                          {0, 0, width * factor, height * factor, static_cast<double>(factor)});
      return target.read();
    });
  }

  void draw(const Camera& camera, const DisplayOptions& options, int x, int y, int width, int height) override {
    if (options_.context != GlContext::current) {
      throw Error(
          "Display::draw: draws into the caller's framebuffer, so the display must be made with GlContext::current; "
          "this one has a context of its own, where render() makes pictures");
    }
    if (width < 1 || height < 1) {
      throw Error("Display::draw: expected a view of at least 1 x 1 pixels, got " + std::to_string(width) + " x " +
                  std::to_string(height));
    }
    with_placement(options.attractors, [&](const Placement& placement) {
      objects_->body.draw(placement, camera, options, {x, y, width, height, 1.0});
      return 0;
    });
  }

  void show(std::span<const Vec3> position, std::span<const Vec3> attractor) override {
    if (solver_) throw Error("Display::show: this display shows what its solver holds; make one from the model");
    const std::size_t n = model_.rest.size();
    if (position.size() != n || (!attractor.empty() && attractor.size() != n)) {
      throw Error("Display::show: expected " + std::to_string(n) + " positions, and as many attractors or none, got " +
                  std::to_string(position.size()) + " and " + std::to_string(attractor.size()));
    }
    context_->run([&] {
      upload(position, objects_->position, "positions");
      has_attractors_ = !attractor.empty();
      if (has_attractors_) upload(attractor, objects_->attractor, "attractors");
    });
  }

  bool zero_copy() const override { return sees_solver_ && solver_->position_buffer().texture != 0; }
  std::string device() const override { return context_->info().device(); }

 private:
  void open() {
    if (user_ && options_.context == GlContext::own) {
      context_ = user_->context();
      sees_solver_ = true;
    } else {
      context_ = Context::open(options_);
    }
    if (user_ && options_.context == GlContext::current) sees_solver_ = user_->context_kind() == GlContext::current;
    if (solver_) body_version_ = solver_->scene().body_version();
    context_->run([&] {
      objects_ =
          std::make_unique<Objects>(model_, ShaderLibrary(options_.shader_folder, context_->info().es), skin_.get());
    });
  }

  void drop() noexcept {
    context_->discard([this] { objects_.reset(); });
    static_cast<void>(objects_.release());  // not there any more, or out of reach: their names may be others' by now
  }

  /// Makes the objects anew where the solver has another context, because it lost its device, or where cuts and removed
  /// cells have changed the body. A skin stays as it is.
  void follow_solver() {
    if (!objects_) return open();  // an earlier opening failed
    const bool is_cut = solver_ && !skin_ && body_version_ != solver_->scene().body_version();
    const bool moved = sees_solver_ && options_.context != GlContext::current && user_->context() != context_;
    if (!is_cut && !moved) return;
    drop();
    open();
  }

  void upload(std::span<const Vec3> place, Texture& texture, const char* name) const {
    std::vector<Float4> moved(place.size());
    for (std::size_t i = 0; i < place.size(); ++i) moved[i] = float4(place[i] - model_.rest[i]);
    if (texture) {
      texture.upload(std::span<const Float4>(moved));
    } else {
      texture = Texture::table(moved, name);
    }
  }

  /// Where a buffer of the solver can be read, uploading it where it must be.
  TextureView view_of_buffer(const ParticleBuffer& buffer, Texture& texture, const char* name) const {
    if (buffer.texture != 0)
      return {buffer.texture, std::countr_zero(std::bit_ceil(static_cast<unsigned>(buffer.width)))};
    if (buffer.position.empty()) return {};
    upload(buffer.position, texture, name);
    return view_of(texture);
  }

  /// A GL solver in a context whose objects are not seen here gives its positions by a copy.
  TextureView solver_positions() {
    if (sees_solver_ || !user_) {
      return view_of_buffer(solver_->position_buffer(), objects_->position, "positions");
    }
    const State state = solver_->read();
    return view_of_buffer({.position = state.position}, objects_->position, "positions");
  }

  /// Calls draw(placement) in the context.
  template <class Draw>
  std::invoke_result_t<Draw&, const Placement&> with_placement(bool attractors, Draw&& draw) {
    attractors = attractors && !skin_;
    follow_solver();
    auto result = context_->run([&] {
      const BlendGuard guard;
      Placement placement;
      if (solver_) {
        placement.displacement = solver_positions();
        if (attractors) {
          placement.attractor = view_of_buffer(solver_->attractor_buffer(), objects_->attractor, "attractors");
        }
      } else {
        placement.displacement = view_of(objects_->position);
        if (attractors && has_attractors_) placement.attractor = view_of(objects_->attractor);
      }
      objects_->vertices.bind();
      return draw(placement);
    });
    context_->throw_debug_errors();
    return result;
  }

  const Model& model_;
  const Solver* solver_;                           // null: show() gives the positions
  const std::shared_ptr<const VisibleSkin> skin_;  // null: the body itself is drawn
  const DeviceSolver* user_;                       // the same as solver_, where it is one of src/gl
  const GlOptions options_;
  std::shared_ptr<Context> context_;
  std::uint64_t body_version_ = 0;  // Scene::body_version() of what is drawn
  bool sees_solver_ = false;
  bool has_attractors_ = false;
  std::unique_ptr<Objects> objects_;
};

}  // namespace

std::unique_ptr<Display> make_display(const Model& model, const Solver* solver, std::shared_ptr<const VisibleSkin> skin,
                                      const GlOptions& options) {
  return std::make_unique<GlDisplay>(model, solver, std::move(skin), options);
}

}  // namespace phymul::gl
