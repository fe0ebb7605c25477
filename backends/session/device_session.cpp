#include "backends/session/device_backend.hpp"

#include "backends/device/recording.hpp"
#include "backends/session/sweeps.hpp"
#include "kernels/shaders/level_passes.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace hdmbench {

namespace {

/// Keeps what is waited for short enough for the watchdogs of drivers: about a second at 10^8 sites a second.
/// A sweep counts as this many sites at least.
constexpr std::size_t updates_at_once = std::size_t{1} << 27;
constexpr std::size_t least_updates_of_sweep = std::size_t{1} << 15;

/// Of the shaders that visit each site once: groups of 64 along x. In OpenCL C a group takes a row.
constexpr int group_width = 64;

/// Words of kernels/shaders/levels.comp and levels.cl.
struct LevelPass {
  std::int32_t width = 0;
  std::int32_t height = 0;
  std::uint32_t origin = 0;
  std::uint32_t plane = 0;
  std::int32_t from_width = 0;
  std::int32_t from_height = 0;
  std::uint32_t from_origin = 0;
  std::uint32_t from_plane = 0;
  std::int32_t first_column = 0; ///< of the level's entries
};

/// Words of kernels/shaders/coarse_levels.comp.
struct CoarseLevels {
  float penalty = 0.0F;
  std::int32_t full_width = 0;
  std::int32_t first_level = 0;
  std::int32_t level_count = 0;
};

/// What a session has on its device.
class DeviceLevels {
public:
  DeviceLevels(ComputeDevice& device, Work work, Shapes shapes)
      : device_(device), work_(work), shapes_(shapes), programs_(device),
        counter_(device.allocate(1, Kind::words)) {
    (void)level_pass(LEVEL_COUNT, {}, {}); // compiles what every solution asks for at its end
  }

  void load(const Level& level) {
    upload_full(level);
    upload_inputs(level, Alignment::corner, {level.extent});
    levels_.push_back(std::make_unique<Sweeps>(device_, programs_,
                                               SweptLevel{.full = level,
                                                          .extent = level.extent,
                                                          .strengths = level.strengths,
                                                          .work = work_,
                                                          .shape = shapes_.sweep}));
    device_.finish();
  }

  void write(const VectorField& displacement) {
    displacements_.newest = 0;
    write_vectors(device_, *displacements_.field(), layout_, {&displacement});
    Commands commands;
    levels_.front()->wake_all(commands);
    device_.run(commands);
    device_.finish();
  }

  void step(int first, int sweeps) {
    const int most = static_cast<int>(std::max<std::size_t>(updates_at_once / cost_of(layout_.extent), 1));
    for (int done = 0; done < sweeps; done += most) {
      Commands commands;
      levels_.front()->append(commands, first + done, std::min(most, sweeps - done), full_, *inputs_,
                              displacements_);
      device_.run(commands);
      device_.finish();
    }
  }

  void read(VectorField& displacement) {
    read_vector(device_, *displacements_.field(), layout_, displacement);
  }

  std::optional<double> device_seconds() { return device_.device_seconds(); }

  std::int64_t changed() {
    Commands commands{Fill{.array = counter_.get(), .bytes = counter_->bytes()}};
    Dispatch count = level_pass(LEVEL_COUNT, layout_, layout_);
    count.arrays[binding::displacement] = displacements_.field();
    count.arrays[binding::improved] = displacements_.other();
    count.arrays[binding::counter] = counter_.get();
    commands.emplace_back(count);
    device_.run(commands);
    std::array<std::uint32_t, 1> changed{};
    device_.read(*counter_, 0, std::as_writable_bytes(std::span(changed)));
    return changed.front();
  }

  void load(const Pyramid& pyramid) {
    const Level& full = *pyramid.full;
    upload_full(full);
    const ResamplingEntries entries(pyramid);
    entries_ = upload(device_, Kind::fours, entries.texels);
    std::vector<Extent> extents;
    Extent sampled{};
    for (const PyramidLevel& level : pyramid.levels) {
      extents.push_back(level.extent);
      if (level.extent != full.extent && level.extent.sites() > sampled.sites()) {
        sampled = level.extent;
      }
    }
    upload_inputs(full, pyramid.alignment, extents);
    if (sampled.sites() > 0) {
      make_room(sampled_, layout_of(sampled), false);
    }
    const std::size_t together = coarse_level_count(pyramid, shapes_.coarse_group);
    for (std::size_t i = 0; i < pyramid.levels.size(); ++i) {
      levels_.push_back(i < together
                            ? nullptr
                            : std::make_unique<Sweeps>(device_, programs_,
                                                       SweptLevel{.full = full,
                                                                  .extent = pyramid.levels[i].extent,
                                                                  .alignment = pyramid.alignment,
                                                                  .strengths = pyramid.levels[i].strengths,
                                                                  .work = work_,
                                                                  .shape = shapes_.sweep,
                                                                  .first_input = first_inputs_[i]}));
    }
    record(pyramid, entries, together);
    device_.finish();
  }

  void solve(const Session::Advance& advance) {
    for (const Part& part : parts_) {
      device_.run(part.commands);
      device_.finish();
      advance(part.site_updates);
    }
    displacements_.newest = newest_of_pyramid_;
  }

private:
  /// Of a pyramid's commands.
  struct Part {
    Commands commands;
    double site_updates = 0.0;
  };

  static std::size_t cost_of(Extent extent) { return std::max(extent.sites(), least_updates_of_sweep); }

  [[nodiscard]] SiteLayout layout_of(Extent extent) const { return {extent, device_.limits().has_planes}; }

  [[nodiscard]] Extent groups_of(Extent extent) const {
    return device_.limits().has_planes
               ? Extent{1, extent.height, extent.depth}
               : Extent{(extent.width + group_width - 1) / group_width, extent.height, extent.depth};
  }

  /// Throws TooLarge where the device has too few work groups for a level.
  void require_groups(Extent extent) const {
    const auto require = [&](int needed, std::size_t limit, const char* what) {
      if (static_cast<std::size_t>(needed) > limit) {
        throw TooLarge(fmt::format("{}: {} sites need {} {}, the device has {}", device_.description().name,
                                   extent.text(), needed, what, limit));
      }
    };
    const Extent groups = groups_of(extent);
    require(groups.width, device_.limits().groups_x, "work groups in x");
    require(groups.height, device_.limits().groups_y, "work groups in y");
    require(groups.depth, device_.limits().groups_y, "work groups in z");
  }

  void make_room(LevelArrays& arrays, const SiteLayout& layout, bool curvature) {
    const auto make = [&](std::unique_ptr<Array>& array, std::size_t numbers, bool is_needed = true) {
      hdmbench::make_room(device_, array, is_needed ? layout.count(numbers) : 1, layout.kind(numbers));
    };
    make(arrays.material, 2);
    make(arrays.observation, 2 * layout.numbers_of_vector());
    make(arrays.inverse_curvature, layout.numbers_of_vector(), curvature);
  }

  /// The level itself and room for its displacement; forgets all that was loaded before.
  void upload_full(const Level& level) {
    require_groups(level.extent);
    parts_.clear();
    levels_.clear();
    layout_ = layout_of(level.extent);
    const std::size_t numbers = layout_.numbers_of_vector();
    for (std::unique_ptr<Array>& displacement : displacements_.arrays) {
      hdmbench::make_room(device_, displacement, layout_.count(numbers), layout_.kind(numbers));
    }
    const bool curvature = needs_inverse_curvature(level.rule);
    make_room(full_, layout_, curvature);
    write_sites(device_, *full_.material, 0, layout_, {level.modulus.values, level.inverse_modulus.values});
    write_vectors(device_, *full_.observation, layout_, {&level.target, &level.confidence});
    if (curvature) {
      write_vectors(device_, *full_.inverse_curvature, layout_, {&level.inverse_curvature});
    }
  }

  /// The energy's own numbers, of the full level first and then of those that sample it: four a site, those
  /// that it does not have 0.
  void upload_inputs(const Level& full, Alignment alignment, const std::vector<Extent>& extents) {
    first_inputs_.assign(extents.size(), 0);
    if (full.inputs.empty()) {
      hdmbench::make_room(device_, inputs_, 1, layout_.kind(4));
      return;
    }
    std::size_t count = layout_.count(4);
    for (std::size_t i = 0; i < extents.size(); ++i) {
      if (extents[i] != full.extent) {
        first_inputs_[i] = static_cast<std::int32_t>(count);
        count += layout_of(extents[i]).count(4);
      }
    }
    hdmbench::make_room(device_, inputs_, count, layout_.kind(4));
    for (std::size_t i = 0; i < extents.size(); ++i) {
      std::vector<ScalarField> inputs = sample_inputs(full, extents[i], alignment);
      inputs.resize(4, ScalarField(extents[i]));
      write_sites(device_, *inputs_, static_cast<std::size_t>(first_inputs_[i]), layout_of(extents[i]),
                  {inputs[0].values, inputs[1].values, inputs[2].values, inputs[3].values});
    }
  }

  /// All levels from a null field, the first `together` of them in one dispatch of a group.
  void record(const Pyramid& pyramid, const ResamplingEntries& entries, std::size_t together) {
    Commands commands;
    double updates = 0.0;
    std::size_t cost = 0;
    const auto close = [&] {
      if (!commands.empty()) {
        parts_.push_back({std::exchange(commands, {}), std::exchange(updates, 0.0)});
        cost = 0;
      }
    };
    displacements_.newest = 0;
    if (together > 0) {
      commands.emplace_back(coarse_levels(pyramid, entries, together));
      displacements_.swap();
      for (std::size_t i = 0; i < together; ++i) {
        updates += static_cast<double>(pyramid.levels[i].extent.sites()) * pyramid.levels[i].sweeps;
      }
      cost = updates_at_once / 2; // at most about half a second
    } else {
      const SiteLayout first = layout_of(pyramid.levels.front().extent);
      const std::size_t numbers = first.numbers_of_vector();
      commands.emplace_back(Fill{.array = displacements_.field(),
                                 .bytes = first.count(numbers) * bytes_of(first.kind(numbers))});
    }
    for (std::size_t i = together; i < pyramid.levels.size(); ++i) {
      const PyramidLevel& level = pyramid.levels[i];
      const SiteLayout layout = layout_of(level.extent);
      const bool is_full = level.extent == pyramid.full->extent;
      if (!is_full) {
        sample(commands, layout, entries.begins[i]);
      }
      if (i > 0 && pyramid.levels[i - 1].extent != level.extent) {
        project(commands, layout_of(pyramid.levels[i - 1].extent), layout, entries.begins[i]);
      }
      levels_[i]->wake_all(commands);
      for (int first = 0; first < level.sweeps;) {
        const std::size_t affordable =
            cost < updates_at_once ? (updates_at_once - cost) / cost_of(level.extent) : 0;
        const int count = static_cast<int>(
            std::clamp<std::size_t>(affordable, 1, static_cast<std::size_t>(level.sweeps - first)));
        levels_[i]->append(commands, first, count, is_full ? full_ : sampled_, *inputs_, displacements_);
        first += count;
        updates += static_cast<double>(level.extent.sites()) * count;
        cost += cost_of(level.extent) * static_cast<std::size_t>(count);
        if (cost + cost_of(level.extent) > updates_at_once) {
          close();
        }
      }
    }
    close();
    newest_of_pyramid_ = displacements_.newest;
  }

  Dispatch coarse_levels(const Pyramid& pyramid, const ResamplingEntries& entries, std::size_t count) {
    const Level& full = *pyramid.full;
    Dispatch dispatch{.program = &programs_({.kernel = Kernel::coarse_levels,
                                             .constants = {{"INVOCATIONS", shapes_.coarse_group},
                                                           {"STEP_COUNT", full.steps.count()},
                                                           {"STOPS_AT_REST", work_ == Work::active ? 1 : 0}},
                                             .energy = full.energy})};
    dispatch.arrays[binding::material] = full_.material.get();
    dispatch.arrays[binding::observation] = full_.observation.get();
    dispatch.arrays[binding::inputs] = inputs_.get();
    dispatch.arrays[binding::entries] = entries_.get();
    dispatch.arrays[binding::improved] = displacements_.other();
    dispatch.tell(CoarseLevels{.penalty = full.penalty,
                               .full_width = full.extent.width,
                               .first_level = entries.levels_begin,
                               .level_count = static_cast<std::int32_t>(count)});
    dispatch.steps = full.steps.padded();
    dispatch.step_count = full.steps.count();
    return dispatch;
  }

  /// `pass` of kernels/shaders/level_passes.h. Entries of `to` begin at `first`.
  [[nodiscard]] Dispatch level_pass(int pass, const SiteLayout& from, const SiteLayout& to,
                                    std::int32_t first = 0) {
    ProgramKind kind{.kernel = Kernel::levels, .constants = {{"PASS", pass}}, .axes = to.extent.axes()};
    if (device_.limits().has_planes) {
      kind.constants.push_back({"LANES", shapes_.sweep.invocations()});
    }
    Dispatch dispatch{.program = &programs_(kind), .groups = groups_of(to.extent)};
    dispatch.tell(LevelPass{.width = to.extent.width,
                            .height = to.extent.height,
                            .origin = static_cast<std::uint32_t>(to.origin),
                            .plane = static_cast<std::uint32_t>(to.plane),
                            .from_width = from.extent.width,
                            .from_height = from.extent.height,
                            .from_origin = static_cast<std::uint32_t>(from.origin),
                            .from_plane = static_cast<std::uint32_t>(from.plane),
                            .first_column = first});
    return dispatch;
  }

  void sample(Commands& commands, const SiteLayout& layout, std::int32_t first) {
    Dispatch dispatch = level_pass(LEVEL_SAMPLE, layout_, layout, first);
    dispatch.arrays[binding::entries] = entries_.get();
    dispatch.arrays[binding::material] = full_.material.get();
    dispatch.arrays[binding::observation] = full_.observation.get();
    dispatch.arrays[binding::sampled_material] = sampled_.material.get();
    dispatch.arrays[binding::sampled_observation] = sampled_.observation.get();
    commands.emplace_back(dispatch);
  }

  void project(Commands& commands, const SiteLayout& above, const SiteLayout& layout, std::int32_t first) {
    Dispatch dispatch = level_pass(LEVEL_PROJECT, above, layout, first);
    dispatch.arrays[binding::entries] = entries_.get();
    dispatch.arrays[binding::displacement] = displacements_.field();
    dispatch.arrays[binding::improved] = displacements_.other();
    dispatch.beside = layout.extent != layout_.extent; // the level is sampled beside it
    commands.emplace_back(dispatch);
    displacements_.swap();
  }

  ComputeDevice& device_;
  Work work_;
  Shapes shapes_;
  Programs programs_;
  std::unique_ptr<Array> counter_;
  SiteLayout layout_; ///< of the full level
  Displacements displacements_;
  LevelArrays full_;
  LevelArrays sampled_;                         ///< of the level of a pyramid that is swept
  std::unique_ptr<Array> inputs_;               ///< the energy's own
  std::vector<std::int32_t> first_inputs_;      ///< per level, where its elements of them begin
  std::unique_ptr<Array> entries_;              ///< of a pyramid's levels: ResamplingEntries
  std::vector<std::unique_ptr<Sweeps>> levels_; ///< of the level or the pyramid; null: computed together
  std::vector<Part> parts_;                     ///< of the pyramid; their arrays and programs outlive them
  std::size_t newest_of_pyramid_ = 0;
};

/// What DeviceBackend opens.
struct KernelSource {
  std::unique_ptr<ComputeApi> api;

  [[nodiscard]] std::vector<Device> devices() const { return api->devices(); }
  [[nodiscard]] std::unique_ptr<Session> session(std::size_t index, const SessionOptions& options) const {
    return make_device_session(recorded(api->open(index), options.recording), options.work);
  }
  [[nodiscard]] std::unique_ptr<ElasticSession> elastic(std::string name, std::size_t index,
                                                        const SessionOptions& options) const {
    return make_elastic_session(std::move(name), recorded(api->open(index), options.recording));
  }
  [[nodiscard]] OnDevice<ComputeDevice, DeviceLoops> loops(std::size_t index) const {
    return OnDevice<ComputeDevice, DeviceLoops>(api->open(index));
  }
};

} // namespace

std::unique_ptr<Backend> make_device_backend(DeviceBackendName name, std::unique_ptr<ComputeApi> api) {
  return std::make_unique<DeviceBackend<KernelSource>>(std::move(name), KernelSource{std::move(api)});
}

std::unique_ptr<Session> make_device_session(std::unique_ptr<ComputeDevice> device, Work work,
                                             std::optional<Shapes> shapes) {
  const Shapes taken = shapes.value_or(shapes_for(*device));
  return std::make_unique<LevelSession<ComputeDevice, DeviceLevels>>(std::move(device), work, taken);
}

} // namespace hdmbench
