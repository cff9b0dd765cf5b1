// SPDX-License-Identifier: MIT
#include "shader_source.h"

#include <phymul/error.h>

#include <cstdlib>
#include <fstream>
#include <regex>
#include <sstream>

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

}  // namespace

std::string ShaderLibrary::file(const std::string& name) const {
  if (!folder_.empty()) {
    const std::string path = folder_ + "/" + name;
    std::ifstream in(path, std::ios::binary);
    std::ostringstream text;
    if (!in || !(text << in.rdbuf())) {
      throw Error("the shader " + path + " could not be read; GlOptions::shader_folder or PHYMUL_GLSL names the " +
                  "folder, which must hold every file of glsl/");
    }
    return text.str();
  }
  for (const EmbeddedShader* shader = embedded_shaders; shader->name; ++shader) {
    if (name == shader->name) return shader->text;
  }
  throw Error("no shader " + name + " is built in");
}

std::string ShaderLibrary::text(const ShaderRequest& request) const {
  std::string all = es_ ? es_head : desktop_head;
  for (const auto& [name, value] : request.defines) all += "#define " + name + " " + std::to_string(value) + "\n";
  int string_number = 1;  // 0 is the head
  for (const std::string& name : request.files) {
    all += "#line 1 " + std::to_string(string_number++) + "\n" + file(name);
    if (all.back() != '\n') all += '\n';
  }
  return all;
}

std::string ShaderLibrary::readable(std::string_view log, const ShaderRequest& request) {
  // Mesa: "2:14(5): error"; NVIDIA: "2(14) : error"; ANGLE, Apple: "ERROR: 2:14: ...".
  static const std::regex place(R"(^((?:ERROR|WARNING): )?(\d+)(?::(\d+)(?:\(\d+\))?|\((\d+)\)))");
  std::istringstream lines{std::string(log)};
  std::string line, result;
  while (std::getline(lines, line)) {
    std::smatch match;
    if (std::regex_search(line, match, place)) {
      const auto string_number = static_cast<std::size_t>(std::atoi(match[2].str().c_str()));
      const std::string& where = match[3].matched ? match[3].str() : match[4].str();
      const std::string name = string_number >= 1 && string_number <= request.files.size()
                                   ? request.files[string_number - 1]
                                   : std::string("head");
      line = match[1].str() + name + ":" + where + match.suffix().str();
    }
    result += line + "\n";
  }
  return result;
}

}  // namespace phymul::gl
