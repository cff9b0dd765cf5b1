// SPDX-License-Identifier: MIT
//
// Scene::contacts, in double precision and in one order whatever the backend and its threads. Every particle of a
// surface is a ball; two balls take an impulse along the line between them that lets them come no nearer than touching
// by the step's end, and one across it of at most `friction` times that, against their sliding. Impulses are equal and
// opposite. Balls nearer at rest than twice their radii together, in one body, are its own skin and do not touch.
// Overlaps (of a start, or of what pushed harder than the rounds could hold) go back a fifth a step, without speed.
#pragma once

#include <phymul/scene.h>

#include <cstdint>

#include "../free_step.h"
#include "ball_grid.h"

namespace phymul::cpu {

class BodyContacts {
 public:
  void follow(const Scene& scene);  ///< allocates
  bool empty() const { return balls_.empty(); }

  void act(TouchedParticles& touched);
  /// Pairs looked at in the last step.
  std::size_t pairs() const { return pairs_.size(); }

 private:
  struct Ball {
    Index particle = -1, body = -1;
    double radius = 0.0;  // m
  };
  struct Pair {
    std::size_t a = 0, b = 0;  // slots of the touched particles
    Vec3 normal{0, 0, 0};      // from b to a
    double gap = 0.0;          // m, at the step's start; negative: overlap
    double reach = 0.0;        // m, sum of radii
    double pressed = 0.0;      // N s, so far
    Vec3 rubbed{0, 0, 0};      // N s, so far, across the normal
  };
  bool skin(const Ball& a, const Ball& b) const;
  void find_pairs(TouchedParticles& touched);
  void press(Pair& pair, TouchedParticles& touched) const;
  void part(const Pair& pair, TouchedParticles& touched) const;

  ContactOptions options_;
  std::vector<Ball> balls_;
  const VecList* rest_ = nullptr;
  double largest_radius_ = 0.0;
  VecList place_, velocity_;  // [balls]
  BallGrid grid_;
  std::vector<Pair> pairs_;
};

}  // namespace phymul::cpu
