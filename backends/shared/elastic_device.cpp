#include "backends/shared/elastic_device.hpp"

#include "backends/backend.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <span>
#include <utility>

namespace hdmbench {

namespace {

constexpr Extent blocks_of(Extent sites, int side) {
  return {(sites.width + side - 1) / side, (sites.height + side - 1) / side};
}

/// Every step writes an array that is to spare, which then takes the field's place.
class DeviceSession final : public ElasticSession {
public:
  DeviceSession(std::string name, std::unique_ptr<ElasticDevice> device)
      : name_(std::move(name)), device_(std::move(device)) {}

private:
  template <typename Call>
  auto on_device(const Call& call) const {
    try {
      return call();
    } catch (const TooLarge& error) {
      throw TooLarge(fmt::format("{}: {}", name_, error.what()));
    } catch (const DeviceError& error) {
      throw DeviceError(fmt::format("{}: {}", name_, error.what()));
    }
  }

public:
  void load(const ElasticHierarchy& hierarchy) override {
    on_device([&] {
      layout_ = ElasticLayout(hierarchy, device_->block());
      device_->load(hierarchy, layout_);
    });
    hierarchy_ = &hierarchy;
    slots_.assign(hierarchy.levels.size(), initial_slots);
    calls_.clear();
    touched_ = device_->has_lists() ? ElasticTouched(hierarchy) : ElasticTouched();
    coarse_ = 1;
    while (coarse_ < levels() && coarse_size() > device_->coarse_size()) {
      ++coarse_;
    }
  }
  void write(int level, ElasticField field, const VectorField& values) override {
    on_device([&] {
      run_all();
      device_->write(array(level, field), values);
    });
  }
  void read(int level, ElasticField field, VectorField& values) const override {
    values = VectorField(part(array(level, field)).sites);
    on_device([&] {
      run_all();
      device_->read(array(level, field), values);
    });
  }

  void relax(int level, ElasticField field) override {
    const bool has_load = field == ElasticField::correction;
    replace(level, field, {.step = ElasticStep::relax, .has_load = has_load, .masks = masks(level)},
            array(level, field), array(level, has_load ? ElasticField::load : field));
  }
  void relax_from_zero(int level) override {
    const ElasticArray load = array(level, ElasticField::load);
    replace(level, ElasticField::correction, {.step = ElasticStep::relax_from_zero}, load, load);
  }
  void forces(ElasticField of, ElasticField to) override {
    replace(0, to, {.step = ElasticStep::residual, .is_image = true, .masks = masks(0)}, array(0, of),
            array(0, of));
  }
  void restrict_residual(int level, ElasticField of) override {
    const bool has_load = of == ElasticField::correction;
    const ElasticArray residual = spare(level);
    run({.step = ElasticStep::residual, .has_load = has_load, .is_image = level == 0, .masks = masks(level)},
        array(level, of), array(level, has_load ? ElasticField::load : of), residual);
    run({.step = ElasticStep::restrict_sites}, residual, residual, array(level + 1, ElasticField::load));
  }
  void restrict_load(int level) override {
    const ElasticArray load = array(level, ElasticField::load);
    run({.step = ElasticStep::restrict_sites, .is_image = level == 0}, load, load,
        array(level + 1, ElasticField::load));
  }
  void interpolate(int level) override {
    replace(level, ElasticField::correction, {.step = ElasticStep::interpolate, .is_image = level == 0},
            array(level, ElasticField::correction), array(level + 1, ElasticField::correction));
  }
  void correct(int level, ElasticField field) override {
    replace(level, field, {.step = ElasticStep::correct, .is_image = level == 0}, array(level, field),
            array(level + 1, ElasticField::correction));
  }
  void solve_coarsest() override {
    const int level = static_cast<int>(slots_.size()) - 1;
    const ElasticArray load = array(level, ElasticField::load);
    replace(level, ElasticField::correction, {.step = ElasticStep::solve}, load, load);
  }
  void advance(ElasticField to, ElasticField value, float factor, ElasticField direction) override {
    replace(0, to, {.step = ElasticStep::advance}, array(0, value), array(0, direction), factor);
  }

  float dot(ElasticField first, ElasticField second) const override {
    ElasticArray sums{.slot = elastic_sums};
    Extent extent = layout_.levels.front().sites;
    Extent blocks = layout_.sums.sites;
    run({.step = ElasticStep::products}, array(0, first), array(0, second), sums, extent, blocks);
    while (blocks.sites() > 1) {
      extent = std::exchange(blocks, blocks_of(blocks, device_->block()));
      const ElasticArray from =
          std::exchange(sums, {.slot = sums.slot == elastic_sums ? elastic_sums + 1 : elastic_sums});
      run({.step = ElasticStep::squares}, from, from, sums, extent, blocks);
    }
    return on_device([&] {
      run_all();
      return device_->read_sum(sums);
    });
  }

private:
  /// The slot of each field, and the one to spare.
  using Slots = std::array<int, elastic_fields + 1>;
  static constexpr std::size_t spare_slot = elastic_fields;
  static constexpr Slots initial_slots{3, 0, 1, 4, 5, 2};

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
  [[nodiscard]] ElasticMasks masks(int level) const {
    return hierarchy_->levels[static_cast<std::size_t>(level)].masked.cells.empty() ? ElasticMasks::none
                                                                                    : ElasticMasks::anyhow;
  }

  /// field = what `kernel` makes of the arrays.
  void replace(int level, ElasticField field, const ElasticKernel& kernel, ElasticArray from,
               ElasticArray second, float factor = 0.0F) {
    run(kernel, from, second, spare(level), factor);
    Slots& here = slots_[static_cast<std::size_t>(level)];
    std::swap(here[static_cast<std::size_t>(field)], here[spare_slot]);
  }
  void run(const ElasticKernel& kernel, ElasticArray from, ElasticArray second, ElasticArray to,
           float factor = 0.0F) const {
    run(kernel, from, second, to, part(from).sites, part(to).sites, factor);
  }
  void run(const ElasticKernel& kernel, ElasticArray from, ElasticArray second, ElasticArray to,
           Extent from_sites, Extent sites, float factor = 0.0F) const {
    const auto whole = [](std::int64_t number) { return static_cast<std::int32_t>(number); };
    const ElasticParameters parameters{.width = sites.width,
                                       .height = sites.height,
                                       .first = whole(part(to).first),
                                       .pitch = whole(part(to).pitch),
                                       .from_first = whole(part(from).first),
                                       .from_pitch = whole(part(from).pitch),
                                       .from_width = from_sites.width,
                                       .from_height = from_sites.height,
                                       .second_first = whole(part(second).first),
                                       .second_pitch = whole(part(second).pitch),
                                       .nu = hierarchy_->ratio.nu,
                                       .shear = hierarchy_->ratio.shear,
                                       .factor = factor};
    calls_.push_back({kernel, from, second, to, parameters});
    constexpr std::size_t most = 1024;
    if (calls_.size() == most) {
      on_device([&] { run_all(); });
    }
  }

  /// Hands over what has been asked for, steps on the coarsest levels together.
  void run_all() const {
    const std::vector<ElasticCall> calls = std::exchange(calls_, {});
    std::vector<ElasticWork> work;
    for (auto call = calls.begin(); call != calls.end();) {
      auto end = call;
      while (end != calls.end() && is_coarse(*end) && end - call < ELASTIC_COARSE_STEPS) {
        ++end;
      }
      constexpr int worth_it = 3;
      if (end - call >= worth_it) {
        work.emplace_back(together({call, end}));
        call = end;
      } else {
        add_alone(*call++, work);
      }
    }
    device_->run(work);
  }
  void add_alone(ElasticCall call, std::vector<ElasticWork>& work) const {
    const bool by_list = call.kernel.masks == ElasticMasks::anyhow && device_->has_lists();
    if (by_list) {
      call.kernel.masks = ElasticMasks::none;
    }
    work.emplace_back(call);
    if (by_list) {
      call.kernel.masks = ElasticMasks::by_list;
      call.parameters.listed_first = touched_.first(call.from.level);
      call.parameters.listed = touched_.count(call.from.level);
      work.emplace_back(call);
    }
  }

  [[nodiscard]] bool is_coarse(const ElasticCall& call) const {
    return call.from.level >= coarse_ && call.kernel.step <= ElasticStep::solve;
  }
  /// Of the arrays of levels from coarse_ on.
  [[nodiscard]] std::int64_t coarse_size() const { return layout_.size - coarse_base(); }
  [[nodiscard]] std::int64_t coarse_base() const {
    const ElasticLayout::Part& finest = layout_.levels[static_cast<std::size_t>(coarse_)];
    return finest.first - ElasticLayout::alone(finest.sites).first;
  }
  [[nodiscard]] ElasticCoarse together(std::span<const ElasticCall> calls) const {
    const ElasticLayout::Part& finest = layout_.levels[static_cast<std::size_t>(coarse_)];
    ElasticCoarse coarse{.base = static_cast<std::int32_t>(coarse_base()),
                         .size = static_cast<std::int32_t>(coarse_size()),
                         .finest = coarse_,
                         .width = finest.sites.width,
                         .height = finest.sites.height,
                         .steps = static_cast<std::int32_t>(calls.size()),
                         .nu = hierarchy_->ratio.nu,
                         .shear = hierarchy_->ratio.shear};
    std::ranges::transform(calls, coarse.codes.begin(), [&](const ElasticCall& call) {
      return static_cast<std::int32_t>(call.kernel.step) | call.from.slot << 4 | call.second.slot << 6 |
             call.to.slot << 8 | (call.from.level - coarse_) << 10;
    });
    return coarse;
  }

  std::string name_;
  std::unique_ptr<ElasticDevice> device_;
  const ElasticHierarchy* hierarchy_ = nullptr;
  ElasticLayout layout_;
  std::vector<Slots> slots_; ///< per level
  ElasticTouched touched_;
  int coarse_ = 1;                         ///< the first of the levels that are computed together
  mutable std::vector<ElasticCall> calls_; ///< not handed over yet
};

} // namespace

ElasticLayout::ElasticLayout(const ElasticHierarchy& hierarchy, int block) {
  for (const ElasticLevel& level : hierarchy.levels) {
    levels.push_back(alone(level.grid.sites));
    levels.back().first += size;
    size += static_cast<std::int64_t>(padded(level.grid.sites).sites());
  }
  const Extent blocks = blocks_of(levels.front().sites, block);
  sums = {.sites = blocks, .first = 0, .pitch = blocks.width};
  sums_size = static_cast<std::int64_t>(blocks.sites());
}

ElasticLayout::Part ElasticLayout::alone(Extent sites) {
  const std::int64_t pitch = padded(sites).width;
  return {.sites = sites, .first = pitch + 1, .pitch = pitch};
}

void lay_out(const RingedGrid& grid, const std::vector<float>& values, const ElasticLayout::Part& part,
             float* to, std::size_t stride) {
  for (int y = 0; y < grid.sites.height; ++y) {
    float* at = to + static_cast<std::size_t>(part.first + y * part.pitch) * stride;
    const float* const row = values.data() + grid.index(0, y);
    for (int x = 0; x < grid.sites.width; ++x, at += stride) {
      *at = row[x];
    }
  }
}

ElasticTexels::ElasticTexels(std::size_t size) : moments(4 * size), more(4 * size), response(4 * size) {}

void ElasticTexels::add(const ElasticLevel& level, const ElasticLayout::Part& part) {
  for (std::size_t i = 0; i < 4; ++i) {
    lay_out(level.grid, level.moments[i], part, moments.data() + i, 4);
  }
  for (std::size_t i = 0; i < 2; ++i) {
    lay_out(level.grid, level.moments[4 + i], part, more.data() + i, 4);
  }
  for (std::size_t i = 0; i < 3; ++i) {
    lay_out(level.grid, level.response[i], part, response.data() + i, 4);
  }
  for (int y = 0; y < level.grid.sites.height; ++y) {
    const auto [first, last] = level.masked.row(y);
    for (std::size_t i = first; i < last; ++i) {
      const std::int64_t at = part.first + y * part.pitch + level.masked.cells[i].x;
      more[4 * static_cast<std::size_t>(at) + 2] = static_cast<float>(matrices + i + 1);
    }
  }
  matrices += level.masked.cells.size();
}

std::vector<float> elastic_matrices(const ElasticHierarchy& hierarchy) {
  std::vector<float> texels;
  for (const ElasticLevel& level : hierarchy.levels) {
    for (const MaskedCell& cell : level.masked.cells) {
      for (std::size_t corner = 0; corner < 4; ++corner) {
        for (std::size_t column = 0; column < 8; ++column) {
          texels.push_back(cell.stiffness[8 * column + 2 * corner]);
          texels.push_back(cell.stiffness[8 * column + 2 * corner + 1]);
        }
      }
    }
  }
  constexpr std::size_t row = 4 * elastic_matrix_texels * elastic_matrices_across;
  texels.resize((texels.size() / row + 1) * row);
  return texels;
}

ElasticTouched::ElasticTouched(const ElasticHierarchy& hierarchy) : texels(2 * hierarchy.levels.size()) {
  for (std::size_t number = 0; number < hierarchy.levels.size(); ++number) {
    const ElasticLevel& level = hierarchy.levels[number];
    const std::size_t begin = texels.size();
    for (int y = 0; y < level.grid.sites.height; ++y) {
      std::set<int> columns;
      for (const int row : {y - 1, y}) {
        const auto [first, last] = level.masked.row(row);
        for (std::size_t i = first; i < last; ++i) {
          columns.insert({level.masked.cells[i].x, level.masked.cells[i].x + 1});
        }
      }
      for (const int x : columns) {
        texels.push_back(static_cast<float>(x));
        texels.push_back(static_cast<float>(y));
      }
    }
    texels[2 * number] = static_cast<float>(begin / 2);
    texels[2 * number + 1] = static_cast<float>((texels.size() - begin) / 2);
  }
  constexpr std::size_t most = std::size_t{1} << 24; // whole numbers in a float
  if (texels.size() / 2 > most) {
    throw TooLarge(fmt::format("{} sites lie beside conditions, {} may be listed", texels.size() / 2, most));
  }
}

std::unique_ptr<ElasticSession> make_elastic_session(std::string name,
                                                     std::unique_ptr<ElasticDevice> device) {
  return std::make_unique<DeviceSession>(std::move(name), std::move(device));
}

Extent elastic_groups(const ElasticCall& call, const ElasticShape& shape) {
  const auto groups = [](int items, int together) { return (items + together - 1) / together; };
  if (call.kernel.masks == ElasticMasks::by_list) {
    const int all = groups(call.parameters.listed, shape.lanes);
    return {std::min(all, ELASTIC_LIST_GROUPS), groups(all, ELASTIC_LIST_GROUPS)};
  }
  const ElasticStep step = call.kernel.step;
  const bool sweeps = step == ElasticStep::relax || step == ElasticStep::residual;
  const bool corrects = step == ElasticStep::interpolate || step == ElasticStep::correct;
  const int columns = shape.lanes * (sweeps ? ELASTIC_COLUMNS : corrects ? 2 : 1);
  return {groups(call.parameters.width, columns), groups(call.parameters.height, shape.rows)};
}

std::string elastic_definitions(const ElasticKernel& kernel) {
  return fmt::format("#define STEP {}\n#define HAS_LOAD {}\n#define IS_IMAGE {}\n#define HAS_MASKED "
                     "{}\n#define BY_LIST {}\n",
                     static_cast<int>(kernel.step), kernel.has_load ? 1 : 0, kernel.is_image ? 1 : 0,
                     kernel.masks == ElasticMasks::none ? 0 : 1,
                     kernel.masks == ElasticMasks::by_list ? 1 : 0);
}

} // namespace hdmbench
