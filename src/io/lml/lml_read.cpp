// SPDX-License-Identifier: MIT
#include <phymul/lml.h>

#include <algorithm>
#include <array>
#include <new>
#include <pugixml.hpp>

#include "base/byte_source.h"
#include "base/decimal.h"
#include "base/files.h"
#include "io/xml/xml_source.h"
#include "lml_words.h"

namespace phymul {
namespace {

constexpr std::size_t max_bytes = std::size_t{1} << 30;

/// Without a namespace prefix: files of all dialects are read alike.
std::string_view local(std::string_view name) {
  const std::size_t colon = name.rfind(':');
  return colon == std::string_view::npos ? name : name.substr(colon + 1);
}

/// The children of one load, before any is understood: they come in any order.
struct LoadParts {
  pugi::xml_node applied_to, direction, unit;
  std::vector<pugi::xml_node> events;
  bool generated = false;  // applied_to was made by write_lml
};

class LmlReader {
 public:
  LmlReader(std::string text, std::string source, const Model& model)
      : xml_(std::move(text), std::move(source), true), targets_(model) {}

  std::vector<Load> read(std::vector<std::string>* notes);

 private:
  Load read_load(pugi::xml_node node);
  LoadParts parts_of(pugi::xml_node load);
  LoadType type_of(pugi::xml_node load) const;
  std::string text_in(pugi::xml_node node) const;
  const LmlUnit& unit_of(pugi::xml_node load, LoadType type, pugi::xml_node node);
  void read_target(const LoadParts& parts, Load& load);
  void read_events(const LoadParts& parts, Load& load, const DecimalUnit& unit) const;
  void read_direction(pugi::xml_node node, Load& load) const;
  void read_axes(pugi::xml_node node, Load& load) const;
  void require_direction(pugi::xml_node load_node, pugi::xml_node node, const Load& load) const;

  XmlSource xml_;
  LmlTargets targets_;
};

std::vector<Load> LmlReader::read(std::vector<std::string>* notes) {
  const pugi::xml_node root = xml_.root();
  if (local(root.name()) != "loads") {
    xml_.fail(root, "expected <loads>, got <" + std::string(root.name()) + '>' +
                        (local(root.name()) == "physicalModel" ? "; read bodies with read_pml" : ""));
  }
  std::vector<Load> loads;
  for (const pugi::xml_node child : root.children()) {
    if (child.type() != pugi::node_element) continue;
    if (local(child.name()) == "load") {
      loads.push_back(read_load(child));
    } else {
      xml_.skip(child);
    }
  }
  if (notes != nullptr) {
    for (std::string& note : xml_.take_notes()) notes->push_back(std::move(note));
  }
  return loads;
}

Load LmlReader::read_load(pugi::xml_node node) {
  Load load{.type = type_of(node)};
  const LoadParts parts = parts_of(node);
  if (!parts.applied_to) xml_.fail(node, "expected <appliedTo> in <load>, got none");
  read_target(parts, load);
  read_events(parts, load, DecimalUnit(unit_of(node, load.type, parts.unit).factor));
  if (parts.direction) {
    read_direction(parts.direction, load);
  } else if (load.type != LoadType::pressure) {
    xml_.fail(node, std::string("expected <direction> in a load of type ") + lml_name(load.type) + ", got none");
  }
  require_direction(node, parts.direction, load);
  return load;
}

LoadParts LmlReader::parts_of(pugi::xml_node load) {
  LoadParts parts;
  for (const pugi::xml_node child : load.children()) {
    const std::string_view kind = local(child.name());
    if (child.type() == pugi::node_pi) {
      parts.generated = parts.generated || (kind == "phymul" && child.value() == std::string_view("generated"));
      continue;
    }
    if (child.type() != pugi::node_element) continue;
    pugi::xml_node* const single = kind == "appliedTo"   ? &parts.applied_to
                                   : kind == "direction" ? &parts.direction
                                   : kind == "unit"      ? &parts.unit
                                                         : nullptr;
    if (kind == "valueEvent") {
      parts.events.push_back(child);
    } else if (single == nullptr) {
      xml_.skip(child);
    } else if (*single) {
      xml_.fail(child, "expected one <" + std::string(kind) + "> in <load>, got a second one; the first is on line " +
                           std::to_string(xml_.line(*single)));
    } else {
      *single = child;
    }
  }
  return parts;
}

LoadType LmlReader::type_of(pugi::xml_node load) const {
  std::string known;
  std::string_view name;
  for (const pugi::xml_attribute attribute : load.attributes()) {
    if (local(attribute.name()) == "type") name = local(attribute.value());
  }
  for (const LoadType type :
       {LoadType::translation, LoadType::rotation, LoadType::force, LoadType::pressure, LoadType::acceleration}) {
    if (name == lml_name(type)) return type;
    known += (known.empty() ? "" : ", ") + std::string(lml_name(type));
  }
  xml_.fail(load, "expected attribute xsi:type (or type) of <load> to be one of " + known + ", got " +
                      (name.data() == nullptr ? "none" : XmlSource::cite(name)));
}

/// Comments part it.
std::string LmlReader::text_in(pugi::xml_node node) const {
  std::string text;
  for (const pugi::xml_node part : node.children()) {
    if (part.type() == pugi::node_element) {
      xml_.fail(part, "expected text alone in <" + std::string(node.name()) + ">, got <" + part.name() + '>');
    }
    if (part.type() != pugi::node_pi) text += part.value();
  }
  return std::string(trim(text));
}

const LmlUnit& LmlReader::unit_of(pugi::xml_node load, LoadType type, pugi::xml_node node) {
  if (!node) {
    const LmlUnit& assumed = default_lml_unit(type);
    xml_.note(load, std::string("no <unit> in a load of type ") + lml_name(type) + ": " + assumed.name + " is assumed");
    return assumed;
  }
  const std::string name = text_in(node);
  const LmlUnit* const unit = find_lml_unit(type, name);
  if (unit != nullptr) return *unit;
  xml_.fail(node, std::string("expected a unit of a load of type ") + lml_name(type) + " (" + known_lml_units(type) +
                      "), got " + XmlSource::cite(name));
}

void LmlReader::read_target(const LoadParts& parts, Load& load) {
  const std::string text = text_in(parts.applied_to);
  try {
    load.particles = targets_.resolve(text);
  } catch (const Error& error) {
    xml_.fail(parts.applied_to, std::string("appliedTo: ") + error.what());
  }
  if (load.particles.empty()) {
    xml_.note(parts.applied_to, "appliedTo: " + XmlSource::cite(text) + " has no particles; the load does nothing");
  }
  if (!parts.generated) load.applied_to = text;
}

void LmlReader::read_events(const LoadParts& parts, Load& load, const DecimalUnit& unit) const {
  for (const pugi::xml_node node : parts.events) {
    const std::string_view text = xml_.text(node, "value");
    const std::optional<double> value = unit.parse(text);
    if (!value) xml_.fail(node, "expected a finite number with a decimal point in value, got " + XmlSource::cite(text));
    load.events.push_back({xml_.number(node, "date"), *value});
  }
  std::stable_sort(load.events.begin(), load.events.end(),
                   [](const ValueEvent& a, const ValueEvent& b) { return a.date < b.date; });
}

void LmlReader::read_direction(pugi::xml_node node, Load& load) const {
  const pugi::xml_attribute toward = node.attribute("toward");
  if (toward) {
    try {
      load.toward = targets_.particle(xml_.index(node, "toward", toward.value()));
    } catch (const Error& error) {
      const std::string message = error.what();
      if (message.starts_with(xml_.where(node))) throw;
      xml_.fail(node, "toward: " + message);
    }
  }
  read_axes(node, load);
}

void LmlReader::read_axes(pugi::xml_node node, Load& load) const {
  constexpr std::array<const char*, 3> names = {"x", "y", "z"};
  for (int axis = 0; axis < 3; ++axis) {
    const pugi::xml_attribute attribute = node.attribute(names[static_cast<std::size_t>(axis)]);
    Axis& state = load.axes[static_cast<std::size_t>(axis)];
    if (!attribute) {
      state = load.toward >= 0 ? Axis::driven : Axis::free;
    } else if (trim(attribute.value()) == "NULL") {
      state = Axis::held;
    } else if (load.toward >= 0) {
      xml_.fail(node, std::string("expected toward or coordinates in <direction>, got toward and ") + attribute.name() +
                          "=" + XmlSource::cite(attribute.value()));
    } else {
      state = Axis::driven;
      load.direction[axis] = xml_.number(node, attribute.name(), attribute.value());
    }
  }
}

/// What Scene::add would refuse is refused here, where the line is known.
void LmlReader::require_direction(pugi::xml_node load_node, pugi::xml_node node, const Load& load) const {
  const bool driven = std::find(load.axes.begin(), load.axes.end(), Axis::driven) != load.axes.end();
  if (driven && load.events.empty()) {
    xml_.fail(load_node, "expected at least one <valueEvent> in <load>, got none");
  }
  if (!node || load.toward >= 0 || load.direction != Vec3(0, 0, 0)) return;
  if (load.type == LoadType::rotation) {
    xml_.fail(node, "expected the axis of a rotation, of a length above 0, in <direction>");
  }
  const bool idle =
      std::all_of(load.events.begin(), load.events.end(), [](const ValueEvent& event) { return event.value == 0.0; });
  if (driven && !idle) {
    xml_.fail(node, std::string("expected a direction of a length above 0, got (0, 0, 0); write NULL to hold an axis") +
                        (load.type == LoadType::pressure ? ", or leave <direction> out to press inward" : ""));
  }
}

}  // namespace

std::vector<Load> read_lml_text(std::string text, const std::string& source, const Model& model,
                                std::vector<std::string>* notes) {
  try {
    return LmlReader(std::move(text), source, model).read(notes);
  } catch (const std::bad_alloc&) {
    fail_memory(source);
  }
}

std::vector<Load> read_lml(const std::string& path, const Model& model, std::vector<std::string>* notes) {
  return read_lml_text(read_whole_file(path, max_bytes), path, model, notes);
}

}  // namespace phymul
