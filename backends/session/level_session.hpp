#pragma once

#include "backends/device/device.hpp"

namespace hdmbench {

/// A session over `Levels`, which has its functions (without "do_") and is made of an Owner and Work
/// (OnDevice). What may measure, in a session of its own, is asked before the device is used.
template <typename Owner, typename Levels>
class LevelSession final : public Session {
public:
  LevelSession(std::unique_ptr<Owner> owner, Work work)
      : levels_(std::move(owner), work),
        has_variants_(levels_([](const Levels& levels) { return levels.has_variants(); })) {}

private:
  void do_load(const Level& level) override {
    const std::size_t taken = Levels::has_shapes ? shape(level.extent) : 0;
    levels_([&](Levels& levels) { levels.load(level, taken); });
  }
  void do_write(const VectorField& displacement) override {
    levels_([&](Levels& levels) { levels.write(displacement); });
  }
  void do_step(int first, int sweeps) override {
    levels_([&](Levels& levels) { levels.step(first, sweeps); });
  }
  void do_read(VectorField& displacement) override {
    levels_([&](Levels& levels) { levels.read(displacement); });
  }
  std::int64_t do_changed() override {
    return levels_([&](Levels& levels) { return levels.changed(); });
  }
  void do_load_pyramid(const Pyramid& pyramid) override {
    const int group = has_variants_ && has_coarse_levels(pyramid) ? coarse_groups.at(variant()) : 0;
    const std::size_t taken = Levels::has_shapes ? shape(pyramid.full->extent) : 0;
    levels_([&](Levels& levels) { levels.load(pyramid, group, taken); });
  }
  void do_solve(const Advance& advance) override {
    levels_([&](Levels& levels) { levels.solve(advance); });
  }

  OnDevice<Owner, Levels> levels_;
  bool has_variants_; ///< else there is one way only, and SessionOptions::variant says nothing
};

} // namespace hdmbench
