// SPDX-License-Identifier: MIT
//
// What a haptic loop moves: a soft block of about so many particles, lower face held, spacing 5 mm, with something in
// it that follows a hand.
#pragma once

#include <phymul/phymul.h>

#include <memory>
#include <string>

namespace phymul::bench {

inline constexpr double tick = 1e-3;            // s
inline constexpr double haptic_spacing = 5e-3;  // m

class HapticScene {
 public:
  explicit HapticScene(int particles);
  virtual ~HapticScene() = default;
  HapticScene(const HapticScene&) = delete;
  HapticScene& operator=(const HapticScene&) = delete;

  const Model& model() const { return model_; }
  Scene& scene() { return scene_; }

  /// To where the hand is a tick later.
  virtual void drive(double date) = 0;
  /// What a device asks for after a tick.
  virtual void answer(const Solver& solver) = 0;
  virtual std::string what() const = 0;   ///< moves
  virtual std::string found() const = 0;  ///< in all answers, for people; may be empty

 protected:
  Vec3 top(double x, double y) const;  ///< of the upper face, by shares of its sides

 private:
  Model model_;

 protected:
  Scene scene_;
};

/// The particles near the middle of the upper face, moved by three translations, one an axis.
class MovedParticles final : public HapticScene {
 public:
  explicit MovedParticles(int particles);
  void drive(double date) override;
  void drive_by_replacing(double date);  ///< the same by Scene::replace, for what that would cost
  void answer(const Solver&) override {}
  std::string what() const override;
  std::string found() const override { return {}; }

 private:
  std::size_t count_ = 0;
};

/// A ball of 2 cm that presses and rubs the upper face, and a needle that goes 45 mm in and out beside it, once a
/// second.
class ProbeAndNeedle final : public HapticScene {
 public:
  explicit ProbeAndNeedle(int particles);
  void drive(double date) override;
  void answer(const Solver& solver) override;
  std::string what() const override { return "a ball of 2 cm and a needle"; }
  std::string found() const override;

 private:
  ToolPose probe_at(double time) const;
  ToolPose needle_at(double time) const;
  double on_probe_ = 0.0, on_needle_ = 0.0, pulled_ = 0.0;  // N, greatest
  long answers_ = 0, inserted_ = 0;
};

}  // namespace phymul::bench
