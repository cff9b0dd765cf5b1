// SPDX-License-Identifier: MIT
//
// A reference case as its file says it; bench/reference/README.md documents the format. Expressions stay text until a
// level and a resolution give their variables values.
#pragma once

#include <array>
#include <string>
#include <utility>
#include <vector>

#include "expression.h"

namespace phymul::bench {

using Triple = std::array<std::string, 3>;  ///< three expressions; "-" where nothing is said of an axis

struct ReferenceCase {
  struct Level {
    std::string name;
    std::vector<std::pair<std::string, std::string>> values;
  };
  struct OnGroup {
    std::string group;
    Triple value;
  };
  struct PlacedTool {
    std::string name, shape;         ///< shape: sphere, capsule, half-space, box
    std::vector<std::string> sizes;  ///< m
    Triple place, displacement;      ///< m; the case is about where it has come to
    Triple axis{"0", "0", "1"};      ///< where its own +z points
  };

  std::string name;  ///< of the file, without folder and extension
  std::string title;
  std::vector<std::pair<std::string, std::string>> lets;
  std::vector<std::pair<std::string, std::string>> fields;  ///< of the place: name, expression in x, y, z
  std::vector<Level> levels;
  std::vector<std::string> main_levels;  ///< those the charts draw; all where none is named

  std::string body;                    ///< block, tetrahedra, cylinder, filled, file
  std::vector<std::string> body_args;  ///< expressions; for file: path (may hold {n}) and unit
  std::vector<std::string> cells;      ///< three expressions in n
  std::vector<int> resolutions;
  Triple map{"-", "-", "-"};
  Triple material{"1e4", "0.3", "1000"};
  std::vector<std::pair<std::string, std::string>> groups;  ///< name, condition in x, y, z

  std::vector<OnGroup> imposed;                                ///< m; in the order of the file, later ones hold
  std::vector<OnGroup> forces;                                 ///< N on the group as a whole
  std::vector<OnGroup> tractions;                              ///< Pa on the group's surface facets, along axes
  std::vector<std::pair<std::string, std::string>> pressures;  ///< Pa on the group's surface facets, inward
  Triple gravity{"0", "0", "0"};
  std::vector<PlacedTool> tools;

  std::string samples;         ///< CSV: level,x,y,z,ux,uy,uz; none, and no points: forces alone are known
  std::vector<Triple> points;  ///< with `exact`
  Triple exact{"-", "-", "-"};
  std::vector<OnGroup> reactions;  ///< N, of the supports on the body
  std::vector<OnGroup> torques;    ///< N m, about the rest centroid of the group
  std::vector<OnGroup> pushes;     ///< N, of the body on a tool, which stands for the group
  std::string floor = "0", force_floor = "0";

  const Level& level(const std::string& level_name) const;     ///< throws Error that lists them
  Variables variables(const std::string& level, int n) const;  ///< n, the level's values, then the lets
  std::vector<std::string> levels_to_draw() const;
  bool knows_forces() const;
};

/// Throws Error as "file:line: ...".
ReferenceCase read_case(const std::string& path);

/// Every *.case file of a folder by name, or the one file.
std::vector<ReferenceCase> read_cases(const std::string& path);

}  // namespace phymul::bench
