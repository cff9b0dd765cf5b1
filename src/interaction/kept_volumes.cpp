// SPDX-License-Identifier: MIT
#include "kept_volumes.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace phymul {
namespace {

/// What of a push a rough tool that presses the particle lets through: along its surface less, by what friction bears
/// of the push against it. Without that what sticks to a tool would creep, a little in each step: tools act before.
Vec3 past_friction(const Vec3& push, const Vec3& rubbed) {
  const double friction = rubbed.norm();
  if (!(friction > 0.0)) return push;
  const Vec3 normal = rubbed / friction, against = normal.dot(push) * normal, along = push - against;
  const double bears = friction * against.norm(), size = along.norm();
  return size > bears ? Vec3(against + (1.0 - bears / size) * along) : against;
}

}  // namespace

KeptVolumes::Surface KeptVolumes::made(const VolumeConstraint& kept) {
  Surface surface;
  surface.triangles = kept.triangles;
  for (const auto& t : kept.triangles) surface.particles.insert(surface.particles.end(), t.begin(), t.end());
  std::sort(surface.particles.begin(), surface.particles.end());
  surface.particles.erase(std::unique(surface.particles.begin(), surface.particles.end()), surface.particles.end());
  for (auto& t : surface.triangles) {
    for (Index& i : t) {
      const auto at = std::lower_bound(surface.particles.begin(), surface.particles.end(), i);
      i = static_cast<Index>(at - surface.particles.begin());
    }
  }
  for (VecList* list : {&surface.start, &surface.end, &surface.gradient, &surface.along}) {
    list->resize(surface.particles.size());
  }
  surface.now.name = surface.next.name = kept.name;
  return surface;
}

/// The scene may have another volume of that name by now.
bool KeptVolumes::is_of(const Surface& surface, const VolumeConstraint& kept) {
  const auto same = [&](const std::array<Index, 3>& rows, const std::array<Index, 3>& particles) {
    return std::ranges::equal(rows, particles, {}, [&](Index row) { return surface.particles[row]; });
  };
  return surface.now.name == kept.name && std::ranges::equal(surface.triangles, kept.triangles, same);
}

void KeptVolumes::follow(const Scene& scene) {
  std::vector<Surface> now;
  now.reserve(scene.volume_constraints().size());
  for (std::size_t row = 0; row < scene.volume_constraints().size(); ++row) {
    const VolumeConstraint& kept = scene.volume_constraints()[row];
    const auto known = std::ranges::find_if(surfaces_, [&](const Surface& surface) { return is_of(surface, kept); });
    Surface& surface = now.emplace_back(known != surfaces_.end() ? std::move(*known) : made(kept));
    surface.open = scene.is_open(row);
    surface.law = kept.fluid;
    surface.whole = kept.volume;
    if (surface.seen != kept.changes) {
      surface.now.volume = kept.volume;
      surface.has_pressure = false;
      surface.seen = kept.changes;
    }
  }
  surfaces_ = std::move(now);
  find_groups(scene);
}

/// A volume that is cut open is the outside, also for those that it opens into.
void KeptVolumes::find_groups(const Scene& scene) {
  const std::vector<VolumeConstraint>& all = scene.volume_constraints();
  std::vector<FluidExchange::Link> links, outside;
  for (int row = 0; row < static_cast<int>(all.size()); ++row) {
    surfaces_[row].linked = false;
    const Fluid& fluid = all[row].fluid;
    if (fluid.opens_into.empty() || !(fluid.conductance > 0.0)) continue;
    const int into = static_cast<int>(std::ranges::find(all, fluid.opens_into, &VolumeConstraint::name) - all.begin());
    if (surfaces_[into].open) continue;
    (surfaces_[row].open ? outside : links).push_back({row, into, fluid.conductance});
  }
  std::vector<int> first(all.size());  // row of the group
  std::iota(first.begin(), first.end(), 0);
  for (const auto& [from, into, conductance] : links) {
    surfaces_[from].law.conductance = 0.0;
    surfaces_[from].linked = surfaces_[into].linked = true;
    const auto [low, high] = std::minmax({first[from], first[into]});
    std::ranges::replace(first, high, low);
  }
  for (const auto& [from, into, conductance] : outside) {
    Fluid& law = surfaces_[into].law;  // two openings are one, of the mean pressure behind them
    const double sum = law.conductance + conductance;
    law.outlet_pressure *= law.conductance / sum;
    law.conductance = sum;
  }
  groups_.clear();
  for (int row = 0; row < static_cast<int>(all.size()); ++row) {
    if (!surfaces_[row].linked || first[row] != row) continue;
    Group& group = groups_.emplace_back();
    std::vector<int> place(all.size(), -1);
    for (std::size_t k = 0; k < all.size(); ++k) {
      if (first[k] != row) continue;
      place[k] = static_cast<int>(group.rows.size());
      group.rows.push_back(k);
    }
    for (const auto& [from, into, conductance] : links) {
      if (first[from] == row) group.exchange.links.push_back({place[from], place[into], conductance});
    }
    group.exchange.allocate(static_cast<int>(group.rows.size()));
  }
}

void KeptVolumes::reset(const Scene& scene, const State& state) {
  for (std::size_t row = 0; row < surfaces_.size(); ++row) {
    Surface& surface = surfaces_[row];
    const auto known = std::ranges::find(state.fluids, surface.now.name, &FluidState::name);
    const auto begins_anew = [](double pressure_before) {
      return pressure_before == 0.0 && std::signbit(pressure_before);
    };
    surface.has_pressure = known != state.fluids.end() && !begins_anew(known->pressure_before);
    if (known != state.fluids.end()) {
      surface.now = *known;
    } else {
      surface.now.volume = scene.volume_constraints()[row].volume;
      surface.now.pressure = surface.now.pressure_before = 0.0;
    }
  }
}

/// A fluid that begins anew in its next step has a pressure before of -0, which equals that of others.
void KeptVolumes::read(const Scene& scene, State& state) const {
  state.fluids.clear();
  for (const Surface& surface : surfaces_) {
    const auto own = std::ranges::find_if(scene.volume_constraints(),
                                          [&](const VolumeConstraint& kept) { return is_of(surface, kept); });
    if (own == scene.volume_constraints().end()) continue;
    FluidState& fluid = state.fluids.emplace_back(surface.now);
    const bool was_set = surface.seen != own->changes;
    if (was_set) fluid.volume = own->volume;
    if (was_set || !surface.has_pressure) fluid.pressure_before = -0.0;
  }
}

const FluidState& KeptVolumes::fluid(const VolumeConstraint& wanted) const {
  const auto known = std::ranges::find(surfaces_, wanted.name, [](const Surface& of) { return of.now.name; });
  if (known != surfaces_.end()) return known->now;
  unseen_ = {.name = wanted.name, .volume = wanted.volume};
  return unseen_;
}

/// In the remainder of a call nothing flows between volumes.
int KeptVolumes::act(TouchedParticles& touched) {
  const bool remainder = touched.is_remainder();
  for (std::size_t row = 0; row < surfaces_.size(); ++row) {
    Surface& surface = surfaces_[row];
    if (surface.open || (surface.linked && !remainder)) continue;
    if (remainder && surface.law.law == FluidLaw::incompressible) {
      surface.next = surface.now;
    } else if (!restore(surface, predicted(surface, touched), touched)) {
      return static_cast<int>(row);
    }
  }
  if (remainder) return -1;
  for (Group& group : groups_) {
    if (const int row = restore(group, touched); row >= 0) return row;
  }
  return -1;
}

int KeptVolumes::restore(Group& group, TouchedParticles& touched) {
  std::vector<FluidExchange::Volume>& volumes = group.exchange.volumes;
  volumes.clear();
  for (const std::size_t row : group.rows) {
    Surface& surface = surfaces_[row];
    FluidPush push = predicted(surface, touched);
    push.conductance = 0.0;
    volumes.push_back({.push = push,
                       .reached = surface.reached,
                       .along = surface.cubic,
                       .conductance = surface.law.conductance,
                       .outlet_pressure = surface.law.outlet_pressure,
                       .p = surface.now.pressure});
  }
  int lost = group.exchange.solve();
  for (std::size_t k = 0; k < volumes.size() && lost < 0; ++k) {
    volumes[k].push.volume = volumes[k].left;
    if (!restore(surfaces_[group.rows[k]], volumes[k].push, touched, volumes[k].p)) lost = static_cast<int>(k);
  }
  return lost < 0 ? -1 : static_cast<int>(group.rows[lost]);
}

bool KeptVolumes::is_finite() const {
  return std::ranges::all_of(surfaces_, [](const Surface& surface) {
    const FluidState& next = surface.next;
    return surface.open || std::isfinite(next.volume + next.pressure + next.pressure_before);
  });
}

void KeptVolumes::accept(double dt) {
  flow_ = 0.0;
  for (Surface& surface : surfaces_) {
    if (surface.open) {
      surface.now.pressure = surface.now.pressure_before = 0.0;
      continue;
    }
    const double side = std::cbrt(surface.whole);
    flow_ = std::max(flow_, std::abs(surface.next.volume - surface.now.volume) / (6.0 * side * side * dt));
    surface.now.volume = surface.next.volume;
    surface.now.pressure = surface.next.pressure;
    surface.now.pressure_before = surface.next.pressure_before;
    surface.has_pressure = true;
  }
}

/// Where the step would take a surface, and what the fluid in it is then.
FluidPush KeptVolumes::predicted(Surface& surface, TouchedParticles& touched) {
  // Without copies of the particles, which would take longer than all else here. No other surface has them.
  touched.fetch(surface.particles, surface.start, surface.end);
  for (std::size_t k = 0; k < surface.particles.size(); ++k) {
    surface.end[k] = surface.start[k] + touched.dt() * surface.end[k];
    if (const auto* copy = touched.find(surface.particles[k])) surface.end[k] += copy->shift;
  }
  volume_gradient(surface.triangles, surface.start, surface.gradient);
  for (std::size_t k = 0; k < surface.particles.size(); ++k) {
    const Index particle = surface.particles[k];
    const auto* copy = touched.find(particle);
    if (copy != nullptr) surface.gradient[k] = past_friction(surface.gradient[k], copy->rubbed);
    surface.gradient[k] = free_part(surface.gradient[k], touched.fixed(particle));
    const bool held = copy != nullptr && copy->held;
    surface.along[k] = held ? Vec3(Vec3::Zero()) : Vec3(touched.inverse_mass(particle) * surface.gradient[k]);
  }
  FluidPush push{.fluid = surface.law, .volume = surface.now.volume, .dt = touched.dt(), .whole = surface.whole};
  if (push.has_law()) {
    push.now = fluid_pressure(surface.law, enclosed_volume(surface.triangles, surface.start) / surface.now.volume);
    push.before = surface.has_pressure ? surface.now.pressure_before : push.now;
  }
  // By the same sum as Scene's, so that rest stays rest.
  surface.reached = enclosed_volume(surface.triangles, surface.end);
  surface.cubic = volume_along(surface.triangles, surface.end, surface.along);
  return push;
}

bool KeptVolumes::restore(Surface& surface, const FluidPush& push, TouchedParticles& touched, double otherwise) {
  const double reached = surface.reached;
  auto s = root_of_cubic(surface.cubic, [&](double at) -> WantedVolume {
    const WantedVolume all = push(at);
    return {all.volume - reached, all.slope};
  });
  surface.next.volume = s ? push.left(*s) : push.volume;
  // What an opening sucks dry stays as flat as it is.
  const bool dry = !s && push.conductance > 0.0 && reached > 0.0 && push(0.0).volume < reached;
  if (dry) {
    s = 0.0;
    surface.next.volume = reached / fluid_ratio(surface.law, 0.0).volume;
  }
  surface.next.pressure = s && !dry ? push.pressure(*s) : otherwise;
  surface.next.pressure_before = push.now + 0.0;  // not -0: read()
  // Where nothing is free to make up for it, what a backend in single precision rounds is not a loss; nor is what is no
  // number, whose particle is found out elsewhere.
  if (!s) return !(std::abs(push.volume - reached) > rounded_volume_share * push.volume);
  for (std::size_t k = 0; k < surface.particles.size(); ++k) {
    // s d is a way; over dt a velocity, times the mass an impulse.
    const Vec3 impulse = *s / touched.dt() * surface.gradient[k];
    auto* copy = touched.find(surface.particles[k]);
    if (copy == nullptr) {
      if (impulse != Vec3::Zero()) touched.push_last(surface.particles[k], impulse);
    } else {
      TouchedParticles::pull(*copy, impulse);
    }
  }
  return true;
}

}  // namespace phymul
