// SPDX-License-Identifier: MIT
//
// Textures, framebuffers and programs by themselves, and what they say when a driver refuses them.
#include <filesystem>
#include <numeric>

#include "gl/context/guard_state.h"
#include "gl/objects/pass.h"
#include "support/gl_fixture.h"
#include "support/message_of.h"
#include "support/text_file.h"

namespace phymul::test {
namespace {

using namespace phymul::gl;

class GlObjects : public GlTest {
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
    EXPECT_EQ(text_of(std::string(PHYMUL_GLSL_SOURCES) + "/" + shader->name), shader->text) << shader->name;
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
}  // namespace phymul::test
