// SPDX-License-Identifier: MIT
//
// A step between its forces and its motion: where what touches a body (tools, other bodies) acts. It sees where each
// particle would go by itself and adds impulses to that; whatever integrates then moves, measures and imposes as
// always. So resting in contact is rest, and a step without contacts has nothing of this.
#pragma once

#include <phymul/types.h>

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

namespace phymul {

/// Where a step looks for particles: a box, and in it the places with normal . x <= offset (all of them where the
/// normal is zero and the offset is not negative).
struct Region {
  Vec3 low{0, 0, 0}, high{0, 0, 0};  // m
  Vec3 normal{0, 0, 0};
  double offset = 0.0;

  /// Whether the straight way from a to b may meet it.
  bool meets(const Vec3& a, const Vec3& b) const {
    return (a.cwiseMin(b).array() <= high.array()).all() && (a.cwiseMax(b).array() >= low.array()).all() &&
           std::min(normal.dot(a), normal.dot(b)) <= offset;
  }
};

/// What a backend gives of a step. Rows are the model's.
class PredictedStep {
 public:
  virtual ~PredictedStep() = default;
  virtual Vec3 position(Index i) const = 0;  ///< m, at the step's start
  /// m/s: v* = d v + dt (F / m + g), with which the particle would go to x* = x + dt v*.
  virtual Vec3 predicted_velocity(Index i) const = 0;
  /// N: the elastic force that SolverOptions::max_displacement_per_step withholds in this step. v* lacks it.
  virtual Vec3 withheld(Index i) const = 0;
  /// Positions and predicted velocities of many: [rows].
  virtual void fetch(std::span<const Index> rows, VecList& position, VecList& velocity) const;
  /// m: between two steps no particle has gone farther than this has grown. Infinite: not known.
  virtual double gone() const { return HUGE_VAL; }
  /// m: no way from x to x* is longer. Likewise.
  virtual double going() const { return HUGE_VAL; }
  /// Appends, in an order that no number of threads changes, the particles whose way from x to x* may meet the region.
  virtual void find(const Region& region, std::vector<Index>& found) const = 0;
  virtual void add_force(Index i, const Vec3& force) = 0;  ///< N, over this step; at most once a particle
  virtual void shift(Index i, const Vec3& by) = 0;         ///< m, besides, which is no velocity; likewise

 protected:
  PredictedStep() = default;
  PredictedStep(const PredictedStep&) = default;
  PredictedStep& operator=(const PredictedStep&) = default;
};

double longest_of_ways(const VecList& from, const VecList& to);  ///< m, of particles

/// Bit a of `fixed`: coordinate a takes nothing.
inline Vec3 free_part(Vec3 vector, std::uint8_t fixed) {
  for (int a = 0; a < 3; ++a) {
    if (fixed >> a & 1) vector[a] = 0.0;
  }
  return vector;
}

/// The particles of a step that something touches: copies in double precision whose velocities take impulses one after
/// the other; the backend gets each sum once. Between begin() and end(); only prepare() allocates.
class TouchedParticles {
 public:
  struct Touched {
    Index particle = -1;
    double inverse_mass = 0.0;  // 1/kg
    std::uint8_t fixed = 0;     // bit a: coordinate a is imposed and takes no impulse
    Vec3 position{0, 0, 0};     // m, at the step's start
    Vec3 velocity{0, 0, 0};     // m/s, with the impulses so far
    Vec3 impulse{0, 0, 0};      // N s, sum of them
    Vec3 shift{0, 0, 0};        // m
    Vec3 withheld{0, 0, 0};     // N, of the elastic force, that no tool has borne so far
    bool held = false;          // by a tool: nothing else pushes it
    Vec3 handed_on{0, 0, 0};    // N s, to the tool that holds it: of pull()
    Vec3 rubbed{0, 0, 0};       // normal of a tool with ToolContact::surface that presses it, times its friction
    Vec3 end(double dt) const { return position + dt * velocity; }
    Vec3 free_part(const Vec3& vector) const { return phymul::free_part(vector, fixed); }
  };

  /// `fixed`: LoadFrame::fixed, or empty; `plane`: nothing moves along z.
  void prepare(std::span<const double> mass, std::span<const std::uint8_t> fixed, bool plane);
  /// `last_dt`: s, of the step before; 0: there was none.
  void begin(PredictedStep& step, double dt, double last_dt);
  void end();  ///< hands the sums to the backend

  double dt() const { return dt_; }
  double last_dt() const { return last_dt_; }
  /// Whether the step is a remainder, as at the end of a loop of calls: so short that an impulse which puts right what
  /// single precision rounds would be a blow.
  bool is_remainder() const { return dt_ < 1e-3 * last_dt_; }
  const PredictedStep& step() const { return *step_; }
  std::span<const double> mass() const { return mass_; }  ///< kg, of all particles
  std::size_t count() const { return touched_.size(); }
  Touched& operator[](std::size_t slot) { return touched_[slot]; }
  /// m/s, with the impulses so far.
  Vec3 velocity(Index particle) const {
    const Index slot = slot_of_[particle];
    return slot < 0 ? step_->predicted_velocity(particle) : touched_[slot].velocity;
  }
  void fetch(std::span<const Index> rows, VecList& position, VecList& velocity) const;  ///< likewise, of many
  /// m: no particle's way in this step is longer, with the impulses and shifts so far.
  double going() const;
  /// m, at the step's start, with the shifts so far: what they move does not go.
  Vec3 start(Index particle) const {
    const Index slot = slot_of_[particle];
    return slot < 0 ? step_->position(particle) : Vec3(touched_[slot].position + touched_[slot].shift);
  }
  /// m, at the step's end, with the impulses and shifts so far.
  Vec3 end(Index particle) const {
    const Index slot = slot_of_[particle];
    if (slot < 0) return step_->position(particle) + dt_ * step_->predicted_velocity(particle);
    return touched_[slot].end(dt_) + touched_[slot].shift;
  }
  std::size_t slot(Index particle);  ///< fetched at the first call in a step; references before it are no longer good
  /// Null where it has no copy.
  Touched* find(Index particle) { return slot_of_[particle] < 0 ? nullptr : &touched_[slot_of_[particle]]; }
  double inverse_mass(Index particle) const { return mass_[particle] > 0.0 ? 1.0 / mass_[particle] : 0.0; }
  std::uint8_t fixed(Index particle) const {
    return static_cast<std::uint8_t>((fixed_.empty() ? 0 : fixed_[particle]) | (plane_ ? 4 : 0));
  }
  /// An impulse along free coordinates, on a particle without a copy, which nothing asks for or pushes later in this
  /// step.
  void push_last(Index particle, const Vec3& impulse) { step_->add_force(particle, impulse / dt_); }

  /// Adds what of an impulse the free coordinates take, and returns that. Here, because needles and contacts call it
  /// thousands of times a step.
  static Vec3 push(Touched& touched, const Vec3& impulse) {
    const Vec3 taken = touched.free_part(impulse);
    touched.impulse += taken;
    touched.velocity += touched.inverse_mass * taken;
    return taken;
  }

  /// Likewise; of a particle that a tool holds this is the tool's: ToolSet::feel().
  static void pull(Touched& touched, const Vec3& impulse) {
    if (touched.held) {
      touched.handed_on += touched.free_part(impulse);
    } else {
      push(touched, impulse);
    }
  }

  /// N: what of the withheld force is against an impulse. The tool that gives this impulse bears it too, because
  /// without the limit both would be larger by as much and the particle would go the same way.
  static Vec3 borne(Touched& touched, const Vec3& impulse) {
    const double squared = impulse.squaredNorm();
    if (!(squared > 0.0)) return Vec3::Zero();
    const Vec3 force = std::max(0.0, -touched.withheld.dot(impulse)) / squared * impulse;
    touched.withheld += force;
    return force;
  }

 private:
  std::span<const double> mass_;
  std::span<const std::uint8_t> fixed_;
  bool plane_ = false;
  PredictedStep* step_ = nullptr;
  double dt_ = 0.0, last_dt_ = 0.0;
  std::vector<Index> slot_of_;  // [N], -1: not fetched in this step
  std::vector<Touched> touched_;
};

}  // namespace phymul
