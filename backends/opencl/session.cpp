#include "backends/opencl/session.hpp"

#include "backends/opencl/programs.hpp"
#include "backends/shared/tiles.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <utility>
#include <vector>

namespace hdmbench::opencl {

namespace {

/// Levels of up to so many sites are swept by one group in one dispatch: starting another one takes longer.
/// No flags are kept for them either.
constexpr std::size_t most_for_one_group = std::size_t{64} * 64;

/// Sites that are updated before the host waits, by all groups and by one: no driver takes that for hung, and
/// none gathers too many commands.
constexpr double most_in_flight = 2e9;
constexpr double most_by_one_group = 2e7;

/// An array over the sites on the device: planes of one float a site, with room around for what a row reads
/// beyond the border.
struct Layout {
  Layout() = default;
  explicit Layout(Extent extent)
      : origin((static_cast<std::size_t>(extent.width) + 16) / 16 * 16),
        plane((extent.sites() + 2 * origin + 15) / 16 * 16) {}

  [[nodiscard]] std::size_t bytes(std::size_t planes) const { return planes * plane * sizeof(float); }
  /// Where a plane's first site is.
  [[nodiscard]] std::size_t offset(std::size_t number) const {
    return (number * plane + origin) * sizeof(float);
  }

  std::size_t origin = 0; ///< floats
  std::size_t plane = 0;  ///< floats
};

class SweepSession final : public Session {
public:
  SweepSession(Queue queue, Work work)
      : queue_(std::move(queue)), work_(work), kernels_(queue_),
        counter_(queue_.make_buffer(sizeof(cl_uint))) {}

private:
  void do_load(const Level& level) override {
    const Layout layout(level.extent);
    require_fits(level, layout);
    level_ = without_fields(level);
    layout_ = layout;
    const bool curvature = needs_inverse_curvature(level.rule);
    for (Buffer& displacement : displacements_) {
      queue_.make_room(displacement, layout_.bytes(2));
    }
    upload(material_, {&level.modulus.values, &level.inverse_modulus.values});
    upload(observation_, {&level.target.x, &level.target.y, &level.confidence.x, &level.confidence.y});
    if (curvature) {
      upload(inverse_curvature_, {&level.inverse_curvature.x, &level.inverse_curvature.y});
    } else {
      queue_.make_room(inverse_curvature_, sizeof(float));
    }
    std::vector<const std::vector<float>*> inputs;
    for (const ScalarField& input : level.inputs) {
      inputs.push_back(&input.values);
    }
    upload(inputs_, inputs);
    prepare_tiles(level);
    queue_.finish();
  }

  void do_write(const VectorField& displacement) override {
    newest_ = 0;
    every_ = true;
    write_planes(displacements_[newest_], {&displacement.x, &displacement.y});
  }

  void do_step(int first, int sweeps) override {
    const Kernel& kernel = kernels_.sweep(kind_);
    kernel.set(2, material_);
    kernel.set(3, observation_);
    kernel.set(4, inverse_curvature_);
    kernel.set(5, inputs_);
    kernel.set(6, classes_);
    kernel.set(7, flags_);
    const auto sites = static_cast<double>(level_.extent.sites());
    const int at_once = one_group() ? static_cast<int>(std::clamp(most_by_one_group / sites, 1.0, 1e6)) : 1;
    double in_flight = 0;
    for (int number = first; number < first + sweeps; number += at_once) {
      const int together = std::min(at_once, first + sweeps - number);
      sweep(kernel, number, together);
      in_flight += sites * together;
      if (in_flight > most_in_flight) {
        queue_.finish();
        in_flight = 0;
      }
    }
    queue_.finish();
  }

  void do_read(VectorField& displacement) override {
    queue_.read(displacements_[newest_], layout_.offset(0), displacement.x);
    queue_.read(displacements_[newest_], layout_.offset(1), displacement.y);
  }

  std::int64_t do_changed() override {
    queue_.clear(counter_, sizeof(cl_uint));
    const Kernel& count = kernels_.count();
    count.set(0, displacements_[newest_]);
    count.set(1, displacements_[1 - newest_]);
    count.set(2, counter_);
    count.set(3, cl_int{level_.extent.width});
    count.set(4, static_cast<cl_uint>(layout_.origin));
    count.set(5, static_cast<cl_uint>(layout_.plane));
    queue_.run(count, static_cast<std::size_t>(level_.extent.height), lanes());
    cl_uint changed = 0;
    queue_.read_bytes(counter_, sizeof(changed), &changed);
    return changed;
  }

  /// Whether one group may do several sweeps: what it is told must be the same in all of them.
  [[nodiscard]] bool one_group() const {
    return level_.extent.sites() <= most_for_one_group && changes_spread_by_contact(level_);
  }
  [[nodiscard]] std::size_t lanes() const { return static_cast<std::size_t>(kernels_.shape().lanes); }

  /// Sweeps first ... first + count - 1 in one dispatch.
  void sweep(const Kernel& kernel, int first, int count) {
    const SweepState state = sweep_state(level_, first);
    const std::size_t tile_count = tiles_.sites();
    if (kind_.active) {
      ++stamp_;
    }
    kernel.set(0, displacements_[newest_]);
    kernel.set(1, displacements_[1 - newest_]);
    kernel.set(8, SweepParameters{.steps = level_.steps.padded(),
                                  .penalty = level_.penalty,
                                  .colour = state.colour,
                                  .strength = state.strength,
                                  .number = state.number,
                                  .seed = state.seed,
                                  .width = level_.extent.width,
                                  .height = level_.extent.height,
                                  .origin = static_cast<cl_uint>(layout_.origin),
                                  .plane = static_cast<cl_uint>(layout_.plane),
                                  .tiles_across = tiles_.width,
                                  .tile_count = static_cast<cl_int>(tile_count),
                                  .sweeps = count,
                                  .every = every_ ? 1 : 0,
                                  .stamp = stamp_});
    queue_.run(kernel, one_group() ? 1 : tile_count, lanes());
    every_ = false;
    newest_ = (newest_ + static_cast<std::size_t>(count)) % 2;
  }

  /// Which kernel sweeps the level, and what it has to know of the tiles.
  void prepare_tiles(const Level& level) {
    const bool fast = changes_spread_by_contact(level);
    tiles_ = tiles_of(level.extent, kernels_.shape().tile);
    kind_ = {.constants = shader_constants(level),
             .active = work_ == Work::active && fast && level.extent.sites() > most_for_one_group,
             .general = !fast};
    std::vector<std::uint8_t> classes{0};
    if (fast) {
      classes = classify_tiles(level, level.extent, Alignment::corner,
                               {.tile = kernels_.shape().tile, .classes = classes_with_code})
                    .classes;
    }
    queue_.make_room(classes_, classes.size());
    queue_.write_bytes(classes_, classes.size(), classes.data());
    const std::size_t flag_bytes = kind_.active ? 2 * tiles_.sites() * sizeof(cl_uint) : sizeof(cl_uint);
    queue_.make_room(flags_, flag_bytes);
    queue_.clear(flags_, flag_bytes);
    stamp_ = 0;
    (void)kernels_.sweep(kind_); // compiled now, not while somebody times sweeps
  }

  void upload(Buffer& buffer, const std::vector<const std::vector<float>*>& planes) const {
    queue_.make_room(buffer, std::max(layout_.bytes(planes.size()), sizeof(float)));
    write_planes(buffer, planes);
  }

  void write_planes(const Buffer& buffer, const std::vector<const std::vector<float>*>& planes) const {
    for (std::size_t number = 0; number < planes.size(); ++number) {
      queue_.write(buffer, layout_.offset(number), *planes[number]);
    }
  }

  /// Throws TooLarge.
  void require_fits(const Level& level, const Layout& layout) const {
    const std::size_t largest = layout.bytes(4);
    const std::size_t planes =
        2 * 2 + 2 + 4 + (needs_inverse_curvature(level.rule) ? 2 : 0) + level.inputs.size();
    const FoundDevice& device = queue_.device();
    if (largest > device.largest_buffer || layout.bytes(planes) > device.memory ||
        layout.plane > std::numeric_limits<std::int32_t>::max()) {
      throw TooLarge(
          fmt::format("{}: {} x {} sites need {} bytes, {} in one buffer; the device has {} and {}",
                      device.description.name, level.extent.width, level.extent.height, layout.bytes(planes),
                      largest, device.memory, device.largest_buffer));
    }
  }

  Queue queue_;
  Work work_;
  Kernels kernels_;
  std::array<Buffer, 2> displacements_; ///< x, y
  Buffer material_;                     ///< modulus, 1 / modulus
  Buffer observation_;                  ///< target x, y, confidence x, y
  Buffer inverse_curvature_;            ///< x, y; one float where the rule needs none
  Buffer inputs_;                       ///< Level::inputs
  Buffer classes_;                      ///< of the tiles; one byte where all are general
  Buffer flags_;                        ///< of the tiles, as sweep.cl has them
  Buffer counter_;
  Level level_; ///< without its fields
  Layout layout_;
  Extent tiles_;
  SweepKind kind_;
  std::size_t newest_ = 0; ///< which displacement is the field; the other one is the field one sweep before
  cl_uint stamp_ = 0;      ///< of the sweep before, since load
  bool every_ = true;      ///< the next sweep visits every tile
};

} // namespace

std::unique_ptr<Session> make_session(Queue queue, Work work) {
  return std::make_unique<SweepSession>(std::move(queue), work);
}

} // namespace hdmbench::opencl
