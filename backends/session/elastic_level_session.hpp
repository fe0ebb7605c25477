#pragma once

#include "backends/device/device.hpp"
#include "backends/session/elastic_steps.hpp"
#include "backends/shared/kept_arithmetic.hpp"

#include <algorithm>
#include <span>
#include <string>
#include <utility>

namespace hdmbench {

/// A session of the elastic energy over `Steps`, which is made of an Owner (OnDevice) and has arrays and
/// kernels: load(hierarchy, layout), write(), read() and read_sum() of an ElasticArray, device_seconds(), and
/// run(), which need not wait until the work is done. Steps::block: sites a side of the blocks that one
/// kernel sums up; coarse_size(): how long the arrays of levels may be that an ElasticTogether has, 0 where
/// there is none. Where Steps::has_laws is true it has load(tissues), false where they are too large,
/// law_forces(), from the array of a field to another's, and is_software(). Every step writes an array that
/// is to spare, which then takes the field's place.
template <typename Owner, typename Steps>
class ElasticLevelSession final : public ElasticSession {
public:
  /// `name`: of the backend, for errors.
  ElasticLevelSession(std::string name, std::unique_ptr<Owner> owner)
      : name_(std::move(name)), steps_(std::move(owner)) {}

  void read(int level, ElasticField field, VectorField& values) const override {
    resize(values, part(array(level, field)).sites);
    on_device([&](Steps& steps) {
      run_all(steps);
      steps.read(array(level, field), values);
    });
  }

  std::optional<double> device_seconds() override {
    return on_device([&](Steps& steps) {
      run_all(steps);
      return steps.device_seconds();
    });
  }

  void take(const MethodStep& step) override {
    const int level = step.level;
    const bool is_image = level == 0;
    const bool has_load = step.from == ElasticField::correction;
    const ElasticArray from = array(level, step.from);
    const ElasticArray load = array(level, ElasticField::load);
    const auto correction = [&] { return array(level + 1, ElasticField::correction); };
    switch (step.kind) {
    case MethodStep::Kind::write:
      on_device([&](Steps& steps) {
        run_all(steps);
        steps.write(array(level, step.to), *step.values);
      });
      break;
    case MethodStep::Kind::relax:
      replace(step,
              {.step = ElasticStep::relax,
               .has_load = has_load,
               .is_image = is_volume_ && is_image,
               .has_masked = has_masked(level)},
              from, has_load ? load : from);
      break;
    case MethodStep::Kind::relax_from_zero:
      replace(step, {.step = ElasticStep::relax_from_zero}, load, load);
      break;
    case MethodStep::Kind::forces:
      replace(step, {.step = ElasticStep::residual, .is_image = true, .has_masked = has_masked(level)}, from,
              from);
      break;
    case MethodStep::Kind::restrict_residual:
      run({.step = ElasticStep::residual,
           .has_load = has_load,
           .is_image = is_image,
           .has_masked = has_masked(level)},
          from, has_load ? load : from, spare(level));
      run({.step = ElasticStep::restrict_sites, .halved = halved(level)}, spare(level), spare(level),
          array(level + 1, ElasticField::load));
      break;
    case MethodStep::Kind::restrict_load:
      run({.step = ElasticStep::restrict_sites, .is_image = is_volume_ || is_image, .halved = halved(level)},
          load, load, array(level + 1, ElasticField::load));
      break;
    case MethodStep::Kind::interpolate:
      replace(step, {.step = ElasticStep::interpolate, .is_image = is_image, .halved = halved(level)}, from,
              correction());
      break;
    case MethodStep::Kind::correct:
      replace(step, {.step = ElasticStep::correct, .is_image = is_image, .halved = halved(level)}, from,
              correction());
      break;
    case MethodStep::Kind::solve_coarsest:
      replace(step, {.step = ElasticStep::solve}, load, load);
      break;
    case MethodStep::Kind::advance:
      replace(step, {.step = ElasticStep::advance}, from, array(level, step.direction));
      break;
    }
  }

  bool has_own_laws() const override {
    if constexpr (Steps::has_laws) {
      return on_device([](const Steps& steps) { return !steps.is_software(); });
    }
    return false;
  }

  std::optional<LeastVolume> law_forces(const LawForces& tissues, const VectorField& displacement,
                                        VectorField& force) override {
    if constexpr (Steps::has_laws) {
      return on_device([&](Steps& steps) -> std::optional<LeastVolume> {
        run_all(steps);
        if (!steps.load(tissues)) {
          return {};
        }
        steps.write(array(0, ElasticField::image), displacement);
        const LeastVolume least = steps.law_forces(array(0, ElasticField::image), spare(0));
        std::swap(slots_.front()[static_cast<std::size_t>(ElasticField::image)], slots_.front()[spare_slot]);
        resize(force, displacement.extent);
        steps.read(array(0, ElasticField::image), force);
        return least;
      });
    }
    return {};
  }

  float dot(ElasticField first, ElasticField second) const override {
    ElasticArray sums{.slot = elastic_sums};
    Extent extent = layout_.levels.front().sites;
    Extent blocks = layout_.sums.sites;
    run({.step = ElasticStep::products}, array(0, first), array(0, second), sums, extent, blocks);
    while (blocks.sites() > 1) {
      extent = blocks;
      blocks = ElasticLayout::blocks_of(extent, Steps::block);
      const ElasticArray from =
          std::exchange(sums, {.slot = sums.slot == elastic_sums ? elastic_sums + 1 : elastic_sums});
      run({.step = ElasticStep::squares}, from, from, sums, extent, blocks);
    }
    return on_device([&](Steps& steps) {
      run_all(steps);
      return steps.read_sum(sums);
    });
  }

private:
  void do_load(ElasticHierarchy& hierarchy) override {
    is_volume_ = hierarchy.levels.front().grid.axes() == 3;
    std::int64_t most_coarse = 0;
    on_device([&](Steps& steps) {
      layout_ = ElasticLayout(hierarchy, Steps::block);
      steps.load(hierarchy, layout_);
      most_coarse = steps.coarse_size();
    });
    slots_.assign(hierarchy.levels.size(), initial_slots);
    calls_.clear();
    coarse_ = 1;
    for (int level = 2; level < levels(); ++level) {
      coarse_ = is_halved_from(level - 1) ? coarse_ : level;
    }
    while (coarse_ < levels() && coarse_size() > most_coarse) {
      ++coarse_;
    }
  }
  /// The slot of each field, and the one to spare.
  using Slots = std::array<int, elastic_fields + 1>;
  static constexpr std::size_t spare_slot = elastic_fields;
  static constexpr Slots initial_slots{3, 0, 1, 4, 5, 2};

  template <typename Call>
  auto on_device(const Call& call) const {
    const KeptArithmetic kept(name_);
    return with_name(name_, [&] { return steps_(call); });
  }

  [[nodiscard]] const Slots& slots(int level) const { return slots_.at(static_cast<std::size_t>(level)); }
  [[nodiscard]] ElasticArray array(int level, ElasticField field) const {
    return {.level = level, .slot = slots(level)[static_cast<std::size_t>(field)]};
  }
  [[nodiscard]] ElasticArray spare(int level) const {
    return {.level = level, .slot = slots(level)[spare_slot]};
  }
  [[nodiscard]] const ElasticLayout::Part& part(ElasticArray of) const {
    return of.slot < elastic_slots ? layout_.levels[static_cast<std::size_t>(of.level)] : layout_.sums;
  }
  [[nodiscard]] int levels() const { return static_cast<int>(slots_.size()); }
  [[nodiscard]] bool has_masked(int level) const { return !level_at(level).masked.empty(); }
  /// ElasticKernel::halved of the step from a level to the next coarser one.
  [[nodiscard]] int halved(int level) const { return halved_axes(level_at(level + 1).stride); }
  /// Whether the next coarser level is this one halved along all axes: the kernel that takes levels together
  /// knows no others. Levels that pieces compute elsewhere are as small as the first one that is not cut.
  [[nodiscard]] bool is_halved_from(int level) const {
    return halved(level) == 7 &&
           grid(level + 1).sites == coarser(grid(level).sites, level_at(level + 1).stride);
  }
  [[nodiscard]] std::array<float, 3> law(int level) const {
    const ElasticRatios<float>& ratio = level_at(level).ratio;
    return is_volume_ ? std::array{ratio.lame, ratio.y, ratio.z} : std::array{ratio.nu, ratio.shear, ratio.y};
  }

  /// What the step makes = what `kernel` makes of the arrays.
  void replace(const MethodStep& step, const ElasticKernel& kernel, ElasticArray from, ElasticArray second) {
    run(kernel, from, second, spare(step.level), step.factor);
    Slots& here = slots_[static_cast<std::size_t>(step.level)];
    std::swap(here[static_cast<std::size_t>(step.to)], here[spare_slot]);
  }
  void run(const ElasticKernel& kernel, ElasticArray from, ElasticArray second, ElasticArray to,
           float factor = 0.0F) const {
    run(kernel, from, second, to, part(from).sites, part(to).sites, factor);
  }
  void run(ElasticKernel kernel, ElasticArray from, ElasticArray second, ElasticArray to, Extent from_sites,
           Extent sites, float factor = 0.0F) const {
    const bool has_cells = kernel.step == ElasticStep::relax || kernel.step == ElasticStep::residual;
    kernel.has_boxes = has_cells && level_at(from.level).ratio.has_boxes();
    const ElasticParameters parameters{.law = law(from.level),
                                       .plane = static_cast<std::int32_t>(layout_.size),
                                       .moments_from = static_cast<std::int32_t>(layout_.moments_from()),
                                       .factor = factor,
                                       .to = place_of(part(to), sites),
                                       .from = place_of(part(from), from_sites),
                                       .second = place_of(part(second), part(second).sites),
                                       .bend = hierarchy().levels.front().bend};
    calls_.push_back({kernel, from, second, to, parameters});
    constexpr std::size_t most = 1024;
    if (calls_.size() == most) {
      on_device([&](Steps& steps) { run_all(steps); });
    }
  }

  /// Hands over what has been asked for, steps on the coarsest levels together. Nothing is handed over as
  /// nothing: a device takes time for that, too, and it would count as the next steps' own.
  void run_all(Steps& steps) const {
    if (calls_.empty()) {
      return;
    }
    const std::vector<ElasticCall> calls = std::exchange(calls_, {});
    std::vector<ElasticWork> work;
    for (auto call = calls.begin(); call != calls.end();) {
      auto end = call;
      while (end != calls.end() && is_coarse(*end) && end - call < ELASTIC_TOGETHER_STEPS) {
        ++end;
      }
      constexpr int worth_it = 3;
      if (end - call >= worth_it) {
        work.emplace_back(together({call, end}));
        call = end;
      } else {
        work.emplace_back(*call++);
      }
    }
    steps.run(work);
  }

  [[nodiscard]] bool is_coarse(const ElasticCall& call) const {
    return call.from.level >= coarse_ && call.kernel.step <= ElasticStep::solve;
  }
  /// Return the length of the arrays of levels from coarse_ on, and where these begin.
  [[nodiscard]] std::int64_t coarse_size() const { return layout_.size - coarse_base(); }
  [[nodiscard]] std::int64_t coarse_base() const {
    const ElasticLayout::Part& finest = layout_.levels[static_cast<std::size_t>(coarse_)];
    return finest.first - ElasticLayout::alone(finest.sites).first;
  }
  [[nodiscard]] ElasticTogether together(std::span<const ElasticCall> calls) const {
    const ElasticLayout::Part& finest = layout_.levels[static_cast<std::size_t>(coarse_)];
    ElasticTogether coarse{.law = law(coarse_),
                           .plane = static_cast<std::int32_t>(layout_.size),
                           .moments_from = static_cast<std::int32_t>(layout_.moments_from()),
                           .base = static_cast<std::int32_t>(coarse_base()),
                           .size = static_cast<std::int32_t>(coarse_size()),
                           .finest = coarse_,
                           .width = finest.sites.width,
                           .height = finest.sites.height,
                           .depth = finest.sites.depth,
                           .steps = static_cast<std::int32_t>(calls.size())};
    std::ranges::transform(calls, coarse.codes.begin(), [&](const ElasticCall& call) {
      return static_cast<std::int32_t>(call.kernel.step) | call.from.slot << 4 | call.second.slot << 6 |
             call.to.slot << 8 | (call.from.level - coarse_) << 10;
    });
    return coarse;
  }

  std::string name_;
  mutable OnDevice<Owner, Steps> steps_;
  ElasticLayout layout_;
  bool is_volume_ = false;
  std::vector<Slots> slots_;               ///< per level
  int coarse_ = 1;                         ///< the first of the levels that are computed together
  mutable std::vector<ElasticCall> calls_; ///< not handed over yet
};

} // namespace hdmbench
