// SPDX-License-Identifier: MIT
#include "scene_bytes.h"

#include <phymul/state.h>

#include <algorithm>
#include <functional>
#include <utility>

#include "wire_codes.h"

namespace phymul {
namespace {

// What a thing is made of, for a ByteWriter and a thing that is const, or a ByteReader and one that is not.

template <class Bytes, class Contacts>
void contact_fields(Bytes& bytes, Contacts& contacts) {
  bytes.field(contacts.friction, "a coefficient of friction");
  bytes.field(contacts.margin, "a contact margin");
  bytes.field(contacts.self, "whether a body touches itself");
  bytes.field(contacts.rounds, "a number of rounds");
}

template <class Bytes, class Any>
void load_fields(Bytes& bytes, Any& load) {
  code(bytes, load.type, "a type of load");
  bytes.field(load.particles, "particles");
  bytes.list(load.events, 16, "a number of values", [&](auto& event) {
    bytes.field(event.date, "a date");
    bytes.field(event.value, "a value");
  });
  for (auto& axis : load.axes) code(bytes, axis, "an axis");
  bytes.field(load.direction, "a direction");
  bytes.field(load.toward, "a particle to point toward");
  bytes.field(load.applied_to, "a target");
}

/// What a JointHandle can change: stiffness, damping (f64), rest lengths (count u64, f64 each).
std::string joint_value_bytes(const Joint& joint) {
  ByteWriter out;
  out.real(joint.stiffness);
  out.real(joint.damping);
  out.u64(joint.springs.size());
  for (const JointSpring& spring : joint.springs) out.real(spring.rest_length);
  return out.bytes();
}

void change_joint_values(const JointHandle& joint, ByteReader& in) {
  const double stiffness = in.real("a joint's stiffness"), damping = in.real("a joint's damping");
  std::vector<double> lengths(in.count(8, "a number of rest lengths"));
  for (double& length : lengths) length = in.real("a rest length");
  joint.set_stiffness(stiffness, damping);
  joint.set_rest_lengths(lengths);
}

bool yes(ByteReader& in, const char* what) {
  bool value = false;
  in.field(value, what);
  return value;
}

template <class Bytes, class Laws>
void tearing_fields(Bytes& bytes, Laws& laws) {
  bytes.list(laws, 16, "a number of laws of tearing", [&](auto& law) {
    bytes.field(law.toughness, "a toughness");
    bytes.field(law.radius, "a radius");
  });
}

void take_tearing(ByteReader& in, Scene& scene) {
  std::vector<Tearing> laws;
  tearing_fields(in, laws);
  if (!laws.empty() && laws.size() != scene.model().materials.size()) {
    in.fail("expected a law of tearing for each material, got " + std::to_string(laws.size()));
  }
  if (laws.empty() && !scene.tearing().empty()) scene.tear({});
  for (std::size_t row = 0; row < laws.size(); ++row) scene.tear(scene.model().materials[row], laws[row]);
}

void take_contacts(ByteReader& in, Scene& scene) {
  if (!yes(in, "whether there are contacts")) {
    if (scene.contacts()) scene.no_contacts();
    return;
  }
  ContactOptions options;
  contact_fields(in, options);
  scene.contacts(options);
}

/// For a ByteWriter and factors that are const, or a ByteReader and ones that are not.
template <class Bytes, class Factors>
void stiffness_fields(Bytes& bytes, Factors& factors) {
  bytes.list(factors, 8, "a number of stiffness factors", [&](auto& factor) { bytes.field(factor, "a factor"); });
}

void take_stiffness(ByteReader& in, Scene& scene) {
  std::vector<double> factors;
  stiffness_fields(in, factors);
  if (factors != scene.stiffness_factors()) scene.scale_stiffness(factors);
}

/// Tools keep their order where some go: new ones stand after those that stay.
void take_tools(ByteReader& in, Scene& scene) {
  const std::size_t count = in.count(5, "a number of tools");
  std::vector<std::pair<std::string, Tool>> added;
  std::vector<std::string> kept;
  for (std::size_t k = 0; k < count; ++k) {
    std::string name = in.text("a tool's name");
    if (yes(in, "whether a tool is new")) {
      tool_fields(in, added.emplace_back(std::move(name), Tool{}).second);
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

/// Joints that stay, and what changed of them; the others go, before the tools that they have anchors at.
void take_kept_joints(ByteReader& in, Scene& scene) {
  const std::size_t count = in.count(5, "a number of joints");
  std::vector<std::string> kept;
  for (std::size_t k = 0; k < count; ++k) {
    kept.push_back(in.text("a joint's name"));
    const JointHandle joint = scene.joint(kept.back());
    if (yes(in, "whether a joint changed")) change_joint_values(joint, in);
  }
  std::vector<std::string> gone;
  for (const SceneJoint& joint : scene.joints()) {
    if (std::find(kept.begin(), kept.end(), joint.name) == kept.end()) gone.push_back(joint.name);
  }
  for (const std::string& name : gone) scene.remove_joint(name);
}

const SceneBefore::Joint* known_joint(const SceneBefore& before, const SceneJoint& joint) {
  const auto known = std::ranges::find(before.joints, joint.id, &SceneBefore::Joint::id);
  return known != before.joints.end() ? &*known : nullptr;
}

void put_kept_joints(ByteWriter& out, const Scene& scene, const SceneBefore& before) {
  ByteWriter kept;
  std::uint64_t count = 0;
  for (const SceneJoint& joint : scene.joints()) {
    const SceneBefore::Joint* const known = known_joint(before, joint);
    if (known == nullptr) continue;
    ++count;
    kept.text(joint.name);
    const std::string values = joint_value_bytes(joint.joint);
    kept.field(values != known->values, "");
    if (values != known->values) kept.raw(values);
  }
  out.u64(count);
  out.raw(kept.bytes());
}

void put_new_joints(ByteWriter& out, const Scene& scene, const SceneBefore& before) {
  ByteWriter added;
  std::uint64_t count = 0;
  for (const SceneJoint& joint : scene.joints()) {
    if (known_joint(before, joint) != nullptr) continue;
    ++count;
    added.text(joint.name);
    joint_fields(added, joint.joint);
  }
  out.u64(count);
  out.raw(added.bytes());
}

/// Whether those that were there come first, in the order of before, as take_tools() and joints have them.
bool is_appended(const Scene& scene, const SceneBefore& before) {
  const auto in_order = [](const auto& items, const auto& known, auto id_of) {
    std::vector<std::ptrdiff_t> rows;
    for (const auto& item : items) rows.push_back(std::ranges::find(known, item.id, id_of) - known.begin());
    return std::ranges::is_sorted(rows);
  };
  return in_order(scene.tools(), before.tools, std::identity()) &&
         in_order(scene.joints(), before.joints, &SceneBefore::Joint::id);
}

void put_order(ByteWriter& out, const Scene& scene) {
  out.u64(scene.tools().size() + scene.joints().size());
  for (const SceneTool& tool : scene.tools()) out.text(tool.name);
  for (const SceneJoint& joint : scene.joints()) out.text(joint.name);
}

void take_order(ByteReader& in, Scene& scene) {
  std::vector<std::string> names(in.count(4, "a number of names"));
  for (std::string& name : names) name = in.text("a name");
  const auto place = [&](const auto& item) { return std::ranges::find(names, item.first) - names.begin(); };
  const auto joints = names.begin() + static_cast<std::ptrdiff_t>(std::min(names.size(), scene.tools().size()));
  const auto place_of_joint = [&](const auto& item) { return std::find(joints, names.end(), item.first) - joints; };
  SceneParts parts = scene.parts();
  std::ranges::stable_sort(parts.tools, {}, place);
  std::ranges::stable_sort(parts.joints, {}, place_of_joint);
  scene.bring_back(parts);
}

}  // namespace

std::string load_bytes(const Load& load) {
  ByteWriter out;
  load_fields(out, load);
  return out.bytes();
}

Load take_load(ByteReader& in) {
  Load load;
  load_fields(in, load);
  return load;
}

SceneBefore scene_as_it_is(const Scene& scene) {
  SceneBefore now;
  for (const Load& load : scene.loads()) now.loads.push_back(load_bytes(load));
  now.volumes = scene.volume_constraints();
  for (const SceneTool& tool : scene.tools()) now.tools.push_back(tool.id);
  for (const SceneJoint& joint : scene.joints()) now.joints.push_back({joint.id, joint_value_bytes(joint.joint)});
  now.tearing = scene.tearing();
  return now;
}

std::string scene_change_bytes(const Scene& scene, const SceneBefore& before, bool anew) {
  ByteWriter out;
  out.u8(anew ? 1 : 0);
  out.vector(scene.gravity());
  out.field(scene.contacts().has_value(), "");
  if (scene.contacts()) contact_fields(out, *scene.contacts());
  stiffness_fields(out, scene.stiffness_factors());
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
  const SceneBefore from = anew ? SceneBefore{} : before;
  put_kept_joints(out, scene, from);
  out.u64(scene.tools().size());
  for (const SceneTool& tool : scene.tools()) {
    out.text(tool.name);
    const bool known = !anew && std::find(before.tools.begin(), before.tools.end(), tool.id) != before.tools.end();
    out.u8(known ? 0 : 1);
    if (known) continue;
    Tool there = tool.tool;
    if (anew) there.pose = tool.pose;
    tool_fields(out, there);
  }
  put_new_joints(out, scene, from);
  const bool ordered = anew || is_appended(scene, before);
  const bool tears = !ordered || from.tearing != scene.tearing();
  const bool volumes = tears || from.volumes != scene.volume_constraints();
  if (anew) out.u64(0);  // kept volumes where files had them before fluids
  if (anew && (volumes || !scene.threads().empty())) put_threads(out, scene.threads());
  if (volumes) put_volumes(out, scene, from.volumes);
  // Last, for files written before do not have them.
  if (tears) tearing_fields(out, scene.tearing());
  if (!ordered) put_order(out, scene);
  return out.bytes();
}

void change_scene(Scene& scene, ByteReader& in) {
  const bool anew = yes(in, "whether the scene is made anew");
  if (anew) scene.clear();
  scene.gravity(in.vector("a gravity"));
  take_contacts(in, scene);
  take_stiffness(in, scene);
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
      scene.replace(static_cast<std::size_t>(row), take_load(in));
    }
  }
  if (scene.loads().size() < count) in.fail("expected " + std::to_string(count) + " loads, got fewer");
  while (scene.loads().size() > count) scene.remove(scene.loads().size() - 1);
  take_kept_joints(in, scene);
  take_tools(in, scene);
  const std::size_t added = in.count(8, "a number of new joints");
  for (std::size_t k = 0; k < added; ++k) {
    std::string name = in.text("a joint's name");
    Joint joint;
    joint_fields(in, joint);
    scene.add_joint(std::move(name), std::move(joint));
  }
  if (anew) take_old_volumes(in, scene);
  if (anew && in.remaining() > 0) add_threads(in, scene);
  if (in.remaining() > 0) take_volumes(in, scene);
  if (in.remaining() > 0) take_tearing(in, scene);
  if (in.remaining() > 0) take_order(in, scene);
  in.expect_end("a change of the scene");
}

}  // namespace phymul
