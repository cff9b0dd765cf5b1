// SPDX-License-Identifier: MIT
#include "lml_units.h"

#include <numbers>

namespace phymul {
namespace {

constexpr double degree = std::numbers::pi / 180.0;
constexpr double millimetre_of_mercury = 133.322387415;  // Pa, conventional

// The first of each type is its default. `microm`, `radians`, `degrees` are older spellings.
constexpr LmlUnit units[] = {
    {"mm", LoadType::translation, 1e-3},
    {"micron", LoadType::translation, 1e-6},
    {"microm", LoadType::translation, 1e-6},
    {"nm", LoadType::translation, 1e-9},
    {"m", LoadType::translation, 1.0},
    {"radian", LoadType::rotation, 1.0},
    {"radians", LoadType::rotation, 1.0},
    {"degree", LoadType::rotation, degree},
    {"degrees", LoadType::rotation, degree},
    {"N", LoadType::force, 1.0},
    {"kN", LoadType::force, 1e3},
    {"pN", LoadType::force, 1e-12},
    {"kPa", LoadType::pressure, 1e3},
    {"mmHg", LoadType::pressure, millimetre_of_mercury},
    {"Pa", LoadType::pressure, 1.0},
    {"m/s^2", LoadType::acceleration, 1.0},
    {"cm/s^2", LoadType::acceleration, 1e-2},
    {"mm/s^2", LoadType::acceleration, 1e-3},
};

}  // namespace

const LmlUnit* find_lml_unit(LoadType type, std::string_view name) {
  for (const LmlUnit& unit : units) {
    if (unit.type == type && name == unit.name) return &unit;
  }
  return nullptr;
}

const LmlUnit& default_lml_unit(LoadType type) {
  const LmlUnit* unit = units;
  while (unit->type != type) ++unit;
  return *unit;
}

std::string known_lml_units(LoadType type) {
  std::string known;
  for (const LmlUnit& unit : units) {
    if (unit.type == type) known += (known.empty() ? "" : ", ") + std::string(unit.name);
  }
  return known;
}

const char* lml_name(LoadType type) {
  constexpr const char* names[] = {"Translation", "Rotation", "Force", "Pressure", "Acceleration"};
  return names[static_cast<int>(type)];
}

}  // namespace phymul
