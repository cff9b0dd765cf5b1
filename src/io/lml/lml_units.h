// SPDX-License-Identifier: MIT
#pragma once

#include <phymul/scene.h>

#include <string>
#include <string_view>

namespace phymul {

/// A unit of LML and what a value in it is in SI.
struct LmlUnit {
  const char* name;
  LoadType type;
  double factor;
};

/// nullptr: no load of this type has such a unit.
const LmlUnit* find_lml_unit(LoadType type, std::string_view name);

/// The unit meant where a load has none, and the one that is written.
const LmlUnit& default_lml_unit(LoadType type);

/// "mm, micron, nm, ..."
std::string known_lml_units(LoadType type);

/// Spelling of LML ("Translation").
const char* lml_name(LoadType type);

}  // namespace phymul
