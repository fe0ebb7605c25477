#pragma once

#include "backends/device/device.hpp"

namespace hdmbench {

/// A session over `Levels`, which has its functions (without "do_"; those of pyramids where it can) and is
/// made of an Owner and what comes after it (OnDevice).
template <typename Owner, typename Levels>
class LevelSession final : public Session {
public:
  template <typename... Arguments>
  explicit LevelSession(std::unique_ptr<Owner> owner, Arguments... arguments)
      : levels_(std::move(owner), arguments...) {}

private:
  void do_load(const Level& level) override {
    levels_([&](Levels& levels) { levels.load(level); });
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
    if constexpr (has_pyramids) {
      levels_([&](Levels& levels) { levels.load(pyramid); });
    }
  }
  void do_solve(const Advance& advance) override {
    if constexpr (has_pyramids) {
      levels_([&](Levels& levels) { levels.solve(advance); });
    } else {
      Session::do_solve(advance);
    }
  }

  static constexpr bool has_pyramids = requires(Levels & levels, const Pyramid& pyramid) {
    levels.load(pyramid);
  };

  OnDevice<Owner, Levels> levels_;
};

} // namespace hdmbench
