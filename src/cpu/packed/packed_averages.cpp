// SPDX-License-Identifier: MIT
#include "packed_averages.h"

#include <phymul/error.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <string>
#include <string_view>
#include <unordered_map>

#include "device/float_range.h"
#include "topology/energies.h"

namespace phymul::cpu {
namespace {

/// Bytes a step above which a core finds hardly anything of a pass in its own caches.
constexpr double own_caches = 16e6;

using LinkRow = std::array<float, 4>;

LinkRow row_of(const Vec3& area, double stiffness) {
  // Equal rows must have equal bytes: + 0 turns -0 into 0.
  return {narrow(area.x()) + 0.0f, narrow(area.y()) + 0.0f, narrow(area.z()) + 0.0f, narrow(stiffness)};
}

/// Domains that d is linked with, with C_de and C_ed; where that is not zero also d itself.
struct Link {
  Index domain;
  Vec3 there, back;
  double stiffness;
};

void find_links(const TopologyTextures& t, Index d, std::vector<Link>& all) {
  constexpr double rounding = 1e-11;  // of a stiffness that is zero by symmetry, as along the edges of cubes
  all.clear();
  double stiffest = 0.0;
  for (const LinkTexel& link : t.links_of(d)) stiffest = std::max(stiffest, std::abs(link.stiffness));
  for (const LinkTexel& link : t.links_of(d)) {
    const double stiffness = std::abs(link.stiffness) > rounding * stiffest ? link.stiffness : 0.0;
    all.push_back({d + link.offset, link.area, -link.area, stiffness});
  }
  for (const SurfaceLinkTexel& surface : t.surface_links_of(d)) {
    auto known = std::ranges::find(all, d + surface.offset, &Link::domain);
    if (known == all.end()) known = all.insert(known, {d + surface.offset, Vec3::Zero(), Vec3::Zero(), 0.0});
    known->there += surface.area;
    known->back += surface.area;
  }
}

/// By slot, of even number: a link to itself that does nothing makes it so.
void find_even_links(const TopologyTextures& t, Index d, std::vector<Link>& all) {
  find_links(t, d, all);
  if (all.size() % 2 == 1) all.push_back({d, Vec3::Zero(), Vec3::Zero(), 0.0});
}

void put_constants(const TopologyTextures& t, Index d, std::int32_t place, PackedAverages& to) {
  const std::size_t constants = kind_of(t.options.strain_energy).constants;
  const auto lanes = static_cast<std::size_t>(to.lanes), at = static_cast<std::size_t>(place);
  const auto put = [&](std::size_t column, double value) {
    to.constants[(at / lanes * (2 + constants) + column) * lanes + at % lanes] = narrow(value);
  };
  put(0, t.domains[d].inverse_volume);
  put(1, t.domains[d].spread_stiffness);
  for (std::size_t k = 0; k < constants; ++k) put(2 + k, t.energy_of(d)[k]);
}

class AveragesPacker {
 public:
  AveragesPacker(const TopologyTextures& t, const std::vector<Index>& order, std::int32_t places, int lanes,
                 PackedAverages& to)
      : t_(t), order_(order), places_(places), lanes_(lanes), to_(to), place_of_domain_(t.domains.size()) {}

  bool pack(AveragedLinks links) {
    to_.lanes = lanes_;
    to_.plane = t_.dimension == 2;
    place_domains();
    if (links == AveragedLinks::runs && !pack_runs()) return false;
    if (links == AveragedLinks::by_slot) pack_by_slot();
    add_constants();
    return true;
  }

 private:
  void require_offsets(std::size_t rows, std::int32_t most) const {
    if (rows <= static_cast<std::size_t>(most)) return;
    throw Error("the body has " + std::to_string(t_.particle_count) +
                " particles, too many for 32-bit offsets; the backend \"reference\" has no such limit");
  }

  void pack_by_slot() {
    std::size_t links = 0;  // surface links mostly join the same domains
    for (const DomainTexel& domain : t_.domains) {
      links += static_cast<std::size_t>(std::max(domain.link_count, domain.surface_link_count)) + 1;
    }
    require_offsets(links, std::numeric_limits<std::int32_t>::max() / 4);
    for (const Index d : domain_of_quad_) {
      to_.link_range.push_back(static_cast<std::int32_t>(to_.link.size()));
      if (d != none) {
        add_links(d);
      } else {
        to_.stress_row.push_back(0);
        to_.force_row.push_back(0);
      }
      to_.link_range.push_back(static_cast<std::int32_t>(to_.link.size()));
    }
    to_.link.resize(to_.link.size() + simd::links_ahead, 0);
  }

  void place_domains() {
    std::vector<Index> places(static_cast<std::size_t>(places_), none);  // domain
    std::vector<std::pair<std::int32_t, std::int32_t>> further;          // places
    for (std::size_t place = 0; place < order_.size(); ++place) {
      const Index i = order_[place];
      for (Index d = t_.first_domain[i]; d < t_.first_domain[i + 1]; ++d) {
        if (d == t_.first_domain[i]) {
          places[place] = d;
        } else {
          further.emplace_back(static_cast<std::int32_t>(place), static_cast<std::int32_t>(places.size()));
          places.push_back(d);
        }
      }
    }
    const auto whole = static_cast<std::size_t>(lanes_);
    places.resize((places.size() + whole - 1) / whole * whole, none);
    require_offsets(places.size(), std::numeric_limits<std::int32_t>::max() / 16);
    to_.slots = static_cast<std::int32_t>(places.size());
    domain_of_quad_.assign(places.size(), none);
    to_.domain_of_place = places;
    for (std::size_t place = 0; place < places.size(); ++place) {
      const auto slot = static_cast<std::int32_t>(place);
      domain_of_quad_[simd::quad_of(slot, lanes_)] = places[place];
      if (places[place] != none) place_of_domain_[places[place]] = slot;
    }
    for (const auto& [own, other] : further) {
      to_.further.emplace_back(simd::quad_of(own, lanes_), simd::quad_of(other, lanes_));
    }
  }

  /// Whether runs are worth it.
  bool pack_runs() {
    constexpr std::int32_t trial = 1024;  // slots, after each of which a body that is no lattice may be given up
    RunPacker packer(lanes_, to_.runs);
    std::vector<simd::RunLink> links;
    for (std::int32_t place = 0; place < to_.slots; ++place) {
      if (place % trial == trial - 1 && !packer.worthwhile()) return false;
      const Index d = domain_of_quad_[simd::quad_of(place, lanes_)];
      links.clear();
      if (d != none) {
        find_links(t_, d, all_);
        for (const Link& link : all_) {
          const LinkRow there = row_of(link.there, link.stiffness), back = row_of(-link.back, 0.0);
          links.push_back({{there[0], there[1], there[2]},
                           there[3],
                           {back[0], back[1], back[2]},
                           place_of_domain_[link.domain] - place});
        }
      }
      packer.add(links);
    }
    packer.finish();
    return packer.worthwhile();
  }

  void add_links(Index d) {
    find_even_links(t_, d, all_);
    stress_.clear();
    force_.clear();
    for (const Link& link : all_) {
      to_.link.push_back(16 * simd::quad_of(place_of_domain_[link.domain], lanes_));
      stress_.push_back(row_of(link.there, link.stiffness));
      force_.push_back(row_of(-link.back, link.stiffness));
    }
    to_.stress_row.push_back(first_row_of(stress_));
    to_.force_row.push_back(first_row_of(force_));
  }

  std::int32_t first_row_of(const std::vector<LinkRow>& rows) {
    if (rows.empty()) return 0;
    const std::string_view bytes(reinterpret_cast<const char*>(rows.data()), rows.size() * sizeof(LinkRow));
    const auto next = static_cast<std::int32_t>(to_.links.size() / 4);
    const auto [known, is_new] = rows_.try_emplace(std::hash<std::string_view>()(bytes), next);
    const std::int32_t first = known->second;
    if (!is_new && next - first >= static_cast<std::int32_t>(rows.size()) &&
        std::memcmp(&to_.links[4 * static_cast<std::size_t>(first)], bytes.data(), bytes.size()) == 0) {
      return first;
    }
    for (const LinkRow& row : rows) to_.links.insert(to_.links.end(), row.begin(), row.end());
    return next;
  }

  void add_constants() {
    to_.constants.assign((2 + kind_of(t_.options.strain_energy).constants) * static_cast<std::size_t>(to_.slots), 0.0f);
    for (std::int32_t place = 0; place < to_.slots; ++place) {
      const Index d = domain_of_quad_[simd::quad_of(place, lanes_)];
      if (d != none) put_constants(t_, d, place, to_);
    }
  }

  const TopologyTextures& t_;
  const std::vector<Index>& order_;
  const std::int32_t places_;
  const int lanes_;
  PackedAverages& to_;
  std::vector<std::int32_t> place_of_domain_;
  std::vector<Index> domain_of_quad_;
  std::vector<Link> all_;                               // of the domain at hand
  std::vector<LinkRow> stress_, force_;                 // its rows
  std::unordered_map<std::size_t, std::int32_t> rows_;  // by hash: the first row of the links that came first with it
};

}  // namespace

simd::Averaged PackedAverages::job(char* u, char* stress, char* force) const {
  return {.u = u,
          .stress = stress,
          .force = force,
          .constants = constants.data(),
          .link_range = link_range.data(),
          .link = link.data(),
          .stress_row = stress_row.data(),
          .force_row = force_row.data(),
          .links = links.data(),
          .runs = runs.job(reinterpret_cast<float*>(stress)),
          .plane = plane,
          .far = bytes() > own_caches};
}

void PackedAverages::copy_displacements(char* u) const {
  for (const auto& [own, other] : further) {
    std::memcpy(u + 16 * std::ptrdiff_t{other}, u + 16 * std::ptrdiff_t{own}, 16);
  }
}

void PackedAverages::gather_forces(char* force) const {
  gather_forces(force, 0, static_cast<int>(further.size()));
}

void PackedAverages::gather_forces(char* force, int first, int last) const {
  for (int k = first; k < last; ++k) {
    const auto& [own, other] = further[static_cast<std::size_t>(k)];
    float sum[4], part[4];
    std::memcpy(sum, force + 16 * std::ptrdiff_t{own}, sizeof sum);
    std::memcpy(part, force + 16 * std::ptrdiff_t{other}, sizeof part);
    for (int a = 0; a < 3; ++a) sum[a] += part[a];
    std::memcpy(force + 16 * std::ptrdiff_t{own}, sum, sizeof sum);
  }
}

std::size_t PackedAverages::stress_floats() const {
  return runs.empty() ? 16 * static_cast<std::size_t>(slots) : runs.component_floats();
}

double PackedAverages::cost() const {
  return 10.0 * slots + (runs.empty() ? 2.0 * static_cast<double>(link.size()) : 4.0 * runs.run_links);
}

double PackedAverages::bytes() const {
  const double passes = 2.0;
  const auto words = static_cast<double>(link_range.size() + link.size() + stress_row.size() + links.size());
  const double force = 16.0;  // it and stresses or components are both written and read
  return 4.0 * (passes * words + static_cast<double>(constants.size()) + 2.0 * static_cast<double>(stress_floats())) +
         2.0 * slots * force;
}

std::vector<int> PackedAverages::shared_out(int parts) const {
  std::vector<int> first{0};
  const auto work = [&](int slice) {
    const std::size_t slot = static_cast<std::size_t>(slice) * lanes;
    if (slice == slices())
      return runs.empty() ? static_cast<double>(link.size()) + 5.0 * static_cast<double>(slot) : slice;
    return runs.empty() ? static_cast<double>(link_range[2 * slot]) + 5.0 * static_cast<double>(slot) : slice;
  };
  for (int slice = 0; slice < slices(); ++slice) {
    while (static_cast<int>(first.size()) < parts &&
           work(slice) >= work(slices()) * static_cast<double>(first.size()) / parts) {
      first.push_back(slice);
    }
  }
  first.resize(static_cast<std::size_t>(parts) + 1, slices());
  return first;
}

void PackedAverages::edit(const TopologyTextures& topology, std::span<const Index> domains) {
  // Lengths change before what relies on them: memory may run out.
  if (rooms.empty()) {
    place_of_domain.assign(topology.domains.size(), -1);
    for (std::int32_t place = 0; place < slots; ++place) {
      if (domain_of_place[place] != none) place_of_domain[domain_of_place[place]] = place;
    }
    rooms.resize(static_cast<std::size_t>(slots));
    for (std::size_t q = 0; q < rooms.size(); ++q) rooms[q].offsets = link_range[2 * q + 1] - link_range[2 * q];
  }
  std::vector<Link> all;
  for (const Index d : domains) {
    put_constants(topology, d, place_of_domain[d], *this);
    const auto q = static_cast<std::size_t>(simd::quad_of(place_of_domain[d], lanes));
    find_even_links(topology, d, all);
    const auto count = static_cast<std::int32_t>(all.size());
    Room& room = rooms[q];
    if (count > room.offsets) {
      link.resize(link.size() + all.size(), 0);
      link_range[2 * q] = static_cast<std::int32_t>(link.size()) - simd::links_ahead - count;
      room.offsets = count;
    }
    if (count > room.rows) {
      const std::int32_t first = static_cast<std::int32_t>(links.size() / 4), rows = std::max(count, room.offsets);
      links.resize(links.size() + 8 * static_cast<std::size_t>(rows), 0.0f);
      room.first = first;
      room.rows = rows;
    }
    const std::int32_t begin = link_range[2 * q];
    link_range[2 * q + 1] = begin + count;
    stress_row[q] = room.first;
    force_row[q] = room.first + room.rows;
    for (std::int32_t k = 0; k < count; ++k) {
      const Link& own = all[static_cast<std::size_t>(k)];
      link[static_cast<std::size_t>(begin + k)] = 16 * simd::quad_of(place_of_domain[own.domain], lanes);
      const LinkRow there = row_of(own.there, own.stiffness), back = row_of(-own.back, own.stiffness);
      std::ranges::copy(there, links.begin() + 4 * std::ptrdiff_t{room.first + k});
      std::ranges::copy(back, links.begin() + 4 * std::ptrdiff_t{room.first + room.rows + k});
    }
  }
}

PackedAverages pack_averages(const TopologyTextures& topology, const std::vector<Index>& order, std::int32_t places,
                             int lanes, AveragedLinks links) {
  PackedAverages packed;
  if (!AveragesPacker(topology, order, places, lanes, packed).pack(links)) packed = {};
  return packed;
}

}  // namespace phymul::cpu
