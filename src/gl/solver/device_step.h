// SPDX-License-Identifier: MIT
//
// DeviceStep: an open step of a device, as tools, contacts and kept volumes on the host see it. Particles that are
// asked for are gathered from the device, those of the step before in advance: so a step usually takes one gather, and
// only of what is within reach. Which particles may be is told from where each was when it was last seen, and from how
// far any can have gone since.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "device.h"
#include "interaction/predicted_step.h"

namespace phymul::gl {

class DeviceStep final : public PredictedStep {
 public:
  explicit DeviceStep(const Model& model);  ///< which must outlive it

  void follow_body(const Model& model);  ///< its cells were cut, removed or brought back
  /// Places are not those of the last step's end: all are read when they are next asked for.
  void forget() { read_at_ = -1.0; }
  /// Before a step or several: places are known well enough to say what is out of reach, or read.
  void look(Device& device);
  /// Whether a particle may come into the region before gone() has grown by `more`, m. After look().
  bool any_in(const Region& region, double more) const;
  /// m: no point of a surface's triangle is farther from all its corners until then. After look().
  double wide(double more) const;
  /// Opens the step of a batch begun on the device. `largest_displacement`: m, of the state.
  void begin(Device& device, double dt, double largest_displacement);
  void close();                     ///< with what has been added
  void drop() { pushes_.clear(); }  ///< instead: the step is not done
  /// So many steps count. `longest_way`: m, no particle has gone farther in them.
  void accept(double longest_way, int steps = 1) { gone_ += longest_way + steps * rounding_; }

  Vec3 position(Index i) const override;
  Vec3 predicted_velocity(Index i) const override;
  Vec3 withheld(Index i) const override;
  void fetch(std::span<const Index> rows, VecList& position, VecList& velocity) const override;
  double gone() const override { return gone_; }
  double going() const override { return going_; }
  void find(const Region& region, std::vector<Index>& found) const override;
  void add_force(Index i, const Vec3& force) override;
  void shift(Index i, const Vec3& by) override;

 private:
  struct Seen {
    Vec3 position{0, 0, 0};                     // m
    Vec3 velocity{0, 0, 0}, withheld{0, 0, 0};  // m/s and N, in the step `step`
    double gone = 0.0;                          // m, gone_ when it was there
    std::uint64_t step = 0, used = 0;           // the last in which it was gathered, and asked for
  };
  bool is_known(Index i) const { return seen_[static_cast<std::size_t>(i)].step == step_; }
  const Seen& see(Index i) const;
  void gather() const;    // asked_
  void take() const;      // what gather() brought
  void ask_more() const;  // both, where there are some
  void use(Seen& seen, Index i) const;

  const VecList& rest_;
  std::vector<std::array<Index, 3>> triangles_;  // of the surface
  std::vector<Index> surface_;                   // their particles
  double spacing_;                               // m
  Device* device_ = nullptr;
  double read_at_ = -1.0;  // m, gone_ when all places were read; below 0: they are not known
  double dt_ = 0.0, gone_ = 0.0, going_ = 0.0, rounding_ = 0.0;  // s, m
  std::uint64_t step_ = 0;
  mutable std::vector<Seen> seen_;  // [particles]
  mutable std::vector<Index> asked_, used_;
  mutable std::vector<OpenRow> rows_;
  std::vector<Push> pushes_;
};

}  // namespace phymul::gl
