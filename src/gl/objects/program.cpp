// SPDX-License-Identifier: MIT
#include "program.h"

#include <phymul/error.h>

#include <cstdlib>
#include <fstream>
#include <regex>
#include <sstream>
#include <utility>

namespace phymul::gl {
namespace {

constexpr const char* desktop_head = "#version 330 core\n";
constexpr const char* es_head =
    "#version 300 es\n"
    "precision highp float;\n"
    "precision highp int;\n"
    "precision highp sampler2D;\n"
    "precision highp isampler2D;\n"
    "precision highp sampler2DArray;\n";

constexpr const char* desktop_compute_head =
    "#version 430 core\n"
    "#define PRECISE precise\n";
constexpr const char* es_32_compute_head =
    "#version 320 es\n"
    "#define PRECISE precise\n"
    "precision highp float;\n"
    "precision highp int;\n";
constexpr const char* es_31_compute_head =
    "#version 310 es\n"
    "#define PRECISE\n"
    "precision highp float;\n"
    "precision highp int;\n";

/// File number n (from 1) of a request has the lines n * lines_a_file + 1 and on. #line also takes the number of a
/// source string, which Mesa 22 forgets before it reports an error.
constexpr int lines_a_file = 10000;

}  // namespace

ShaderLibrary::ShaderLibrary(std::string folder, bool es, bool has_precise)
    : folder_(std::move(folder)), es_(es), has_precise_(has_precise) {
  const char* const wish = std::getenv("PHYMUL_GLSL");
  if (folder_.empty() && wish) folder_ = wish;
}

std::string ShaderLibrary::file(const std::string& name) const {
  if (!folder_.empty()) {
    const std::string path = folder_ + "/" + name;
    std::ifstream in(path, std::ios::binary);
    std::ostringstream text;
    if (!in || !(text << in.rdbuf())) {
      throw Error(ErrorCode::file_access, "the shader " + path +
                                              " could not be read; GlOptions::shader_folder or PHYMUL_GLSL names the " +
                                              "folder, which must hold every file of glsl/");
    }
    return text.str();
  }
  for (const EmbeddedShader* shader = embedded_shaders; shader->name; ++shader) {
    if (name == shader->name) return shader->text;
  }
  throw Error("no shader " + name + " is built in");
}

std::string ShaderRequest::name() const {
  const std::string file = files.empty() ? std::string() : files.back();
  const std::size_t begin = file.rfind('/') + 1;  // 0 where there is no folder
  return file.substr(begin, file.rfind('.') - begin);
}

std::string ShaderLibrary::text(const ShaderRequest& request, Stage stage) const {
  std::string all = es_ ? es_head : desktop_head;
  if (stage == Stage::compute) {
    all = !es_ ? desktop_compute_head : has_precise_ ? es_32_compute_head : es_31_compute_head;
  }
  for (const auto& [name, value] : request.defines) all += "#define " + name + " " + std::to_string(value) + "\n";
  int first_line = lines_a_file + 1;  // the head has those before
  for (const std::string& name : request.files) {
    all += "#line " + std::to_string(first_line) + "\n" + file(name);
    first_line += lines_a_file;
    if (all.back() != '\n') all += '\n';
  }
  return all;
}

std::string ShaderLibrary::readable(std::string_view log, const ShaderRequest& request) {
  // Mesa: "0:20014(5): error"; NVIDIA: "0(20014) : error"; ANGLE, Apple: "ERROR: 0:20014: ...".
  static const std::regex place(R"(^((?:ERROR|WARNING): )?\d+(?::(\d+)(?:\(\d+\))?|\((\d+)\)))");
  std::istringstream lines{std::string(log)};
  std::string line, result;
  while (std::getline(lines, line)) {
    std::smatch match;
    if (std::regex_search(line, match, place)) {
      const int number = std::atoi((match[2].matched ? match[2] : match[3]).str().c_str());
      const auto file_number = static_cast<std::size_t>(number / lines_a_file);
      const bool known = file_number >= 1 && file_number <= request.files.size();
      const std::string name = known ? request.files[file_number - 1] : "head";
      line = match[1].str() + name + ":" + std::to_string(number % lines_a_file) + match.suffix().str();
    }
    result += line + "\n";
  }
  return result;
}

namespace {

std::string renderer() {
  const std::string text = gl_text(GL_RENDERER);
  return text.empty() ? "an unnamed renderer" : text;
}

std::string name_of_last(const ShaderRequest& request) {
  return request.files.empty() ? std::string() : request.files.back();
}

/// The driver's log of a shader or a program, by its glGet...iv and glGet...InfoLog.
template <class GetNumber, class GetLog>
std::string log_of(GLuint name, GetNumber get_number, GetLog get_log) {
  GLint length = 0;
  get_number(name, GL_INFO_LOG_LENGTH, &length);
  std::string log(static_cast<std::size_t>(length), '\0');
  if (length > 0) get_log(name, length, nullptr, log.data());
  return log.c_str();  // up to its end, which the length counts too
}

/// Needed until the program has it.
Handle<ShaderKind> compiled(GLenum stage, const ShaderLibrary& library, const ShaderRequest& request) {
  Handle<ShaderKind> shader(glCreateShader(stage));
  const std::string text = library.text(request, stage == GL_COMPUTE_SHADER ? Stage::compute : Stage::drawing);
  const char* start = text.c_str();
  glShaderSource(*shader, 1, &start, nullptr);
  glCompileShader(*shader);
  GLint good = GL_FALSE;
  glGetShaderiv(*shader, GL_COMPILE_STATUS, &good);
  if (good == GL_TRUE) return shader;
  const char* kind = stage == GL_VERTEX_SHADER ? "vertex" : stage == GL_COMPUTE_SHADER ? "compute" : "fragment";
  throw Error(ErrorCode::device,
              std::string(kind) + " shader " + name_of_last(request) + " does not compile on " + renderer() + ":\n" +
                  ShaderLibrary::readable(log_of(*shader, glGetShaderiv, glGetShaderInfoLog), request));
}

}  // namespace

void Program::link(std::initializer_list<GLuint> shaders, const ShaderRequest& named) {
  Handle<ProgramKind> program(glCreateProgram());
  for (const GLuint shader : shaders) glAttachShader(*program, shader);
  glLinkProgram(*program);
  GLint good = GL_FALSE;
  glGetProgramiv(*program, GL_LINK_STATUS, &good);
  if (good != GL_TRUE) {
    throw Error(ErrorCode::device,
                "the program of " + name_of_last(named) + " does not link on " + renderer() + ":\n" +
                    ShaderLibrary::readable(log_of(*program, glGetProgramiv, glGetProgramInfoLog), named));
  }
  id_ = std::move(program);
}

Program::Program(const ShaderLibrary& library, const ShaderRequest& vertex, const ShaderRequest& fragment) {
  const auto corners = compiled(GL_VERTEX_SHADER, library, vertex);
  const auto body = compiled(GL_FRAGMENT_SHADER, library, fragment);
  link({*corners, *body}, fragment);
}

Program Program::computing(const ShaderLibrary& library, const ShaderRequest& request) {
  const auto shader = compiled(GL_COMPUTE_SHADER, library, request);
  Program program;
  program.link({*shader}, request);
  return program;
}

GLint Program::use_uniform(const char* name) {
  glUseProgram(*id_);
  for (const Uniform& known : uniforms_) {
    if (known.name == name) return known.location;
  }
  uniforms_.push_back({name, uniform(name)});
  return uniforms_.back().location;
}

}  // namespace phymul::gl
