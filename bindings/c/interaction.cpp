// SPDX-License-Identifier: MIT
//
// Tools, jaws, joints and skins.
#include <algorithm>

#include "named.h"

using namespace phymul;
using namespace phymul::c;

static_assert(static_cast<int>(ToolContact::surface) == PHYMUL_TOUCHES_SURFACE);

namespace phymul::c {

ToolHandle tool_of(phymul_simulation* sim, uint64_t tool) {
  Scene& scene = scene_of(sim);
  return scene.tool(name_of(scene.tools(), tool, "tool"));
}

ToolPose pose_of(const phymul_pose* given) {
  const phymul_pose from = options_of(given, "a pose");
  const double* q = from.orientation;
  ToolPose pose{.position = vector(from.position, "a position"),
                .velocity = vector(from.velocity, "a velocity"),
                .spin = vector(from.spin, "a spin")};
  if (q[0] != 0.0 || q[1] != 0.0 || q[2] != 0.0 || q[3] != 0.0) pose.orientation = Quaternion(q[0], q[1], q[2], q[3]);
  return pose;
}

Anchor anchor_of(phymul_simulation* sim, const phymul_anchor* given) {
  const phymul_anchor from = options_of(given, "an anchor");
  if (!from.particles && from.count == 0) {
    if (from.tool == 0) return at_world(vector(from.point, "a point"));
    const Scene& scene = scene_of(sim);
    return at_tool(name_of(scene.tools(), from.tool, "tool"), vector(from.point, "a point"));
  }
  const auto particles = list(from.particles, from.count, "particles");
  if (!from.weights) return at_mean({particles.begin(), particles.end()});
  return {.particles = {particles.begin(), particles.end()}, .weights = {from.weights, from.weights + from.count}};
}

}  // namespace phymul::c

namespace {

/// [N] m, now. Empty at rest: then nothing needs the solver yet, whose choice depends on what is added.
VecList places_of(phymul_simulation* sim) {
  return sim->moved ? sim->simulation.solver().read().position : VecList{};
}

JointHandle joint_of(phymul_simulation* sim, uint64_t joint) {
  Scene& scene = scene_of(sim);
  return scene.joint(name_of(scene.joints(), joint, "joint"));
}

constexpr Constant<phymul_needle, Needle> needle_constants[] = {
    {&phymul_needle::length, &Needle::length},
    {&phymul_needle::radius, &Needle::radius},
    {&phymul_needle::puncture, &Needle::puncture},
    {&phymul_needle::cutting, &Needle::cutting},
    {&phymul_needle::static_friction, &Needle::static_friction},
    {&phymul_needle::kinetic_friction, &Needle::kinetic_friction},
    {&phymul_needle::spread, &Needle::spread},
    {&phymul_needle::bending_stiffness, &Needle::bending_stiffness},
    {&phymul_needle::arc_radius, &Needle::arc_radius},
    {&phymul_needle::leaving, &Needle::leaving}};

constexpr Constant<phymul_jaws_options, JawsOptions> jaws_constants[] = {
    {&phymul_jaws_options::length, &JawsOptions::length},
    {&phymul_jaws_options::width, &JawsOptions::width},
    {&phymul_jaws_options::thickness, &JawsOptions::thickness},
    {&phymul_jaws_options::friction, &JawsOptions::friction},
    {&phymul_jaws_options::grip, &JawsOptions::grip},
    {&phymul_jaws_options::opening, &JawsOptions::opening},
    {&phymul_jaws_options::speed, &JawsOptions::speed}};

ToolShape shape_of(const phymul_tool_options& from) {
  require_kind(from.shape, PHYMUL_SPHERE, 6, "a shape");
  switch (from.shape) {
    case PHYMUL_SPHERE:
      return Sphere{.radius = from.radius};
    case PHYMUL_CAPSULE:
      return Capsule{.radius = from.radius, .length = from.length};
    case PHYMUL_HALF_SPACE:
      return HalfSpace{};
    case PHYMUL_NEEDLE:
      return constants_of(from.needle, needle_constants, "constants of a needle");
    case PHYMUL_BLADE:
      return Blade{.width = from.length,
                   .toughness = from.toughness,
                   .belly = from.belly,
                   .bow = from.bow,
                   .height = from.height,
                   .friction = from.side_friction};
    default:
      return Box{.half_size = vector(from.half_size, "a half size")};
  }
}

/// Where the jaws' plates are. Throws Error for another simulation.
const Simulation& simulation_of(const phymul_jaws* jaws, phymul_simulation* sim) {
  const Simulation& simulation = need(sim, "a simulation").simulation;
  if (!need(jaws, "jaws").jaws.first().is_of(simulation.scene()))
    throw Error("expected the simulation that the jaws were made with, got another");
  return simulation;
}

}  // namespace

phymul_status phymul_tool_add(phymul_simulation* sim, const phymul_tool_options* options, uint64_t* tool) {
  return guarded([&] {
    need(tool, "a place for the tool");
    const phymul_tool_options from = options_of(options, "options of a tool");
    require_kind(from.contact, PHYMUL_TOUCHES_PARTICLES, 2, "a kind of contact");
    *tool = scene_of(sim)
                .add_tool(Tool{.shape = shape_of(from),
                               .pose = from.pose ? pose_of(from.pose) : ToolPose{},
                               .friction = from.friction,
                               .compliance = from.compliance,
                               .margin = from.margin,
                               .contact = static_cast<ToolContact>(from.contact),
                               .suction = from.suction,
                               .suction_reach = from.suction_reach})
                .id();
  });
}

phymul_status phymul_tool_remove(phymul_simulation* sim, uint64_t tool) {
  return guarded([&] {
    Scene& scene = scene_of(sim);
    scene.remove_tool(std::string(name_of(scene.tools(), tool, "tool")));
  });
}

phymul_status phymul_tool_move_to(phymul_simulation* sim, uint64_t tool, const phymul_pose* pose) {
  return guarded([&] { tool_of(sim, tool).move_to(pose_of(pose)); });
}

phymul_status phymul_tool_teleport(phymul_simulation* sim, uint64_t tool, const phymul_pose* pose) {
  return guarded([&] { tool_of(sim, tool).teleport(pose_of(pose)); });
}

phymul_status phymul_tool_grasp(phymul_simulation* sim, uint64_t tool, double distance) {
  return guarded([&] { tool_of(sim, tool).grasp(distance); });
}

phymul_status phymul_tool_release(phymul_simulation* sim, uint64_t tool) {
  return guarded([&] { tool_of(sim, tool).release(); });
}

phymul_status phymul_tool_read_pose(phymul_simulation* sim, uint64_t tool, phymul_pose* pose) {
  return guarded([&] {
    const Place place(pose, "a place for the pose");
    const ToolHandle handle = tool_of(sim, tool);
    const ToolPose& now = sim->simulation.pose_of(handle);
    const Quaternion& q = now.orientation;
    phymul_pose result{};
    std::ranges::copy(std::array{q.w(), q.x(), q.y(), q.z()}, result.orientation);
    store(now.position, result.position);
    store(now.velocity, result.velocity);
    store(now.spin, result.spin);
    place.fill(result);
  });
}

phymul_status phymul_tool_read_force(phymul_simulation* sim, uint64_t tool, phymul_tool_force* force) {
  return guarded([&] {
    const Place place(force, "a place for the force");
    const ToolHandle handle = tool_of(sim, tool);
    const ToolForce& now = sim->simulation.force_on(handle);
    phymul_tool_force result{};
    store(now.force, result.force);
    store(now.torque, result.torque);
    store(now.mean_force, result.mean_force);
    store(now.mean_torque, result.mean_torque);
    result.particles = now.particles;
    result.held = sim->simulation.solver().held(handle);
    place.fill(result);
  });
}

phymul_status phymul_needle_read(phymul_simulation* sim, uint64_t tool, phymul_needle_state* state) {
  return guarded([&] {
    const Place place(state, "a place for the state of the needle");
    const Scene& scene = scene_of(sim);
    const std::string& name = name_of(scene.tools(), tool, "tool");
    if (!std::holds_alternative<Needle>(std::ranges::find(scene.tools(), tool, &SceneTool::id)->tool.shape))
      throw Error("expected a needle; the tool \"" + name + "\" has another shape");
    const State now = sim->simulation.solver().read();
    const auto own = std::ranges::find(now.tools, name, &ToolState::name);
    phymul_needle_state result{};
    if (own != now.tools.end()) {
      result.nodes = static_cast<int32_t>(own->needle.hole.size());
      result.punctured = own->needle.punctured;
      result.through = own->needle.through;
      result.is_free = own->needle.free;
      result.slip = own->needle.slip;
    }
    place.fill(result);
  });
}

phymul_status phymul_needle_points(phymul_simulation* sim, uint64_t tool, int32_t count, double* points) {
  return guarded([&] {
    need(points, "a place for the points");
    const std::string& name = name_of(scene_of(sim).tools(), tool, "tool");
    const VecList places = sim->simulation.solver().needle_points(name, count);
    for (std::size_t k = 0; k < places.size(); ++k) store(places[k], points + 3 * k);
  });
}

phymul_status phymul_jaws_create(phymul_simulation* sim, const char* name, const phymul_jaws_options* options,
                                 const phymul_pose* hinge, phymul_jaws** made) {
  return guarded([&] {
    need(made, "a place for the jaws");
    JawsOptions wanted = constants_of(options, jaws_constants, "options of jaws");
    const phymul_jaws_options given = options ? options_of(options, "options of jaws") : phymul_jaws_options{};
    if (given.touches_particles != 0) wanted.contact = ToolContact::particles;
    if (given.cuts != 0) wanted.toughness = given.toughness;
    Scene& scene = scene_of(sim);
    *made = new phymul_jaws{.jaws = Jaws(scene, &need(name, "a name of the jaws"), wanted, pose_of(hinge))};
  });
}

void phymul_jaws_free(phymul_jaws* jaws) {
  delete jaws;
}

phymul_status phymul_jaws_close(phymul_jaws* jaws, int32_t closes) {
  return guarded([&] { closes != 0 ? need(jaws, "jaws").jaws.close() : need(jaws, "jaws").jaws.open(); });
}

phymul_status phymul_jaws_follow(phymul_jaws* jaws, phymul_simulation* sim, const phymul_pose* hinge, double dt) {
  return guarded([&] {
    const Simulation& simulation = simulation_of(jaws, sim);
    Jaws& own = jaws->jaws;
    own.follow(pose_of(hinge), simulation.force_on(own.first()), simulation.force_on(own.second()), dt);
  });
}

phymul_status phymul_jaws_read(const phymul_jaws* jaws, phymul_simulation* sim, phymul_jaws_report* report) {
  return guarded([&] {
    const Place place(report, "a place for the report");
    simulation_of(jaws, sim);
    const Jaws& own = jaws->jaws;
    phymul_jaws_report result{};
    result.angle = own.angle();
    result.grip = own.grip();
    store(own.force(), result.force);
    store(own.torque(), result.torque);
    result.plates[0] = own.first().id();
    result.plates[1] = own.second().id();
    place.fill(result);
  });
}

phymul_status phymul_joint_add(phymul_simulation* sim, const phymul_anchor* a, const phymul_anchor* b,
                               const phymul_joint_options* options, uint64_t* joint) {
  return guarded([&] {
    need(joint, "a place for the joint");
    const phymul_joint_options from = options_of(options, "options of a joint");
    Joint added{.stiffness = from.stiffness, .damping = from.damping, .slack = from.slack != 0};
    if (from.breaking != 0.0) added.breaking_force = from.breaking;
    added.springs.push_back({.a = anchor_of(sim, a), .b = anchor_of(sim, b), .rest_length = from.rest_length});
    Scene& scene = scene_of(sim);
    *joint = scene.add_joint(std::move(added), places_of(sim)).id();
  });
}

phymul_status phymul_attach(phymul_simulation* sim, const int32_t* particles, int32_t count, const char* group,
                            uint64_t tool, const double offset[3], const phymul_joint_options* options,
                            uint64_t* joint) {
  return guarded([&] {
    need(joint, "a place for the joint");
    const phymul_joint_options from = options_of(options, "options of a joint");
    Attachment springs{.stiffness = from.stiffness, .damping = from.damping, .slack = from.slack != 0};
    if (from.breaking != 0.0) springs.breaking_stress = from.breaking;
    const auto patch = list(particles, count, "particles");
    Scene& scene = scene_of(sim);
    const VecList places = places_of(sim);
    springs.position = places;
    if (group) {
      *joint = scene.attach(patch, group, springs).id();
    } else if (tool != 0) {
      *joint = scene.attach(patch, tool_of(sim, tool), springs).id();
    } else {
      *joint = scene.attach(patch, World{.offset = vector(offset, "an offset")}, springs).id();
    }
  });
}

phymul_status phymul_hold_near(phymul_simulation* sim, const double* vertices, int32_t vertex_count,
                               const int32_t* triangles, int32_t triangle_count, const double centre[3], double radius,
                               double spacing, uint64_t* joint) {
  return guarded([&] {
    need(joint, "a place for the joint");
    const Surface surface{.vertices = vectors(vertices, vertex_count, "vertices"),
                          .triangles = triples(triangles, triangle_count, "triangles"),
                          .notes = {}};
    const Vec3 middle = vector(centre, "a centre");
    const SurfacePatch patch =
        sample_surface(surface, spacing, [&](const Vec3& place) { return (place - middle).norm() <= radius; });
    *joint = scene_of(sim).hold(patch).id();
  });
}

phymul_status phymul_add_body_types(phymul_simulation* sim, const char** sentences) {
  return guarded([&] {
    need(sentences, "a place for the sentences");
    phymul_simulation& own = need(sim, "a simulation");
    own.body_types = lines(add_body_types(own.simulation.scene()));
    *sentences = own.body_types.c_str();
  });
}

phymul_status phymul_joint_remove(phymul_simulation* sim, uint64_t joint) {
  return guarded([&] {
    Scene& scene = scene_of(sim);
    scene.remove_joint(std::string(name_of(scene.joints(), joint, "joint")));
  });
}

phymul_status phymul_joint_set(phymul_simulation* sim, uint64_t joint, double stiffness, double damping) {
  return guarded([&] { joint_of(sim, joint).set_stiffness(stiffness, damping); });
}

phymul_status phymul_joint_read(phymul_simulation* sim, uint64_t joint, phymul_joint_report* report) {
  return guarded([&] {
    const Place place(report, "a place for the report");
    const JointHandle handle = joint_of(sim, joint);
    const JointReport& now = sim->simulation.report_of(handle);
    phymul_joint_report result{};
    result.largest = now.largest;
    result.broken = now.broken;
    result.springs = static_cast<int32_t>(handle.joint().springs.size());
    store(now.force, result.force);
    place.fill(result);
  });
}

phymul_status phymul_skin_create(const phymul_simulation* sim, const double* points, int32_t point_count,
                                 const int32_t* triangles, int32_t triangle_count, phymul_skin** made) {
  return guarded([&] {
    need(made, "a place for the skin");
    const VecList places = vectors(points, point_count, "points");
    auto faces = triples(triangles, triangle_count, "triangles");
    VecList normals(places.size(), Vec3::Zero());
    surface_normals(faces, places, normals);  // refuses triangles of points that there are not
    *made = new phymul_skin{.skin = Skin(need(sim, "a simulation").simulation.model(), places),
                            .triangles = std::move(faces),
                            .points = places,
                            .normals = std::move(normals)};
  });
}

void phymul_skin_free(phymul_skin* skin) {
  delete skin;
}

phymul_status phymul_skin_deform(phymul_skin* skin, phymul_simulation* sim, const double** points,
                                 const double** normals) {
  return guarded([&] {
    phymul_skin& own = need(skin, "a skin");
    need(points, "a place for the points");
    own.skin.deform(need(sim, "a simulation").simulation.solver().read().position, own.points);
    *points = doubles(own.points);
    if (!normals) return;
    surface_normals(own.triangles, own.points, own.normals);
    *normals = doubles(own.normals);
  });
}
