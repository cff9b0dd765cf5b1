// SPDX-License-Identifier: MIT
#include "reference_case.h"

#include <phymul/error.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>

#include "case_tool.h"

namespace phymul::bench {
namespace {

namespace fs = std::filesystem;
using Words = std::vector<std::string>;

Words split(const std::string& line) {
  std::istringstream in(line);
  Words words;
  for (std::string word; in >> word;) words.push_back(word);
  return words;
}

std::string joined(const Words& words, std::size_t first) {
  std::string text;
  for (std::size_t k = first; k < words.size(); ++k) text += (k > first ? " " : "") + words[k];
  return text;
}

void require_count(const Words& words, std::size_t least, std::size_t most, const char* usage) {
  if (words.size() > least && words.size() <= most + 1) return;
  throw Error("expected: " + words[0] + " " + usage);
}

Triple triple(const Words& words, std::size_t first) {
  return {words[first], words[first + 1], words[first + 2]};
}

std::pair<std::string, std::string> assignment(const std::string& word) {
  const std::size_t equals = word.find('=');
  if (equals == 0 || equals == std::string::npos) throw Error("expected name=expression, got \"" + word + "\"");
  return {word.substr(0, equals), word.substr(equals + 1)};
}

ReferenceCase::OnGroup on_group(const Words& words, const char* usage = "GROUP x y z") {
  require_count(words, 4, 4, usage);
  return {words[1], triple(words, 2)};
}

void read_file(const fs::path& path, ReferenceCase& it);

/// `folder`: of the file that has the line.
void read_line(const Words& w, const fs::path& folder, ReferenceCase& it) {
  const std::string& key = w[0];
  constexpr std::size_t any = 1000;
  if (key == "include") {
    require_count(w, 1, 1, "FILE");
    read_file(folder / w[1], it);
  } else if (key == "title") {
    it.title = joined(w, 1);
  } else if (key == "let") {
    require_count(w, 2, 2, "NAME expression");
    it.lets.emplace_back(w[1], w[2]);
  } else if (key == "field") {
    require_count(w, 2, 2, "NAME expression");
    it.fields.emplace_back(w[1], w[2]);
  } else if (key == "level") {
    require_count(w, 1, any, "NAME name=expression ...");
    ReferenceCase::Level& level = it.levels.emplace_back();
    level.name = w[1];
    for (std::size_t k = 2; k < w.size(); ++k) level.values.push_back(assignment(w[k]));
  } else if (key == "main") {
    it.main_levels.assign(w.begin() + 1, w.end());
  } else if (key == "body") {
    require_count(w, 2, 7, "block|tetrahedra|cylinder|filled|file arguments");
    it.body = w[1];
    it.body_args.assign(w.begin() + 2, w.end());
    if (it.body == "file") it.body_args[0] = (folder / w[2]).string();
  } else if (key == "cells") {
    require_count(w, 3, 3, "x y z, or rings sectors layers");
    it.cells.assign(w.begin() + 1, w.end());
  } else if (key == "resolutions") {
    it.resolutions.clear();
    for (std::size_t k = 1; k < w.size(); ++k) it.resolutions.push_back(static_cast<int>(evaluate(w[k], {})));
  } else if (key == "map") {
    require_count(w, 3, 3, "x y z");
    it.map = triple(w, 1);
  } else if (key == "material") {
    require_count(w, 3, 3, "young poisson density");
    it.material = triple(w, 1);
  } else if (key == "group") {
    require_count(w, 2, any, "NAME condition");
    it.groups.emplace_back(w[1], joined(w, 2));
  } else if (key == "fix") {
    require_count(w, 1, 1, "GROUP");
    it.imposed.push_back({w[1], {"0", "0", "0"}});
  } else if (key == "move") {
    it.imposed.push_back(on_group(w));
  } else if (key == "force") {
    it.forces.push_back(on_group(w));
  } else if (key == "traction") {
    it.tractions.push_back(on_group(w));
  } else if (key == "pressure") {
    require_count(w, 2, 2, "GROUP expression");
    it.pressures.emplace_back(w[1], w[2]);
  } else if (key == "gravity") {
    require_count(w, 3, 3, "x y z");
    it.gravity = triple(w, 1);
  } else if (key == "tool") {
    it.tools.push_back(read_tool(w));
  } else if (key == "push") {
    const ReferenceCase::OnGroup push = on_group(w, "TOOL fx fy fz");
    std::erase_if(it.pushes, [&](const ReferenceCase::OnGroup& other) { return other.group == push.group; });
    it.pushes.push_back(push);
  } else if (key == "samples") {
    require_count(w, 1, 1, "FILE");
    it.samples = (folder / w[1]).string();
  } else if (key == "point") {
    require_count(w, 3, 3, "x y z");
    it.points.push_back(triple(w, 1));
  } else if (key == "exact") {
    require_count(w, 3, 3, "ux uy uz");
    it.exact = triple(w, 1);
  } else if (key == "reaction") {
    it.reactions.push_back(on_group(w));
  } else if (key == "torque") {
    it.torques.push_back(on_group(w));
  } else if (key == "floor") {
    require_count(w, 1, 2, "displacement force");
    it.floor = w[1];
    if (w.size() > 2) it.force_floor = w[2];
  } else {
    throw Error("unknown key \"" + key + "\"; bench/reference/README.md has the list");
  }
}

void read_file(const fs::path& path, ReferenceCase& it) {
  std::ifstream in(path);
  if (!in) throw Error(path.string() + ": expected a case file that can be read");
  int number = 0;
  for (std::string line; std::getline(in, line);) {
    ++number;
    const Words words = split(line.substr(0, line.find('#')));
    if (words.empty()) continue;
    try {
      read_line(words, path.parent_path(), it);
    } catch (const Error& error) {
      throw Error(path.string() + ":" + std::to_string(number) + ": " + error.what());
    }
  }
}

void require_complete(const ReferenceCase& it, const std::string& path) {
  const auto require = [&](bool there, const char* what) {
    if (!there) throw Error(path + ": expected " + what);
  };
  require(!it.body.empty(), "a line \"body\"");
  require(it.body == "file" || !it.cells.empty(), "a line \"cells\"");
  require(!it.resolutions.empty(), "a line \"resolutions\" with at least one number");
  require(it.points.empty() == (it.exact[0] == "-"), "\"point\" lines and \"exact\" together");
  require(!it.samples.empty() || !it.points.empty() || it.knows_forces(),
          "\"samples\", or \"point\" lines and \"exact\"; or, for forces alone, \"reaction\", \"torque\" or \"push\"");
  std::set<std::string> names;
  for (const ReferenceCase::PlacedTool& tool : it.tools) {
    require(names.insert(tool.name).second, ("one tool \"" + tool.name + "\", not several").c_str());
  }
  for (const ReferenceCase::OnGroup& push : it.pushes) {
    require(names.contains(push.group), ("a line \"tool " + push.group + "\" for the line \"push\"").c_str());
  }
}

}  // namespace

const ReferenceCase::Level& ReferenceCase::level(const std::string& level_name) const {
  std::string known;
  for (const Level& it : levels) {
    if (it.name == level_name) return it;
    known += " " + it.name;
  }
  throw Error("case " + name + " has no level \"" + level_name + "\"; there are:" + known);
}

Variables ReferenceCase::variables(const std::string& level_name, int n) const {
  Variables result{{"n", n}};
  for (const auto& [key, text] : level(level_name).values) result[key] = evaluate(text, result);
  for (const auto& [key, text] : lets) result[key] = evaluate(text, result);
  return result;
}

bool ReferenceCase::knows_forces() const {
  return !reactions.empty() || !torques.empty() || !pushes.empty();
}

std::vector<std::string> ReferenceCase::levels_to_draw() const {
  if (!main_levels.empty()) return main_levels;
  std::vector<std::string> all;
  for (const Level& it : levels) all.push_back(it.name);
  return all;
}

ReferenceCase read_case(const std::string& path) {
  ReferenceCase it;
  it.name = fs::path(path).stem().string();
  it.title = it.name;
  read_file(path, it);
  if (it.levels.empty()) it.levels.push_back({"only", {}});
  require_complete(it, path);
  for (const std::string& main : it.main_levels) it.level(main);
  return it;
}

std::vector<ReferenceCase> read_cases(const std::string& path) {
  if (!fs::is_directory(path)) return {read_case(path)};
  std::vector<std::string> files;
  for (const fs::directory_entry& entry : fs::directory_iterator(path)) {
    if (entry.path().extension() == ".case") files.push_back(entry.path().string());
  }
  std::ranges::sort(files);
  if (files.empty()) throw Error(path + ": expected at least one file *.case in this folder");
  std::vector<ReferenceCase> cases;
  for (const std::string& file : files) cases.push_back(read_case(file));
  return cases;
}

}  // namespace phymul::bench
