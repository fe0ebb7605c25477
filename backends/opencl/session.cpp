#include "backends/opencl/session.hpp"

#include "backends/opencl/sweeps.hpp"
#include "backends/shared/resampling_entries.hpp"

#include <algorithm>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

namespace hdmbench::opencl {

namespace {

/// A level of a pyramid.
struct DeviceLevel {
  int count = 0; ///< of its sweeps
  Sweeps sweeps;
  cl_int first_column = 0; ///< of its entries
};

class SweepSession final : public Session {
public:
  SweepSession(Queue queue, std::vector<Shape> shapes, Work work)
      : queue_(std::move(queue)), shapes_(std::move(shapes)), work_(work), kernels_(queue_),
        counter_(queue_.make_buffer(sizeof(cl_uint))) {}

private:
  void do_load(const Level& level) override {
    const Shape& tiles = shapes_.at(shape(level.extent));
    upload_full(level, 0);
    sweeps_.emplace(queue_, kernels_, tiles, level, level.extent, Alignment::corner, level.strengths, work_,
                    InputTexels(level), 0);
    queue_.finish();
  }

  void do_write(const VectorField& displacement) override {
    write_planes(queue_, displacements_.field(), layout_, {displacement.x, displacement.y});
    sweeps_->wake_all();
  }

  void do_step(int first, int sweeps) override {
    for (int done = 0; done < sweeps;) {
      done += sweeps_->run(first + done, sweeps - done, full_, displacements_);
      queue_.finish();
    }
  }

  void do_read(VectorField& displacement) override {
    queue_.read(displacements_.field(), layout_.offset(0), displacement.x);
    queue_.read(displacements_.field(), layout_.offset(1), displacement.y);
  }

  std::int64_t do_changed() override {
    queue_.clear(counter_, sizeof(cl_uint));
    const Kernel& count = kernels_.count();
    count.set(0, displacements_.field());
    count.set(1, displacements_.other());
    count.set(2, counter_);
    count.set(3, cl_int{extent_.width});
    count.set(4, static_cast<cl_uint>(layout_.origin));
    count.set(5, static_cast<cl_uint>(layout_.plane));
    run_rows(count, extent_);
    cl_uint changed = 0;
    queue_.read_bytes(counter_, sizeof(changed), &changed);
    return changed;
  }

  void do_load_pyramid(const Pyramid& pyramid) override {
    const Level& full = *pyramid.full;
    const Shape& tiles = shapes_.at(shape(full.extent));
    Extent sampled{};
    for (const PyramidLevel& level : pyramid.levels) {
      if (level.extent != full.extent && level.extent.sites() > sampled.sites()) {
        sampled = level.extent;
      }
    }
    upload_full(full, sampled.sites());
    if (sampled.sites() > 0) {
      make_room(queue_, sampled_, Layout(sampled), false);
    }
    const ResamplingEntries entries(pyramid);
    const std::size_t bytes = entries.texels.size() * sizeof(entries.texels.front());
    queue_.make_room(entries_, bytes);
    queue_.write_bytes(entries_, bytes, entries.texels.data());
    const InputTexels inputs(pyramid);
    for (std::size_t i = 0; i < pyramid.levels.size(); ++i) {
      const PyramidLevel& plan = pyramid.levels[i];
      const auto first_input = static_cast<std::size_t>(inputs.first[i]);
      levels_.push_back({.count = plan.sweeps,
                         .sweeps = {queue_, kernels_, tiles, full, plan.extent, pyramid.alignment,
                                    plan.strengths, work_, inputs, first_input},
                         .first_column = entries.begins[i]});
    }
    queue_.finish();
  }

  void do_solve(const Advance& advance) override {
    queue_.clear(displacements_.field(), levels_.front().sweeps.layout().bytes(2));
    const DeviceLevel* above = nullptr;
    double in_flight = 0.0; // site updates
    for (DeviceLevel& level : levels_) {
      if (above != nullptr) {
        resample(kernels_.project(), {&displacements_.field(), &displacements_.other()}, above->sweeps,
                 level);
        displacements_.swap();
      }
      above = &level;
      const bool is_full = level.sweeps.extent() == extent_;
      if (!is_full) {
        resample(kernels_.sample(),
                 {&full_.material, &full_.observation, &sampled_.material, &sampled_.observation},
                 levels_.back().sweeps, level);
      }
      level.sweeps.wake_all();
      for (int first = 0; first < level.count;) {
        const int done =
            level.sweeps.run(first, level.count - first, is_full ? full_ : sampled_, displacements_);
        first += done;
        in_flight += static_cast<double>(level.sweeps.extent().sites()) * done;
        if (first < level.count) {
          queue_.finish();
          advance(std::exchange(in_flight, 0.0));
        }
      }
    }
    queue_.finish();
    advance(in_flight);
  }

  /// The level itself and room for its displacement; forgets all that was loaded before.
  void upload_full(const Level& level, std::size_t sampled) {
    require_fits(queue_.device(), level, sampled);
    sweeps_.reset();
    levels_.clear();
    extent_ = level.extent;
    layout_ = Layout(extent_);
    for (Buffer& displacement : displacements_.buffers) {
      queue_.make_room(displacement, layout_.bytes(2));
    }
    make_room(queue_, full_, layout_, needs_inverse_curvature(level.rule));
    upload(queue_, full_, layout_, level);
  }

  /// `kernel` of resample.cl for `level` from what has the layout of `from`.
  void resample(const Kernel& kernel, std::initializer_list<const Buffer*> buffers, const Sweeps& from,
                const DeviceLevel& level) const {
    const Extent extent = level.sweeps.extent();
    cl_uint index = 0;
    for (const Buffer* const buffer : buffers) {
      kernel.set(index++, *buffer);
    }
    kernel.set(index++, entries_);
    kernel.set(index, ResamplingParameters{.width = extent.width,
                                           .origin = static_cast<cl_uint>(level.sweeps.layout().origin),
                                           .plane = static_cast<cl_uint>(level.sweeps.layout().plane),
                                           .from_width = from.extent().width,
                                           .from_origin = static_cast<cl_uint>(from.layout().origin),
                                           .from_plane = static_cast<cl_uint>(from.layout().plane),
                                           .first_column = level.first_column,
                                           .first_row = level.first_column + extent.width});
    run_rows(kernel, extent);
  }

  /// A group for each row.
  void run_rows(const Kernel& kernel, Extent extent) const {
    queue_.run(kernel, static_cast<std::size_t>(extent.height),
               static_cast<std::size_t>(shapes_.front().lanes));
  }

  Queue queue_;
  std::vector<Shape> shapes_; ///< by shape()
  Work work_;
  Kernels kernels_;
  Displacements displacements_;
  Fields full_;
  Fields sampled_; ///< of the level of a pyramid that is swept
  Buffer entries_; ///< of a pyramid's levels: ResamplingEntries
  Buffer counter_;
  std::optional<Sweeps> sweeps_;    ///< where load(level) was the last
  std::vector<DeviceLevel> levels_; ///< where load(pyramid) was the last
  Extent extent_;                   ///< these two are the full level's
  Layout layout_;
};

} // namespace

std::unique_ptr<Session> make_session(Queue queue, std::vector<Shape> shapes, Work work) {
  return std::make_unique<SweepSession>(std::move(queue), std::move(shapes), work);
}

} // namespace hdmbench::opencl
