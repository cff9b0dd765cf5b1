// SPDX-License-Identifier: MIT
#include "packed_body.h"

#include <phymul/error.h>

#include <algorithm>
#include <limits>
#include <numeric>
#include <string>
#include <thread>

#include "device/float_range.h"
#include "packed_rows.h"
#include "term_packer.h"
#include "topology/locality_order.h"

namespace phymul::cpu {
namespace {

/// Particles of a cluster: few enough that its displacements and forces stay in a core's first cache, many enough that
/// most of a cluster's terms touch its own particles alone.
constexpr Index cluster_size = 512;
/// A body of fewer particles and less work than these stays in one piece: it is not worth a second thread.
constexpr Index whole_size = 2048;
constexpr double whole_cost = 40e3;  // ns

/// Particles of Law::particle_averaged that are put in order of their links together.
constexpr Index averaged_window = 256;

/// Work of a step worth a thread. Handing two passes over and back costs a step about 0.5 us, so that two threads with
/// this much each gain most of what they can.
constexpr double least_cost_a_thread = 10e3;  // ns

void put_mass(double m, std::size_t place, PackedBody& to) {
  to.mass[place] = narrow(m);
  to.inverse_mass[place] = m > 0.0 ? narrow(1.0 / m) : 0.0f;
}

class BodyPacker {
 public:
  BodyPacker(const TopologyTextures& t, Index size, PackedBody& body) : t_(t), size_(size), body_(body) {}

  /// A body of Law::particle_averaged: no clusters, and its forces stand as its particles do. Whether it was worth it.
  bool pack_averaged(AveragedLinks links) {
    body_.places = (t_.particle_count + body_.lanes - 1) / body_.lanes * body_.lanes;
    body_.averages = pack_averages(t_, body_.order, body_.places, body_.lanes, links);
    if (!body_.averaged()) return false;
    body_.force_rows = body_.averages.slots;
    for (std::int32_t s = 0; s < body_.slices(); ++s) body_.own.push_back(16 * s * body_.lanes);
    pack_masses(body_.order);
    return true;
  }

  void pack() {
    pack_clusters();
    pack_particles();
    pack_halo();
    if (body_.gives()) pack_gifts();
    if (!body_.pushes()) {
      body_.force_rows = 0;
      for (Offsets* rows : {&body_.own, &body_.halo_first, &body_.halo}) *rows = {};
    }
  }

  /// The walls of a body that pack_averaged() has packed. Their clusters' forces stand behind its own.
  void pack_walls() {
    body_.force_rows = (body_.force_rows + 3) / 4 * 4;
    pack_clusters();
    std::erase_if(body_.clusters, [](const Cluster& cluster) { return cluster.job.walls.count == 0; });
    std::vector<char> in_wall(static_cast<std::size_t>(body_.places), 0);
    for (const WallTexel& wall : t_.walls) {
      for (const Index i : wall.vertex) {
        if (i != none) in_wall[i] = 1;
      }
    }
    for (const Cluster& cluster : body_.clusters) {
      for (std::int32_t place = cluster.first; place < cluster.first + cluster.own; ++place) {
        if (in_wall[place] == 0) continue;
        const auto quad = static_cast<std::int32_t>(body_.quad_of(static_cast<std::size_t>(place)));
        body_.wall_sums.push_back({quad, static_cast<std::int32_t>(cluster.force_first) + quad - cluster.first});
      }
      for (std::size_t k = 0; k < cluster.halo.size(); ++k) {
        body_.wall_sums.push_back(
            {cluster.halo[k], static_cast<std::int32_t>(cluster.force_first + cluster.own + static_cast<Index>(k))});
      }
    }
    std::ranges::sort(body_.wall_sums);
  }

 private:
  void pack_clusters() {
    const auto count = static_cast<std::size_t>((t_.particle_count + size_ - 1) / size_);
    body_.clusters.resize(count);
    TermPacker terms(t_, size_, count, body_);
    for (std::size_t c = 0; c < count; ++c) {
      Cluster& cluster = body_.clusters[c];
      cluster.first = static_cast<std::int32_t>(c) * size_;
      const Index own = std::min(size_, t_.particle_count - cluster.first);
      cluster.own = (own + body_.lanes - 1) / body_.lanes * body_.lanes;
      cluster.force_first = body_.force_rows;
      terms.pack(static_cast<int>(c));
      body_.force_rows += (cluster.slots() + 3) / 4 * 4;  // whole lines of the cache: slices do not cross them
    }
    terms.point_jobs();
  }

  void pack_particles() {
    body_.places = body_.clusters.empty() ? 0 : body_.clusters.back().first + body_.clusters.back().own;
    std::vector<Index> order(static_cast<std::size_t>(t_.particle_count));
    std::iota(order.begin(), order.end(), 0);
    pack_masses(order);
    body_.stiffness.assign(static_cast<std::size_t>(body_.places), 0.0f);
    for (std::size_t i = 0; i < t_.stiffness.size(); ++i) body_.stiffness[i] = narrow(t_.stiffness[i]);
    for (Cluster& cluster : body_.clusters) cluster.job.stiffness = body_.stiffness.data() + cluster.first;
  }

  /// `order`: row of t_ at each place.
  void pack_masses(const std::vector<Index>& order) {
    body_.mass.assign(static_cast<std::size_t>(body_.places), 0.0f);
    body_.inverse_mass = body_.mass;
    for (std::size_t place = 0; place < order.size(); ++place) put_mass(t_.mass[order[place]], place, body_);
  }

  /// Who else has forces for the particles of a slice, in the order of the clusters.
  void pack_halo() {
    std::vector<std::vector<std::int64_t>> rows_of(static_cast<std::size_t>(body_.places));  // by quad
    for (const Cluster& cluster : body_.clusters) {
      for (std::size_t k = 0; k < cluster.halo.size(); ++k) {
        if (!cluster.pushed[k]) continue;
        rows_of[cluster.halo[k]].push_back(cluster.force_first + cluster.own + static_cast<std::int64_t>(k));
      }
    }
    const std::int64_t zero = body_.force_rows++;
    if (body_.force_rows * 16 > std::numeric_limits<std::int32_t>::max()) {
      throw Error("the body has " + std::to_string(t_.particle_count) +
                  " particles, too many for 32-bit offsets; the backend \"reference\" has no such limit");
    }
    body_.halo_first.push_back(0);
    for (int s = 0; s < body_.slices(); ++s) {
      const Cluster& cluster = body_.clusters[s * body_.lanes / size_];
      body_.own.push_back(static_cast<std::int32_t>(16 * (cluster.force_first + s * body_.lanes - cluster.first)));
      std::size_t longest = 0;
      for (int lane = 0; lane < body_.lanes; ++lane)
        longest = std::max(longest, rows_of[body_.quad_of(s * body_.lanes + lane)].size());
      for (std::size_t k = 0; k < longest; ++k) {
        for (int lane = 0; lane < body_.lanes; ++lane) {
          const auto& rows = rows_of[body_.quad_of(s * body_.lanes + lane)];
          body_.halo.push_back(static_cast<std::int32_t>(16 * (k < rows.size() ? rows[k] : zero)));
        }
      }
      body_.halo_first.push_back(body_.halo_first.back() + static_cast<std::int32_t>(longest));
    }
  }

  double share_of(Index row) const {
    switch (t_.options.reaction) {
      case Reaction::full:
        return 1.0;
      case Reaction::shared:
        return 1.0 / t_.index[t_.neighbour_owner[row]].neighbour_count;
      default:
        return t_.alpha[row];
    }
  }

  /// Whose pulls a particle bears, and what share of each.
  void pack_gifts() {
    LaneRows rows(body_.give, 2, body_.lanes);
    body_.give_first.push_back(0);
    for (int s = 0; s < body_.slices(); ++s) {
      const Index first = s * body_.lanes, last = std::min<Index>(first + body_.lanes, t_.particle_count);
      Index longest = 0;
      for (Index i = first; i < last; ++i) longest = std::max(longest, t_.neighbour_of.size(i));
      rows.add(longest, 1);
      for (Index i = first; i < last; ++i) {
        Index row = 0;
        for (const Index* r = t_.neighbour_of.begin(i); r != t_.neighbour_of.end(i); ++r, ++row) {
          if (t_.index[t_.neighbour_owner[*r]].base_count == 0) continue;
          rows.offset(row, 0, i - first, 16 * simd::quad_of(t_.neighbour_owner[*r], body_.lanes));
          rows.put(row, 1, i - first, share_of(*r));
        }
      }
      body_.give_first.push_back(body_.give_first.back() + longest);
    }
    fill_idle(body_.give, 0, 2, 1, body_.lanes, 16 * body_.places);
  }

  const TopologyTextures& t_;
  const Index size_;
  PackedBody& body_;
};

/// Links of each particle. Loops of equal length side by side are foreseen by a processor, others cost it a wrong
/// guess.
std::vector<Index> links_of(const TopologyTextures& t) {
  std::vector<Index> links(static_cast<std::size_t>(t.particle_count), 0);
  for (Index i = 0; i < t.particle_count; ++i) {
    for (Index d = t.first_domain[i]; d < t.first_domain[i + 1]; ++d) links[i] += t.domains[d].link_count;
  }
  return links;
}

/// Whether domains are alike, as in a lattice: by a sample of their volumes, because most bodies need no closer look.
bool domains_recur(const TopologyTextures& t) {
  const std::size_t count = std::min<std::size_t>(t.domains.size(), 256);
  std::vector<float> volumes;
  for (std::size_t k = 0; k < count; ++k) {
    volumes.push_back(narrow(t.domains[t.domains.size() * k / count].inverse_volume));
  }
  std::ranges::sort(volumes);
  const auto repeated = std::ranges::unique(volumes);
  return 2 * repeated.size() >= count;
}

/// Of a body of Law::particle_averaged: what of it are walls.
void add_walls(const TopologyTextures& topology, PackedBody& body) {
  if (topology.walls.empty()) return;
  TopologyTextures walls = renumbered(topology, body.order);
  BodyPacker(walls, cluster_size, body).pack_walls();
}

double rough_cost(const TopologyTextures& t, int lanes) {
  const double base = t.options.reaction == Reaction::averaged ? 80.0 : 50.0;
  return (base * t.base_count + 16.0 * static_cast<double>(t.springs.size()) +
          40.0 * static_cast<double>(t.volumes.size()) + 180.0 * static_cast<double>(t.walls.size())) /
         lanes;
}

// What a step of the vector backend moves between memory and a core, for bodies that outgrow the caches. A cluster's
// copy of its displacements stays in the first cache and is not counted; a written line counts once, as its line is
// read (or claimed) before.

constexpr double quad_bytes = 16.0, triple_bytes = 12.0, word_bytes = 4.0;

double constants(const PackedBody& b) {
  double words = 0.0;
  for (const Floats* table :
       {&b.bases, &b.enumerated, &b.springs, &b.volumes, &b.walls, &b.give, &b.inverse_mass, &b.mass}) {
    words += static_cast<double>(table->size());
  }
  for (const Offsets* table : {&b.base_first, &b.spring_first, &b.enumerated_first, &b.enumerated_neighbours,
                               &b.enumerated_offsets, &b.own, &b.halo_first, &b.halo, &b.give_first}) {
    words += static_cast<double>(table->size());
  }
  const bool attracts = !(b.bases.empty() && b.enumerated.empty()) && b.use != simd::BaseUse::conservative;
  if (attracts) words += static_cast<double>(b.stiffness.size());
  return word_bytes * words;
}

}  // namespace

double PackedBody::cost() const {
  double sum = averages.cost();
  for (const Cluster& cluster : clusters) sum += cluster.cost;
  return sum;
}

int PackedBody::threads_for(int asked, const TaskRunner* host) const {
  const std::size_t pieces = averaged() ? static_cast<std::size_t>(averages.slices()) : clusters.size();
  int most = static_cast<int>(std::clamp<std::size_t>(pieces, 1, 1024));
  if (host) most = std::min(most, host->width());
  if (asked > 0) return std::min(asked, most);
  const int processors = host ? most : static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  const int worth = static_cast<int>(std::clamp(cost() / least_cost_a_thread, 1.0, 1024.0));
  return std::min({processors, most, worth});
}

std::size_t PackedBody::most_slots() const {
  std::int32_t most = 0;
  for (const Cluster& cluster : clusters) most = std::max(most, cluster.slots());
  return static_cast<std::size_t>(most);
}

bool PackedBody::edit(const TopologyTextures& topology, std::span<const Index> domains) {
  if (!averaged()) {
    PackedBody now;
    now.lanes = lanes;
    now.order = order;
    const Index size = clusters.size() == 1 ? std::max<Index>(topology.particle_count, 1) : cluster_size;
    BodyPacker(renumbered(topology, order), size, now).pack();
    *this = std::move(now);
    return false;
  }
  const bool anew = !averages.runs.empty();
  PackedAverages by_slot;
  if (anew) by_slot = pack_averages(topology, order, places, lanes, AveragedLinks::by_slot);
  (anew ? by_slot : averages).edit(topology, domains);
  if (anew) averages = std::move(by_slot);
  for (const Index d : domains) {
    const Index i = topology.domains[d].particle;
    put_mass(topology.mass[i], static_cast<std::size_t>(averages.place_of_domain[topology.first_domain[i]]), *this);
  }
  if (topology.walls.empty()) return anew;
  for (std::size_t place = 0; place < order.size(); ++place) put_mass(topology.mass[order[place]], place, *this);
  clusters.clear();
  walls.clear();
  wall_sums.clear();
  base_first.clear();
  spring_first.clear();
  force_rows = averages.slots;
  add_walls(topology, *this);
  return anew;
}

std::unique_ptr<PackedBody> make_packed_body(const TopologyTextures& topology, int lanes) {
  require_bases_in_range(topology);
  auto body = std::make_unique<PackedBody>();
  body->lanes = lanes;
  body->bounded = topology.options.volume_law == VolumeLaw::bounded;
  if (!topology.domains.empty()) {
    BodyPacker packer(topology, 0, *body);
    if (domains_recur(topology)) body->order = line_order(topology.rest);
    if (!body->order.empty() && packer.pack_averaged(AveragedLinks::runs)) {
      add_walls(topology, *body);
      return body;
    }
    body->order = locality_order(topology.rest, links_of(topology), averaged_window);
    packer.pack_averaged(AveragedLinks::by_slot);
    add_walls(topology, *body);
    return body;
  }
  const bool whole = topology.particle_count <= whole_size && rough_cost(topology, lanes) <= whole_cost;
  const Index all = std::max<Index>(topology.particle_count, 1);
  const Index size = whole ? all : cluster_size;
  body->order = locality_order(topology.rest, TermPacker::work_of(topology), size);
  body->plane = topology.dimension == 2;
  body->use = topology.options.reaction == Reaction::conservative ? simd::BaseUse::conservative
              : topology.options.reaction == Reaction::averaged   ? simd::BaseUse::averaged
                                                                  : simd::BaseUse::attractor;
  const TopologyTextures ordered = renumbered(topology, body->order);
  BodyPacker(ordered, size, *body).pack();
  return body;
}

double PackedBody::bytes_a_step() const {
  double halo_slots = 0.0;
  for (const Cluster& cluster : clusters) halo_slots += static_cast<double>(cluster.halo.size());
  const double state = places * (2.0 * quad_bytes + 2.0 * triple_bytes);                 // u and v, read and written
  const double gathered = places * quad_bytes + halo_slots * (quad_bytes + word_bytes);  // u, with that of others
  const double forces = static_cast<double>(force_rows) * 2.0 * quad_bytes;  // written by clusters, read by the move
  const double pulls = gives() ? places * 2.0 * quad_bytes : 0.0;            // likewise
  return constants(*this) + state + gathered + forces + pulls + averages.bytes();
}

}  // namespace phymul::cpu
