// SPDX-License-Identifier: MIT
//
// Scene::contacts, in double precision and in one order whatever the backend and its threads. Every particle of a
// surface meets the nearest triangle of every other body (and of its own, far enough away at rest): an impulse along
// the way between the particle and the nearest point of the triangle lets them come no nearer than their skins by the
// step's end, and one across it of at most `friction` times that acts against their sliding. The triangle's corners
// take the opposite of what the particle takes, by their share in the point: so momentum is kept, and angular momentum
// but for what friction does over the thickness of the skins. Bodies of volume cells have an inside: what got in is
// pushed out. Overlaps (of a start, or of what pushed harder than the rounds could hold) go back little by little,
// without speed.
#pragma once

#include <phymul/scene.h>

#include <array>
#include <optional>
#include <span>

#include "contact_candidates.h"
#include "contact_surface.h"
#include "predicted_step.h"

namespace phymul {

class BodyContacts {
 public:
  BodyContacts() = default;
  BodyContacts(const BodyContacts&) = delete;  // its candidates point to its surface
  BodyContacts& operator=(const BodyContacts&) = delete;

  void follow(const Scene& scene, FollowedSurface& surface);  ///< allocates
  bool empty() const { return !surface_ || surface_->particles.empty(); }
  void forget() { gone_ = NAN; }  ///< positions were set, not stepped

  void act(TouchedParticles& touched);
  /// Nothing to do in a step in which no particle goes farther than `going`, m. `gone`: PredictedStep::gone(), m.
  bool none_near(double going, double gone) const;

 private:
  struct Contact {
    std::size_t particle = 0, triangle = 0;  // of the surface
    Vec3 share{0, 0, 0};                     // of the corners in the nearest point, sum 1
    std::size_t first = 0, end = 0;          // of its shares_
    Vec3 normal{0, 0, 0};                    // away from the triangle
    double gap = 0.0;                        // m, at the step's start; negative: overlap
    double edge = 0.0;                       // m, of the triangle, about
    double mobility = 0.0;                   // 1/kg, along the normal
    double pressed = 0.0;                    // N s, so far
    Vec3 rubbed{0, 0, 0};                    // N s, so far, across the normal
  };
  /// The weight of a touched particle in a contact's relative velocity: its share in the point, less its share in the
  /// nearest point of the triangle.
  struct Share {
    std::size_t slot = 0;
    double weight = 0.0;
  };
  struct Nearest {
    std::size_t particle = 0, triangle = 0;
    double distance = 0.0, rank = 0.0;  // m; of those of a body the one of least rank is met
    Vec3 share{0, 0, 0}, way{0, 0, 0};  // from the triangle to the particle, m
    bool inside = false;
  };

  void find_rows(const ContactSurface& surface);
  void fetch(const TouchedParticles& touched);
  void find(TouchedParticles& touched);
  void share_out(Contact& contact, TouchedParticles& touched);
  std::span<const Share> shares(const Contact& contact) const {
    return std::span(shares_).subspan(contact.first, contact.end - contact.first);
  }
  std::optional<Nearest> nearest(const ContactCandidates::List& list) const;
  std::optional<Nearest> look(std::size_t particle, std::size_t triangle) const;
  double apart(const ContactCandidates::List& list, const std::optional<Nearest>& found, double margin) const;
  double in_front(std::size_t particle, std::size_t triangle) const;
  bool is_before_corner(const ContactCandidates::List& list, const Nearest& found) const;
  void keep(const Nearest& found, double margin);
  void press(Contact& contact, TouchedParticles& touched) const;
  void part(const Contact& contact, TouchedParticles& touched) const;

  ContactOptions options_;
  std::shared_ptr<const ContactSurface> surface_;  // candidates_ point to it; null: no contacts
  ContactCandidates candidates_;
  double gone_ = NAN;        // m, PredictedStep::gone() at the last find()
  std::vector<Index> rows_;  // of the model: the surface's particles; where a cut is, what its points are means of
  std::vector<std::array<Index, 4>> means_;  // [particles of the surface] rows of rows_, then -1; empty without cuts
  VecList row_place_, row_velocity_;         // [rows_] m, m/s, of means
  VecList place_, velocity_;                 // [particles of the surface] m, m/s
  std::vector<Contact> contacts_;
  std::vector<Share> shares_;
};

}  // namespace phymul
