// SPDX-License-Identifier: MIT
#include "plain_loop.h"

#include <cmath>

namespace phymul::bench {
namespace {

using Float3 = std::array<float, 3>;

Float3 operator+(const Float3& a, const Float3& b) {
  return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}
Float3 operator-(const Float3& a, const Float3& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
Float3 operator*(float s, const Float3& a) {
  return {s * a[0], s * a[1], s * a[2]};
}
void operator+=(Float3& a, const Float3& b) {
  a = a + b;
}
float dot(const Float3& a, const Float3& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
Float3 cross(const Float3& a, const Float3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

/// A base's normal as it stands.
struct Normal {
  Float3 e1, e2, n;
  float inverse_length = 0;
};
Normal normal_of(const Float3& a, const Float3& b, const Float3& c) {
  Normal normal{b - a, c - a, {}, 0.0f};
  const Float3 w = cross(normal.e1, normal.e2);
  normal.inverse_length = 1.0f / std::sqrt(dot(w, w));
  normal.n = normal.inverse_length * w;
  return normal;
}

}  // namespace

bool PlainLoop::covers(const TopologyTextures& t) {
  return t.dimension == 3 && t.volumes.empty() && t.walls.empty() && t.domains.empty() && !t.rest.empty();
}

PlainLoop::PlainLoop(const TopologyTextures& t, const State& start) : reaction_(t.options.reaction) {
  const auto narrow = [](double value) { return static_cast<float>(value); };
  const auto float3 = [&](const Vec3& v) { return Float3{narrow(v.x()), narrow(v.y()), narrow(v.z())}; };
  for (Index i = 0; i < t.particle_count; ++i) {
    const IndexTexel& at = t.index[i];
    first_base_.push_back(static_cast<int>(bases_.size()));
    first_neighbour_.push_back(static_cast<int>(neighbours_.size()));
    for (Index b = at.first_base; b < at.first_base + at.base_count; ++b) {
      const auto& v = t.bases[b].vertex;
      bases_.push_back({{v[0], v[1], v[2]},
                        {narrow(t.lambda[b][0]), narrow(t.lambda[b][1]), narrow(t.lambda[b][2])},
                        narrow(t.bases[b].beta),
                        narrow(t.weight[b])});
    }
    for (Index r = at.first_neighbour; at.base_count > 0 && r < at.first_neighbour + at.neighbour_count; ++r) {
      neighbours_.push_back(t.neighbours[r]);
      const double share = reaction_ == Reaction::full     ? 1.0
                           : reaction_ == Reaction::shared ? 1.0 / at.neighbour_count
                                                           : t.alpha[r];
      share_.push_back(narrow(share));
    }
    x_.push_back(float3(start.position[i]));
    v_.push_back(float3(start.velocity[i]));
    stiffness_.push_back(t.stiffness.empty() ? 0.0f : narrow(t.stiffness[i]));
    inverse_mass_.push_back(narrow(1.0 / t.mass[i]));
  }
  first_base_.push_back(static_cast<int>(bases_.size()));
  first_neighbour_.push_back(static_cast<int>(neighbours_.size()));
  for (const SpringTexel& s : t.springs) {
    springs_.push_back(
        {{s.end[0], s.end[1]}, narrow((t.rest[s.end[1]] - t.rest[s.end[0]]).norm()), narrow(s.stiffness)});
  }
  force_.resize(x_.size());
}

/// Of reactions whose bases pull together: full, shared, averaged and the thesis' own.
void PlainLoop::add_attractor(int i) {
  Float3 sum{};
  float weights = 0.0f;
  for (int t = first_base_[i]; t < first_base_[i + 1]; ++t) {
    const Base& base = bases_[t];
    const Float3 &a = x_[base.vertex[0]], &b = x_[base.vertex[1]], &c = x_[base.vertex[2]];
    const Float3 foot = base.lambda[0] * a + base.lambda[1] * b + base.lambda[2] * c;
    sum += base.weight * (foot + base.beta * normal_of(a, b, c).n);
    weights += base.weight;
  }
  const Float3 F = stiffness_[i] * (sum - weights * x_[i]);
  force_[i] += F;
  if (reaction_ != Reaction::averaged) {
    for (int r = first_neighbour_[i]; r < first_neighbour_[i + 1]; ++r) force_[neighbours_[r]] += -share_[r] * F;
    return;
  }
  for (int t = first_base_[i]; t < first_base_[i + 1]; ++t) {
    const Base& base = bases_[t];
    const Normal now = normal_of(x_[base.vertex[0]], x_[base.vertex[1]], x_[base.vertex[2]]);
    const Float3 Ft = base.weight * F;
    const Float3 G = base.beta * now.inverse_length * (Ft - dot(now.n, Ft) * now.n);
    const Float3 on_b = -base.lambda[1] * Ft - cross(now.e2, G), on_c = -base.lambda[2] * Ft - cross(G, now.e1);
    force_[base.vertex[0]] += -1.0f * (Ft + on_b + on_c);
    force_[base.vertex[1]] += on_b;
    force_[base.vertex[2]] += on_c;
  }
}

void PlainLoop::add_conservative(int i) {
  for (int t = first_base_[i]; t < first_base_[i + 1]; ++t) {
    const Base& base = bases_[t];
    const Float3 &a = x_[base.vertex[0]], &b = x_[base.vertex[1]], &c = x_[base.vertex[2]];
    const Normal now = normal_of(a, b, c);
    const Float3 place = base.lambda[0] * a + base.lambda[1] * b + base.lambda[2] * c + base.beta * now.n;
    const Float3 F = stiffness_[i] * base.weight * (place - x_[i]);
    const Float3 G = base.beta * now.inverse_length * (F - dot(now.n, F) * now.n);
    const Float3 on_b = -base.lambda[1] * F - cross(now.e2, G), on_c = -base.lambda[2] * F - cross(G, now.e1);
    force_[i] += F;
    force_[base.vertex[0]] += -1.0f * (F + on_b + on_c);
    force_[base.vertex[1]] += on_b;
    force_[base.vertex[2]] += on_c;
  }
}

void PlainLoop::add_springs() {
  for (const Spring& s : springs_) {
    const Float3 r = x_[s.end[1]] - x_[s.end[0]];
    const Float3 F = s.stiffness * (1.0f - s.length / std::sqrt(dot(r, r))) * r;
    force_[s.end[0]] += F;
    force_[s.end[1]] += -1.0f * F;
  }
}

void PlainLoop::step(int steps, float dt) {
  const auto count = static_cast<int>(x_.size());
  for (; steps > 0; --steps) {
    force_.assign(x_.size(), Float3{});
    for (int i = 0; i < count; ++i) reaction_ == Reaction::conservative ? add_conservative(i) : add_attractor(i);
    add_springs();
    for (int i = 0; i < count; ++i) {
      v_[i] += dt * inverse_mass_[i] * force_[i];
      x_[i] += dt * v_[i];
    }
  }
}

}  // namespace phymul::bench
