// SPDX-License-Identifier: MIT
//
// Contexts of one's own: where they are found, what they can do, several at a time.
#include <phymul/error.h>

#include <gtest/gtest.h>
#include <array>
#include <atomic>
#include <cstdio>
#include <filesystem>
#include <numeric>
#include <stdexcept>
#include <thread>
#include <vector>

#include "gl/context/context.h"
#include "gl/context/gl_api.h"
#include "gl/context/guard_state.h"
#include "gl/objects/pass.h"
#include "support/gl_fixture.h"
#include "support/heap_in_use.h"
#include "support/message_of.h"
#include "support/text_file.h"

namespace phymul::gl {
namespace {

class GlContextTest : public test::GlTest {};

/// Clears an RGBA32F texture to a value and reads its middle texel back.
float drawn_and_read(Context& context, float value) {
  return context.run([&] {
    GLuint texture = 0, framebuffer = 0;
    glGenTextures(1, &texture);
    glBindTexture(GL_TEXTURE_2D, texture);
    glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA32F, 8, 8, 0, GL_RGBA, GL_FLOAT, nullptr);
    glGenFramebuffers(1, &framebuffer);
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, texture, 0);
    const std::array<float, 4> color{value, 0, 0, 0};
    glClearBufferfv(GL_COLOR, 0, color.data());
    std::array<float, 4> read{};
    glReadPixels(4, 4, 1, 1, GL_RGBA, GL_FLOAT, read.data());
    glDeleteFramebuffers(1, &framebuffer);
    glDeleteTextures(1, &texture);
    return read[0];
  });
}

TEST_F(GlContextTest, OpensByItselfAndKnowsWhatItIs) {
  const auto context = Context::open({});
  const ContextInfo& info = context->info();
  EXPECT_TRUE(info.es ? info.at_least(3, 0) : info.at_least(3, 3)) << info.version;
  EXPECT_FALSE(info.renderer.empty());
  EXPECT_FALSE(info.glsl_version.empty());
  EXPECT_GE(info.max_texture_size, 2048);
  EXPECT_GE(info.max_draw_buffers, 4);
  EXPECT_GE(info.max_color_attachments, 4);
  EXPECT_TRUE(says(info.device(), info.renderer));
  EXPECT_FALSE(context->lost());
  EXPECT_EQ(drawn_and_read(*context, -2.5f), -2.5f);
  std::printf("%s, found on %s\n", info.device().c_str(), info.display.c_str());
}

TEST_F(GlContextTest, NothingIsCurrentBetweenCalls) {
  const auto context = Context::open({});
  EXPECT_EQ(eglGetCurrentContext(), EGL_NO_CONTEXT);
  context->run([] { EXPECT_NE(eglGetCurrentContext(), EGL_NO_CONTEXT); });
  EXPECT_EQ(eglGetCurrentContext(), EGL_NO_CONTEXT);
}

TEST_F(GlContextTest, ResultsAndExceptionsComeBack) {
  const auto context = Context::open({});
  EXPECT_EQ(context->run([&] { return context->run([] { return 7; }); }), 7);
  EXPECT_THROW(context->run([] { throw std::out_of_range("x"); }), std::out_of_range);
  EXPECT_EQ(drawn_and_read(*context, 3.0f), 3.0f);
  EXPECT_EQ(eglGetCurrentContext(), EGL_NO_CONTEXT);
}

TEST_F(GlContextTest, EveryNamedDisplayWorksOrSaysWhyNot) {
  for (const std::string device : {"surfaceless", "device:0"}) {
    SCOPED_TRACE(device);
    const auto context = Context::open({.device = device});
    EXPECT_TRUE(context->info().display.starts_with(device)) << context->info().display;
    EXPECT_EQ(drawn_and_read(*context, 1.25f), 1.25f);
  }
}

TEST_F(GlContextTest, UnknownDevicesAreRefused) {
  const auto message = [](const char* device) { return message_of([&] { Context::open({.device = device}); }); };
  for (const char* device : {"gpu", "device:", "device:-1", "device:0x", "Surfaceless", " "}) {
    EXPECT_EQ(message(device), "GlOptions::device: expected \"device:N\", \"surfaceless\" or \"default\", got \"" +
                                   std::string(device) + "\"");
  }
  EXPECT_TRUE(says(message("device:999"), "the number of devices EGL has here, got \"device:999\""));
}

TEST_F(GlContextTest, EnvironmentIsHeardWhereTheOptionIsLeft) {
  const test::Environment wish("PHYMUL_EGL", "nonsense");
  EXPECT_EQ(message_of([] { Context::open({}); }),
            "PHYMUL_EGL: expected \"device:N\", \"surfaceless\" or \"default\", got \"nonsense\"");
  EXPECT_EQ(Context::open({.device = "surfaceless"})->info().display, "surfaceless");
  const test::Environment dialect("PHYMUL_GL_DIALECT", "gles");
  EXPECT_EQ(message_of([] { Context::open({.device = "surfaceless"}); }),
            "PHYMUL_GL_DIALECT: expected \"desktop\" or \"es\", got \"gles\"");
}

TEST_F(GlContextTest, WithoutAWindowSystemTheDefaultDisplayIsRefusedWithItsReason) {
  const test::Environment display("DISPLAY", ":4711"), wayland("WAYLAND_DISPLAY", nullptr),
      platform("EGL_PLATFORM", nullptr);
  const std::string message = message_of([] { Context::open({.device = "default"}); });
  // Mesa finds out when it connects, NVIDIA's driver before.
  const bool refused = message.find("tried:\n  default: eglInitialize: EGL_NOT_INITIALIZED") != std::string::npos ||
                       message.find("tried:\n  default: EGL has no such display here") != std::string::npos;
  EXPECT_TRUE(refused) << message;
  EXPECT_EQ(drawn_and_read(*Context::open({}), 1.0f), 1.0f);
}

TEST_F(GlContextTest, BothDialectsOpen) {
  EXPECT_FALSE(Context::open({.dialect = GlDialect::desktop})->info().es);
  const auto es = Context::open({.dialect = GlDialect::es});
  EXPECT_TRUE(es->info().es);
  EXPECT_EQ(drawn_and_read(*es, -7.0f), -7.0f);
}

TEST_F(GlContextTest, FourThreadsWithAContextEach) {
  std::atomic<int> wrong = 0;
  const auto work = [&](int number) {
    const auto context = Context::open({});
    for (int i = 0; i < 50; ++i) {
      const float value = static_cast<float>(1000 * number + i);
      if (drawn_and_read(*context, value) != value) ++wrong;
    }
  };
  std::vector<std::thread> threads;
  for (int number = 0; number < 4; ++number) threads.emplace_back(work, number);
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(wrong, 0);
}

TEST_F(GlContextTest, AContextMayMoveBetweenThreads) {
  const auto context = Context::open({});
  for (int i = 0; i < 4; ++i) {
    std::thread([&] { EXPECT_EQ(drawn_and_read(*context, 5.0f), 5.0f); }).join();
  }
}

/// What each of a hundred contexts left behind would show: a driver's context weighs hundreds of kilobytes.
TEST_F(GlContextTest, AHundredContextsLeaveNothingBehind) {
  const auto open_and_close = [&](int times) {
    for (int i = 0; i < times; ++i) EXPECT_EQ(drawn_and_read(*Context::open({}), 1.0f), 1.0f);
  };
  open_and_close(20);  // the driver's caches fill
  const double before = test::heap_in_use();
  open_and_close(100);
  const double grown = test::heap_in_use() - before;
  std::printf("[  MEMORY  ] grew by %.0f KiB over 100 contexts\n", grown / 1024.0);
  EXPECT_LT(grown, 100 * 16384.0);
}

TEST_F(GlContextTest, DebugOutputBecomesAnError) {
  const auto context = Context::open({.debug = true});
  if (!context->info().has("GL_KHR_debug")) GTEST_SKIP() << "NOT TESTED: no GL_KHR_debug";
  EXPECT_NO_THROW(context->throw_debug_errors());
  context->run([] { glEnable(GL_TEXTURE_2D + 0x7000); });
  const std::string message = message_of([&] { context->throw_debug_errors(); });
  EXPECT_TRUE(message.starts_with("GL reports 1 error: ")) << message;
  EXPECT_NO_THROW(context->throw_debug_errors());
}

TEST_F(GlContextTest, WhatIsLostStaysLost) {
  const auto context = Context::open({});
  context->mark_lost();
  EXPECT_TRUE(context->lost());
  bool called = false;
  context->discard([&] { called = true; });
  EXPECT_FALSE(called);
}

TEST_F(GlContextTest, DiscardSwallowsWhatItThrows) {
  const auto context = Context::open({});
  bool called = false;
  context->discard([&] {
    called = true;
    throw Error("x");
  });
  EXPECT_TRUE(called);
}

// Textures, framebuffers and programs by themselves, and what they say when a driver refuses them.

class GlObjects : public test::GlTest {
 protected:
  void set_up() override { context_ = Context::open({}); }
  template <class Function>
  std::string message_in_context(Function&& f) {
    return context_->run([&] { return message_of(f); });
  }
  std::shared_ptr<Context> context_;
};

TEST_F(GlObjects, TablesArePaddedWithNoneAndZero) {
  context_->run([] {
    std::vector<std::int32_t> rows(21);
    std::iota(rows.begin(), rows.end(), 100);
    const std::vector<float> numbers(21, 2.5f);
    const Texture table = Texture::table(std::span<const std::int32_t>(rows), "numbers");
    const Texture values = Texture::table(std::span<const float>(numbers), "values");
    EXPECT_EQ(table.shape(), (TextureShape{8, 3}));
    const Framebuffer integers({{&table}}), floats({{&values}});
    std::vector<Int4> read(24);
    std::vector<Float4> read_floats(24);
    integers.read(0, GL_RGBA_INTEGER, GL_INT, read.data());
    floats.read(0, GL_RGBA, GL_FLOAT, read_floats.data());
    for (int r = 0; r < 24; ++r) {
      EXPECT_EQ(read[r][0], r < 21 ? 100 + r : -1) << r;
      EXPECT_EQ(read_floats[r][0], r < 21 ? 2.5f : 0.0f) << r;
    }
  });
}

TEST_F(GlObjects, RowsBeyondTheLimitAreRefusedWithTheSizes) {
  const std::int64_t side = context_->info().max_texture_size;
  const std::string message =
      message_in_context([&] { Texture::target(side * side + 1, TexelFormat::r32f, "many things"); });
  EXPECT_TRUE(says(message, "the table of many things needs " + std::to_string(side * side + 1) + " rows"));
  EXPECT_TRUE(says(message, std::to_string(side)));
}

TEST_F(GlObjects, MemoryThatADriverDoesNotHaveIsRefusedWithTheBytes) {
  // llvmpipe takes no texture above 1 GiB or so; another driver may have room for this one.
  if (!context_->info().renderer.starts_with("llvmpipe")) GTEST_SKIP() << "NOT TESTED: made for llvmpipe's limit";
  const std::int64_t side = context_->info().max_texture_size;
  const std::string message =
      message_in_context([&] { Texture::target(side * side, TexelFormat::rgba32f, "vast things"); });
  EXPECT_TRUE(says(message, "the texture of vast things could not be made", std::to_string(side * side * 16) + " bytes",
                   "out of memory"));
  EXPECT_EQ(message_in_context([] { Texture::target(100, TexelFormat::rgba32f, "small things"); }), "(no error)")
      << "an error of before was taken for this one";
}

TEST_F(GlObjects, ShaderErrorsNameFileAndLine) {
  const TextFile cover("dialect/cover_target.glsl", "void main() { gl_Position = vec4(0.0); }\n");
  const std::string folder = std::filesystem::path(cover.path()).parent_path().parent_path().string();
  const TextFile fine("fine.glsl", "// first line\nfloat twice(float x) { return 2.0 * x; }\n");
  const TextFile faulty("faulty.glsl", "out vec4 o;\n\nvoid main() {\n  o = vec4(thrice(1.0));\n}\n");
  const ShaderLibrary library(folder, context_->info().es);
  const std::string message = message_in_context([&] {
    Pass(library, {.files = {"fine.glsl", "faulty.glsl"}, .defines = {{"NOTHING", 1}}});
  });
  EXPECT_TRUE(says(message, "fragment shader faulty.glsl does not compile on " + context_->info().renderer,
                   "faulty.glsl:4", "thrice"));
  const std::string absent = message_in_context([&] { Pass(library, {.files = {"absent.glsl"}, .defines = {}}); });
  EXPECT_TRUE(says(absent, "absent.glsl could not be read"));
}

/// Also where the driver binds more: StateGuard saves no others.
TEST_F(GlObjects, PassesThatReadMoreTexturesThanEveryDriverBindsAreRefused) {
  const TextFile cover("dialect/cover_target.glsl", "void main() { gl_Position = vec4(0.0); }\n");
  const std::string folder = std::filesystem::path(cover.path()).parent_path().parent_path().string();
  std::vector<std::string> names;
  std::string samplers = "out vec4 o;\n", sum = "vec4(0.0)";
  for (int k = 0; k <= StateGuard::texture_units; ++k) {
    names.push_back("table_" + std::to_string(k));
    samplers += "uniform sampler2D " + names.back() + ";\n";
    sum += " + texelFetch(" + names.back() + ", ivec2(0), 0)";
  }
  if (context_->run([] { return integer_of(GL_MAX_TEXTURE_IMAGE_UNITS); }) == StateGuard::texture_units) {
    GTEST_SKIP() << "NOT TESTED: the driver itself refuses such a shader";
  }
  const TextFile greedy("greedy.glsl", samplers + "void main() { o = " + sum + "; }\n");
  const ShaderLibrary library(folder, context_->info().es);
  context_->run([&] {
    Pass pass(library, {.files = {"greedy.glsl"}, .defines = {}});
    const Texture table = Texture::target(1, "a table");
    const std::string last = names.back();
    names.pop_back();
    for (const std::string& name : names) pass.input(name.c_str(), table);
    EXPECT_EQ(message_of([&] { pass.input(last.c_str(), table); }),
              "greedy reads more than the 16 textures that every driver binds at a time");
  });
}

TEST(ShaderLibraryLog, PlacesOfThreeDriversAreRead) {
  const ShaderRequest request{.files = {"one.glsl", "two.glsl"}, .defines = {}};
  EXPECT_EQ(ShaderLibrary::readable("0:20014(5): error: x", request), "two.glsl:14: error: x\n");
  EXPECT_EQ(ShaderLibrary::readable("0(10003) : error C1", request), "one.glsl:3 : error C1\n");
  EXPECT_EQ(ShaderLibrary::readable("ERROR: 0:2: 'y'", request), "ERROR: head:2: 'y'\n");
  EXPECT_EQ(ShaderLibrary::readable("3 errors", request), "3 errors\n");
}

TEST_F(GlObjects, BuiltInShadersAreThoseOfTheFolder) {
  int files = 0;
  for (const EmbeddedShader* shader = embedded_shaders; shader->name; ++shader, ++files) {
    EXPECT_EQ(text_of(PHYMUL_GLSL_SOURCES "/" + std::string(shader->name)), shader->text) << shader->name;
  }
  EXPECT_GE(files, 20);
}

TEST_F(GlObjects, TargetsThatCannotBeDrawnIntoAreRefused) {
  const std::string message = message_in_context([] {
    const Texture wide = Texture::target(64, TexelFormat::rgba32f, "a square", 2);
    Framebuffer({{&wide, 0}, {&wide, 7}});  // has no such layer
  });
  EXPECT_TRUE(says(message, "this driver cannot draw into the textures of a square"));
}

}  // namespace

}  // namespace phymul::gl
