#include "backends/cpu/cpu.hpp"

#include "backends/cpu/sweeper.hpp"
#include "backends/shared/energy_programs.hpp"
#include "backends/shared/tiles.hpp"

#include <fmt/format.h>
#include <omp.h>

#include <algorithm>
#include <array>

namespace hdmbench {

namespace {

using openmp::ActiveTiles;
using openmp::Field;
using openmp::Fields;
using openmp::InstructionSet;
using openmp::LevelData;
using openmp::Sweeper;
using openmp::SweepRow;

int thread_count(int requested) {
  return requested > 0 ? requested : omp_get_max_threads();
}

/// Below this many sites a second thread costs more than it brings.
constexpr std::size_t sites_worth_a_thread = 4096;

/// Sampled levels that take more are not kept for the next solution: bytes.
constexpr std::size_t sampled_worth_keeping = std::size_t{1} << 26;

/// Site updates between two reports of progress, of images and of volumes, whose sites take several times as
/// long: at most about half a second on two cores.
constexpr std::array updates_per_report{4e8, 4.5e7};

/// The rows of every energy.
struct Rows {
  std::size_t index;  ///< in EnergyPrograms::rows
  SweepRow planted{}; ///< in place of the thesis's energy's own; null: none

  [[nodiscard]] SweepRow of(const Energy& energy) const {
    return planted != nullptr && &energy == &thesis_energy ? planted : programs_of(energy).rows.at(index);
  }
};

/// How the sites are shared: dense.cpp, and active.cpp for Work::active.
class OpenMpSession final : public Session {
public:
  OpenMpSession(int threads, const Rows& rows, Work work) : threads_(threads), rows_(rows), work_(work) {}

private:
  void do_load(const Level& level) override {
    settings_ = without_fields(level);
    full_.copy(level, useful_threads(level.extent));
    newest_fields_ = 0;
    make_room(level.extent);
  }

  void do_write(const VectorField& displacement) override {
    Field& field = fields().current();
    for_each_row([&](std::size_t axis, std::size_t at, std::size_t width) {
      std::copy_n(displacement[axis].data() + at, width, field.components[axis].data() + at);
    });
    wake_all(full_);
  }
  void do_read(VectorField& displacement) override {
    const Field& field = fields().current();
    for_each_row([&](std::size_t axis, std::size_t at, std::size_t width) {
      std::copy_n(field.components[axis].data() + at, width, displacement[axis].data() + at);
    });
  }
  std::int64_t do_changed() override { return changed_; }

  void do_step(int first, int sweeps) override {
    changed_ = sweep(Sweeper(rows_.of(*settings_.energy), settings_, full_), first, sweeps, nullptr);
  }

  void do_load_pyramid(const Pyramid& pyramid) override {
    pyramid_ = pyramid;
    settings_ = without_fields(*pyramid.full);
    full_.borrow(*pyramid.full, useful_threads(pyramid.full->extent));
  }

  void do_solve(const Advance& advance) override {
    const std::size_t count = pyramid_.levels.size();
    Extent before{};
    for (std::size_t index = 0; index < count; ++index) {
      const PyramidLevel& level = pyramid_.levels[index];
      const bool last = index + 1 == count;
      const int threads = useful_threads(level.extent);
      settings_.extent = level.extent;
      settings_.strengths = level.strengths;
      if (last) {
        sampled_.release_beyond(sampled_worth_keeping);
      } else {
        sampled_.sample(*pyramid_.full, full_, level.extent, pyramid_.alignment, threads);
      }
      const Sweeper sweeper(rows_.of(*settings_.energy), settings_, last ? full_ : sampled_);
      // The finest level always has the same buffers, and the others do not grow to its size.
      Fields& coarse = fields();
      newest_fields_ = (count - index - 1) % 2;
      make_room(level.extent);
      wake_all(sweeper.data());
      if (index == 0) {
        fill_with_null();
        sweep_level(sweeper, level, nullptr, advance);
      } else {
        const auto [x, y, z] = coarse.current().data();
        const Projection projection({x, y, z}, before, level.extent, pyramid_.alignment);
        sweep_level(sweeper, level, &projection, advance);
      }
      before = level.extent;
    }
  }

  void sweep_level(const Sweeper& sweeper, const PyramidLevel& level, const Projection* projection,
                   const Advance& advance) {
    const double sites = static_cast<double>(level.extent.sites());
    const double updates = updates_per_report[level.extent.axes() - 2];
    const int chunk = static_cast<int>(std::clamp(updates / sites, 8.0, 1e9));
    if (projection != nullptr && (level.sweeps == 0 || level.extent.axes() > 2)) {
      projection->all_rows(fields().current().data(), useful_threads(level.extent));
      projection = nullptr;
    }
    for (int done = 0; done < level.sweeps;) {
      const int sweeps = std::min(chunk, level.sweeps - done);
      changed_ = sweep(sweeper, done, sweeps, done == 0 ? projection : nullptr);
      done += sweeps;
      advance(sites * sweeps);
    }
  }

  std::int64_t sweep(const Sweeper& sweeper, int first, int sweeps, const Projection* projection) {
    return is_active() ? active_.sweep(sweeper, fields(), first, sweeps, projection)
                       : sweep_densely(sweeper, fields(), first, sweeps, useful_threads(settings_.extent),
                                       projection);
  }

  /// call(axis, index, width) for each row of the components of the level.
  template <typename Call>
  void for_each_row(const Call& call) const {
    const Extent extent = settings_.extent;
#pragma omp parallel for num_threads(useful_threads(extent)) schedule(static)
    for (int y = 0; y < extent.rows(); ++y) {
      for (std::size_t axis = 0; axis < extent.axes(); ++axis) {
        call(axis, extent.index(0, y), static_cast<std::size_t>(extent.width));
      }
    }
  }

  void fill_with_null() {
    Field& field = fields().current();
    for_each_row([&](std::size_t axis, std::size_t at, std::size_t width) {
      std::fill_n(field.components[axis].data() + at, width, 0.0F);
    });
  }

  /// For the field of a level.
  void make_room(Extent extent) {
    for (Field& buffer : fields().buffers) {
      for (std::size_t axis = 0; axis < extent.axes(); ++axis) {
        buffer.components[axis].require(extent.sites());
      }
    }
    fields().newest = 0;
  }

  [[nodiscard]] bool is_active() const {
    return work_ == Work::active && settings_.extent.axes() == 2 && changes_spread_by_contact(settings_);
  }
  void wake_all(const LevelData& data) {
    if (is_active()) {
      active_.wake_all(data.tiling(), useful_threads(data.extent()));
    }
  }

  [[nodiscard]] Fields& fields() {
    return fields_[newest_fields_];
  }

  /// Each has some rows of its own: dense.cpp wants that.
  [[nodiscard]] int useful_threads(Extent extent) const {
    const std::size_t most = std::min(extent.sites() / sites_worth_a_thread + 1,
                                      std::max<std::size_t>(static_cast<std::size_t>(extent.rows()) / 4, 1));
    return static_cast<int>(std::min<std::size_t>(static_cast<std::size_t>(threads_), most));
  }

  int threads_;
  Rows rows_;
  Work work_;
  Level settings_;
  Pyramid pyramid_;
  LevelData full_;               ///< of load(level), or of a pyramid's last level
  LevelData sampled_;            ///< of a pyramid's other ones, in turn
  std::array<Fields, 2> fields_; ///< of a level and of the one before
  std::size_t newest_fields_ = 0;
  ActiveTiles active_;
  std::int64_t changed_ = 0;
};

class OpenMp final : public Backend {
public:
  OpenMp(std::string_view name, const InstructionSet& instruction_set, SweepRow planted = nullptr)
      : name_(name), instruction_set_(instruction_set), planted_(planted) {}

  std::string_view name() const override { return name_; }
  std::string_view description() const override { return "C++, OpenMP threads x SIMD lanes"; }
  std::vector<Device> devices() const override {
    return {cpu_device(fmt::format("OpenMP, {}", instruction_set_.name))};
  }
  int threads(const SessionOptions& options) const override { return thread_count(options.threads); }
  bool has_elastic() const override { return true; }
  /// Displacement there and back; modulus and its inverse where they differ, the target where there is an
  /// observation. Confidences are not read where a tile has one. Rows stay in the cache for all sweeps that
  /// pass together.
  double bytes_per_update(SiteKind kind, int sweeps) const override {
    const std::size_t known = class_of(kind);
    return (8 + 8 + ((known & tile_class::elastic_bit) != 0 ? 4 + 4 : 0) +
            ((known & tile_class::observed_bit) != 0 ? 8 : 0)) /
           static_cast<double>(std::clamp(sweeps, 1, openmp::most_fused));
  }

private:
  std::unique_ptr<ElasticSession> do_open_elastic(std::size_t /*index*/,
                                                  const SessionOptions& options) const override {
    return make_elastic_openmp(thread_count(options.threads), *instruction_set_.elastic_rows);
  }
  std::unique_ptr<Session> do_open(std::size_t /*index*/, const SessionOptions& options) const override {
    return std::make_unique<OpenMpSession>(thread_count(options.threads),
                                           Rows{instruction_set_.row, planted_}, options.work);
  }
  std::optional<Ceilings> do_measure_ceilings(std::size_t /*index*/,
                                              const SessionOptions& options) const override {
    return cpu_ceilings(thread_count(options.threads), instruction_set_.multiply_add);
  }

  std::string_view name_;
  InstructionSet instruction_set_;
  SweepRow planted_;
};

} // namespace

std::vector<InstructionSet> openmp::instruction_sets() {
  std::vector<InstructionSet> all{{"baseline SIMD", 0, baseline::multiply_add, &baseline::elastic_rows}};
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx2") != 0) {
    all.push_back({"AVX2", 1, avx2::multiply_add, &avx2::elastic_rows});
  }
  if (__builtin_cpu_supports("avx512f") != 0 && __builtin_cpu_supports("avx512vl") != 0 &&
      __builtin_cpu_supports("avx512dq") != 0 && __builtin_cpu_supports("avx512bw") != 0) {
    all.push_back({"AVX-512", 2, avx512::multiply_add, &avx512::elastic_rows});
  }
#endif
  return all;
}

std::unique_ptr<Backend> make_openmp() {
  return std::make_unique<OpenMp>("openmp", openmp::instruction_sets().back());
}

std::unique_ptr<Backend> make_openmp_with(std::string_view name, openmp::SweepRow sweep_row,
                                          std::string_view instruction_set) {
  openmp::InstructionSet best = openmp::instruction_sets().back();
  best.name = instruction_set;
  return std::make_unique<OpenMp>(name, best, sweep_row);
}

} // namespace hdmbench
