// SPDX-License-Identifier: MIT
#include <phymul/lml.h>

#include <array>
#include <cmath>
#include <ostream>

#include "base/decimal.h"
#include "base/files.h"
#include "io/xml/xml_writer.h"
#include "lml_words.h"

namespace phymul {
namespace {

void require_writable(const Load& load, const Model& model) {
  const auto fail = [&](const std::string& message) {
    throw Error(std::string(lml_name(load.type)) + (load.applied_to.empty() ? "" : " on \"" + load.applied_to + '"') +
                ": " + message);
  };
  const Index count = model.particle_count();
  for (const Index i : load.particles) {
    if (i < 0 || i >= count) fail("expected particles of the model, got " + std::to_string(i));
  }
  if (load.toward >= count)
    fail("expected a particle of the model to point toward, got " + std::to_string(load.toward));
  for (const ValueEvent& event : load.events) {
    if (!std::isfinite(event.date) || !std::isfinite(event.value)) fail("expected finite dates and values");
  }
  for (int axis = 0; axis < 3; ++axis) {
    const Axis state = load.axes[static_cast<std::size_t>(axis)];
    if (state == Axis::driven && !std::isfinite(load.direction[axis])) fail("expected a finite direction");
    if (state == Axis::free && load.toward >= 0) fail("expected no free axis beside toward, which LML cannot say");
  }
}

bool presses_inward(const Load& load) {
  const std::array<Axis, 3> all_driven = {Axis::driven, Axis::driven, Axis::driven};
  return load.type == LoadType::pressure && load.toward < 0 && load.axes == all_driven &&
         load.direction == Vec3(0, 0, 0);
}

void write_direction(XmlWriter& xml, const Load& load, const LmlTargets& targets) {
  constexpr std::array<const char*, 3> names = {"x", "y", "z"};
  xml.open("direction");
  if (load.toward >= 0) xml.attribute("toward", std::to_string(targets.number(load.toward)));
  for (int axis = 0; axis < 3; ++axis) {
    const Axis state = load.axes[static_cast<std::size_t>(axis)];
    const char* const name = names[static_cast<std::size_t>(axis)];
    if (state == Axis::held) xml.raw_attribute(name, "NULL");
    if (state == Axis::driven && load.toward < 0) xml.attribute(name, load.direction[axis]);
  }
  xml.close();
}

/// The load's own words where they still mean its particles.
bool still_means(const LmlTargets& targets, const Load& load) {
  if (load.applied_to.empty()) return false;
  try {
    return targets.resolve(load.applied_to) == load.particles;
  } catch (const Error&) {
    return false;
  }
}

void write_load(XmlWriter& xml, const Load& load, const LmlTargets& targets) {
  const LmlUnit& unit = default_lml_unit(load.type);
  const bool own_words = still_means(targets, load);
  if (!own_words && load.particles.empty()) {
    throw Error(std::string(lml_name(load.type)) + ": expected at least one particle, got none");
  }
  xml.open("load");
  xml.attribute("xsi:type", std::string_view(lml_name(load.type)));
  if (!own_words) xml.instruction("phymul generated");
  xml.open("appliedTo");
  xml.text(own_words ? load.applied_to : targets.spell(load.particles));
  xml.close();
  std::string value;
  for (const ValueEvent& event : load.events) {
    value.clear();
    DecimalUnit(unit.factor).append(value, event.value);
    xml.open("valueEvent");
    xml.attribute("date", event.date);
    xml.raw_attribute("value", value);
    xml.close();
  }
  if (!presses_inward(load)) write_direction(xml, load, targets);
  xml.open("unit");
  xml.text(unit.name);
  xml.close();
  xml.close();
}

}  // namespace

void write_lml(const std::vector<Load>& loads, const Model& model, std::ostream& out) {
  for (const Load& load : loads) require_writable(load, model);
  const LmlTargets targets(model);
  XmlWriter xml(out);
  xml.open("loads");
  xml.attribute("xmlns", std::string_view("http://www-timc.imag.fr/load"));
  xml.attribute("xmlns:xsi", std::string_view("http://www.w3.org/2001/XMLSchema-instance"));
  for (const Load& load : loads) write_load(xml, load, targets);
  xml.close();
  xml.finish();
}

void write_lml(const std::vector<Load>& loads, const Model& model, const std::string& path) {
  replace_file(path, [&](std::ostream& out) { write_lml(loads, model, out); });
}

}  // namespace phymul
