// SPDX-License-Identifier: MIT
#include "lml_words.h"

#include <phymul/error.h>

#include <numbers>
#include <numeric>

#include "base/decimal.h"
#include "io/xml/xml_source.h"
#include "model/file_extras.h"

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

std::vector<Index> all_rows(const Model& model) {
  std::vector<Index> rows(model.rest.size());
  std::iota(rows.begin(), rows.end(), 0);
  return rows;
}

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

LmlTargets::LmlTargets(const Model& model)
    : model_(model),
      table_(extras_of(model).particle_index.empty() ? all_rows(model) : extras_of(model).particle_index) {}

std::int64_t LmlTargets::number(Index particle) const {
  return model_.file_index(particle);
}

Index LmlTargets::particle(std::int64_t wanted) const {
  const Index row = table_.find(wanted);
  if (row >= 0) return row;
  throw Error("expected the index of an atom, got " + std::to_string(wanted) + ", which no atom of the model has");
}

std::vector<Index> LmlTargets::resolve(std::string_view text) const {
  std::vector<char> seen(model_.rest.size(), 0);
  std::vector<Index> particles;
  for (std::size_t start = 0; start <= text.size();) {
    const std::size_t comma = std::min(text.find(',', start), text.size());
    const std::string_view item = trim(text.substr(start, comma - start));
    if (item.empty()) {
      throw Error("expected indices, ranges, names or * between commas, got nothing in " + XmlSource::cite(text));
    }
    for (const Index row : resolve_item(item)) {
      if (!seen[row]) particles.push_back(row);
      seen[row] = 1;
    }
    start = comma + 1;
  }
  return particles;
}

std::vector<Index> LmlTargets::resolve_item(std::string_view item) const {
  if (item == "*") return all_rows(model_);
  if (const std::optional<std::int64_t> single = parse_integer(item)) return {particle(*single)};
  const std::size_t dash = item.find('-', 1);
  if (dash != std::string_view::npos) {
    const std::optional<std::int64_t> first = parse_integer(item.substr(0, dash));
    const std::optional<std::int64_t> last = parse_integer(item.substr(dash + 1));
    if (first && last && *first > *last) {
      throw Error("expected a range from its smaller to its larger index, got " + XmlSource::cite(item));
    }
    if (first && last) {
      if (*first < 0) particle(*first);  // throws: no atom has it
      std::int64_t missing = -1;
      std::vector<Index> rows = table_.find_range(*first, *last, missing);
      if (static_cast<std::int64_t>(rows.size()) != *last - *first + 1) particle(missing);
      return rows;
    }
  }
  if (item.find_first_not_of("0123456789+-. ") == std::string_view::npos) {
    throw Error("expected an index, a range like 5-7, a name or *, got " + XmlSource::cite(item));
  }
  return model_.group(item);
}

std::string LmlTargets::spell(const std::vector<Index>& particles) const {
  std::string text;
  for (std::size_t i = 0; i < particles.size();) {
    const std::int64_t first = number(particles[i]);
    std::int64_t last = first;
    for (++i; i < particles.size() && number(particles[i]) == last + 1; ++i) ++last;
    if (!text.empty()) text += ',';
    text += std::to_string(first);
    if (last > first) text += '-' + std::to_string(last);
  }
  return text;
}

}  // namespace phymul
