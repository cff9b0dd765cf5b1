// SPDX-License-Identifier: MIT
#include "scene_bytes.h"

#include <algorithm>

#include "tool_bytes.h"
#include "wire_codes.h"

namespace phymul {
namespace {

bool yes(ByteReader& in, const char* what) {
  const std::uint8_t value = in.u8(what);
  if (value > 1) in.fail(std::string("expected ") + what + " (0 or 1), got " + std::to_string(value));
  return value == 1;
}

int positive(ByteReader& in, const char* what) {
  const Index value = in.index(what);
  if (value < 0) in.fail(std::string("expected ") + what + " of 0 or more, got " + std::to_string(value));
  return value;
}

void put_contacts(ByteWriter& out, const std::optional<ContactOptions>& contacts) {
  out.u8(contacts ? 1 : 0);
  if (!contacts) return;
  out.real(contacts->friction);
  out.real(contacts->margin);
  out.u8(contacts->self ? 1 : 0);
  out.index(contacts->rounds);
}

void take_contacts(ByteReader& in, Scene& scene) {
  if (!yes(in, "whether there are contacts")) {
    if (scene.contacts()) scene.no_contacts();
    return;
  }
  ContactOptions options;
  options.friction = in.real("a coefficient of friction");
  options.margin = in.real("a contact margin");
  options.self = yes(in, "whether a body touches itself");
  options.rounds = positive(in, "a number of rounds");
  scene.contacts(options);
}

void take_volumes(ByteReader& in, Scene& scene) {
  const std::size_t count = in.count(20, "a number of kept volumes");
  for (std::size_t k = 0; k < count; ++k) {
    VolumeConstraint surface;
    surface.volume = in.real("a volume");
    surface.applied_to = in.text("a group's name");
    surface.triangles.resize(in.count(12, "a number of triangles"));
    for (auto& triangle : surface.triangles) {
      for (Index& i : triangle) i = in.index("a particle");
    }
    scene.constrain_volume(std::move(surface));
  }
}

/// Tools keep their order where some go: new ones stand after those that stay.
void take_tools(ByteReader& in, Scene& scene) {
  const std::size_t count = in.count(5, "a number of tools");
  std::vector<std::pair<std::string, Tool>> added;
  std::vector<std::string> kept;
  for (std::size_t k = 0; k < count; ++k) {
    std::string name = in.text("a tool's name");
    if (yes(in, "whether a tool is new")) {
      added.emplace_back(std::move(name), take_tool(in));
    } else {
      kept.push_back(std::move(name));
    }
  }
  std::vector<std::string> gone;
  for (const SceneTool& tool : scene.tools()) {
    if (std::find(kept.begin(), kept.end(), tool.name) == kept.end()) gone.push_back(tool.name);
  }
  for (const std::string& name : gone) scene.remove_tool(name);
  if (scene.tools().size() != kept.size()) in.fail("expected tools that the scene has, got another one");
  for (auto& [name, tool] : added) scene.add_tool(std::move(name), std::move(tool));
}

}  // namespace

std::string load_bytes(const Load& load) {
  ByteWriter out;
  put_code(out, load_type_codes, load.type);
  out.indices(load.particles);
  out.u64(load.events.size());
  for (const ValueEvent& event : load.events) {
    out.real(event.date);
    out.real(event.value);
  }
  for (const Axis axis : load.axes) put_code(out, axis_codes, axis);
  out.vector(load.direction);
  out.index(load.toward);
  out.text(load.applied_to);
  return out.bytes();
}

Load take_load(ByteReader& in) {
  Load load;
  load.type = take_code(in, load_type_codes, "a type of load");
  load.particles = in.indices("particles");
  load.events.resize(in.count(16, "a number of values"));
  for (ValueEvent& event : load.events) {
    event.date = in.real("a date");
    event.value = in.real("a value");
  }
  for (Axis& axis : load.axes) axis = take_code(in, axis_codes, "an axis");
  load.direction = in.vector("a direction");
  load.toward = in.index("a particle to point toward");
  load.applied_to = in.text("a target");
  return load;
}

std::string volume_bytes(const Scene& scene) {
  ByteWriter out;
  out.u64(scene.volume_constraints().size());
  for (const VolumeConstraint& surface : scene.volume_constraints()) {
    out.real(surface.volume);
    out.text(surface.applied_to);
    out.u64(surface.triangles.size());
    for (const auto& triangle : surface.triangles) {
      for (const Index i : triangle) out.index(i);
    }
  }
  return out.bytes();
}

SceneBefore scene_as_it_is(const Scene& scene) {
  SceneBefore now;
  for (const Load& load : scene.loads()) now.loads.push_back(load_bytes(load));
  now.volumes = volume_bytes(scene);
  for (const SceneTool& tool : scene.tools()) now.tools.push_back(tool.id);
  return now;
}

std::string scene_change_bytes(const Scene& scene, const SceneBefore& before, bool anew) {
  ByteWriter out;
  out.u8(anew ? 1 : 0);
  out.vector(scene.gravity());
  put_contacts(out, scene.contacts());
  out.u64(scene.loads().size());
  ByteWriter changed;
  std::uint64_t changes = 0;
  for (std::size_t row = 0; row < scene.loads().size(); ++row) {
    const std::string bytes = load_bytes(scene.loads()[row]);
    if (!anew && row < before.loads.size() && before.loads[row] == bytes) continue;
    changed.u64(row);
    changed.raw(bytes);
    ++changes;
  }
  out.u64(changes);
  out.raw(changed.bytes());
  out.u64(scene.tools().size());
  for (const SceneTool& tool : scene.tools()) {
    out.text(tool.name);
    const bool known = !anew && std::find(before.tools.begin(), before.tools.end(), tool.id) != before.tools.end();
    out.u8(known ? 0 : 1);
    if (known) continue;
    Tool there = tool.tool;
    there.pose = tool.pose;
    put_tool(out, there);
  }
  if (anew) out.raw(volume_bytes(scene));
  return out.bytes();
}

void change_scene(Scene& scene, ByteReader& in) {
  const bool anew = yes(in, "whether the scene is made anew");
  if (anew) scene.clear();
  scene.gravity(in.vector("a gravity"));
  take_contacts(in, scene);
  const std::uint64_t count = in.u64("a number of loads");
  const std::size_t changes = in.count(16, "a number of changed loads");
  for (std::size_t k = 0; k < changes; ++k) {
    const std::uint64_t row = in.u64("a load's row");
    if (row > scene.loads().size() || row >= count) {
      in.fail("expected the row of a load, " + std::to_string(scene.loads().size()) + " or less, got " +
              std::to_string(row));
    }
    if (row == scene.loads().size()) {
      scene.add(take_load(in));
    } else {
      scene.replace(row, take_load(in));
    }
  }
  if (scene.loads().size() < count) in.fail("expected " + std::to_string(count) + " loads, got fewer");
  while (scene.loads().size() > count) scene.remove(scene.loads().size() - 1);
  take_tools(in, scene);
  if (anew) take_volumes(in, scene);
  in.expect_end("a change of the scene");
}

}  // namespace phymul
