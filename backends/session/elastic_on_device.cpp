#include "backends/session/elastic_on_device.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <optional>
#include <utility>
#include <vector>

namespace hdmbench {

namespace {

/// Sites that are computed before the host waits, so that no driver takes the work for hung.
constexpr double most_in_flight = 2e8;

/// Of elastic.cl: a site beside masked cells, and the numbers of the matrices of its cells in reading order.
struct TouchedSite {
  std::int32_t x = 0;
  std::array<std::int32_t, 4> masked{-1, -1, -1, -1};
};

/// Those of all levels, row by row, and where a row begins.
struct TouchedSites {
  explicit TouchedSites(const ElasticHierarchy& hierarchy) {
    std::int32_t first_matrix = 0;
    for (const ElasticLevel& level : hierarchy.levels) {
      first_row.push_back(static_cast<std::int32_t>(row_begin.size()));
      for (int y = 0; y < level.grid.sites.height; ++y) {
        row_begin.push_back(static_cast<std::int32_t>(sites.size()));
        std::map<int, TouchedSite> row;
        for (const int below : {0, 1}) {
          const auto [first, last] = level.masked.row(y - 1 + below);
          for (std::size_t i = first; i < last; ++i) {
            const int x = level.masked.cells[i].x;
            const std::int32_t number = first_matrix + static_cast<std::int32_t>(i);
            row[x].masked.at(static_cast<std::size_t>(2 * below + 1)) = number;
            row[x + 1].masked.at(static_cast<std::size_t>(2 * below)) = number;
          }
        }
        for (auto& [x, site] : row) {
          site.x = x;
          sites.push_back(site);
        }
      }
      row_begin.push_back(static_cast<std::int32_t>(sites.size()));
      first_matrix += static_cast<std::int32_t>(level.masked.cells.size());
    }
  }

  std::vector<TouchedSite> sites;
  std::vector<std::int32_t> row_begin;
  std::vector<std::int32_t> first_row; ///< per level, in row_begin
};

class ElasticArrays {
public:
  explicit ElasticArrays(ComputeDevice& device) : device_(device), programs_(device) {}

  [[nodiscard]] bool has_planes() const { return device_.limits().has_planes; }
  [[nodiscard]] std::int64_t coarse_size() const {
    const DeviceLimits& limits = device_.limits();
    const bool fits =
        limits.shared_bytes >= elastic_slots_on_levels * ELASTIC_SHARED_SITES * bytes_of(Kind::pairs) &&
        limits.group >= elastic_coarse_shape(is_software()).lanes;
    return fits ? elastic_coarse_size(is_software()) : 0;
  }

  void load(const ElasticHierarchy& hierarchy, const ElasticLayout& layout) {
    const Extent sites = layout.levels.front().sites;
    if (static_cast<std::size_t>(sites.height) > device_.limits().groups_y) {
      throw TooLarge(fmt::format(
          "{}: {} x {} sites need {} work groups in y for the elastic energy, the device has {}",
          device_.description().name, sites.width, sites.height, sites.height, device_.limits().groups_y));
    }
    layout_ = layout;
    fixed_ = {}; // before the new ones, so that both need not fit
    slots_ = {};
    const auto size = static_cast<std::size_t>(layout.size);
    Commands zeros;
    for (std::size_t i = 0; i < slots_.size(); ++i) {
      const std::size_t pairs = i < elastic_slots ? size : static_cast<std::size_t>(layout.sums_size);
      slots_[i] =
          device_.allocate(has_planes() ? 2 * pairs : pairs, has_planes() ? Kind::words : Kind::pairs);
      zeros.emplace_back(Fill{.array = slots_[i].get(), .bytes = slots_[i]->bytes(), .beside = true});
    }
    device_.run(zeros);
    has_planes() ? upload_planes(hierarchy) : upload_texels(hierarchy);
    device_.finish();
  }

  void write(ElasticArray to, const VectorField& values) {
    const ElasticLayout::Part& part = part_of(to);
    std::vector<float> rows = region(part);
    for (std::size_t plane = 0; plane < planes(); ++plane) {
      for_each_site(part, [&](std::size_t site, std::size_t at) {
        if (has_planes()) {
          rows[at] = plane == 0 ? values.x[site] : values.y[site];
        } else {
          rows[2 * at] = values.x[site];
          rows[2 * at + 1] = values.y[site];
        }
      });
      device_.write(slot(to), offset(part, plane), std::as_bytes(std::span(rows)));
    }
  }

  void read(ElasticArray from, VectorField& values) {
    const ElasticLayout::Part& part = part_of(from);
    std::vector<float> rows = region(part);
    for (std::size_t plane = 0; plane < planes(); ++plane) {
      device_.read(slot(from), offset(part, plane), std::as_writable_bytes(std::span(rows)));
      for_each_site(part, [&](std::size_t site, std::size_t at) {
        if (has_planes()) {
          (plane == 0 ? values.x : values.y)[site] = rows[at];
        } else {
          values.x[site] = rows[2 * at];
          values.y[site] = rows[2 * at + 1];
        }
      });
    }
  }

  float read_sum(ElasticArray from) {
    std::array<float, 1> sum{};
    device_.read(slot(from), 0, std::as_writable_bytes(std::span(sum)));
    return sum.front();
  }

  void run(std::span<const ElasticWork> work) {
    Commands commands;
    double in_flight = 0.0;
    for (const ElasticWork& piece : work) {
      std::visit([&](const auto& one) { commands.emplace_back(dispatch_of(one)); }, piece);
      if (const auto* const call = std::get_if<ElasticCall>(&piece)) {
        in_flight += static_cast<double>(call->parameters.width) * call->parameters.height;
      }
      if (in_flight > most_in_flight) {
        device_.run(std::exchange(commands, {}));
        device_.finish();
        in_flight = 0.0;
      }
    }
    device_.run(commands);
  }

private:
  [[nodiscard]] bool is_software() const { return device_.description().is_software; }
  [[nodiscard]] const ElasticLayout::Part& part_of(ElasticArray array) const {
    return layout_.levels.at(static_cast<std::size_t>(array.level));
  }
  [[nodiscard]] const Array& slot(ElasticArray array) const {
    return *slots_.at(static_cast<std::size_t>(array.slot));
  }
  /// Of an array, and floats of a site in each.
  [[nodiscard]] std::size_t planes() const { return has_planes() ? 2 : 1; }
  [[nodiscard]] std::size_t floats() const { return has_planes() ? 1 : 2; }
  /// Zeros from the first site of a level to the last.
  [[nodiscard]] std::vector<float> region(const ElasticLayout::Part& part) const {
    return std::vector<float>(
        floats() * static_cast<std::size_t>((part.sites.height - 1) * part.pitch + part.sites.width));
  }
  /// Byte of the first site.
  [[nodiscard]] std::size_t offset(const ElasticLayout::Part& part, std::size_t plane) const {
    const auto first = static_cast<std::size_t>(part.first) + plane * static_cast<std::size_t>(layout_.size);
    return first * floats() * sizeof(float);
  }
  /// call(site in reading order, where it is in the region) for every site.
  template <typename Call>
  static void for_each_site(const ElasticLayout::Part& part, const Call& call) {
    for (int y = 0; y < part.sites.height; ++y) {
      for (int x = 0; x < part.sites.width; ++x) {
        call(part.sites.index(x, y), static_cast<std::size_t>(y * part.pitch + x));
      }
    }
  }

  void upload_texels(const ElasticHierarchy& hierarchy) {
    ElasticTexels texels(static_cast<std::size_t>(layout_.size));
    for (std::size_t level = 0; level < hierarchy.levels.size(); ++level) {
      texels.add(hierarchy.levels[level], layout_.levels[level]);
    }
    fixed_[ELASTIC_MOMENTS] = upload(device_, Kind::fours, texels.moments);
    fixed_[ELASTIC_MORE] = upload(device_, Kind::fours, texels.more);
    fixed_[ELASTIC_RESPONSE] = upload(device_, Kind::fours, texels.response);
    fixed_[ELASTIC_MATRICES] = upload(device_, Kind::fours, elastic_matrices(hierarchy));
    fixed_[ELASTIC_INVERSE] = upload(device_, Kind::pairs, hierarchy.coarsest_inverse);
    fixed_[ELASTIC_TOUCHED] = upload(device_, Kind::pairs, ElasticTouched(hierarchy).texels);
    fixed_[ELASTIC_KEPT] = device_.allocate(elastic_slots_on_levels * ELASTIC_COARSE_SITES, Kind::pairs);
  }

  void upload_planes(const ElasticHierarchy& hierarchy) {
    const auto size = static_cast<std::size_t>(layout_.size);
    std::vector<float> moments(6 * size);
    std::vector<float> response(3 * size);
    std::vector<float> matrices;
    for (std::size_t number = 0; number < hierarchy.levels.size(); ++number) {
      const ElasticLevel& level = hierarchy.levels[number];
      const auto lay = [&](const auto& values, std::vector<float>& to) {
        for (std::size_t i = 0; i < values.size(); ++i) {
          lay_out(level.grid, values[i], layout_.levels[number], to.data() + i * size, 1);
        }
      };
      lay(level.moments, moments);
      lay(level.response, response);
      for (const MaskedCell& cell : level.masked.cells) {
        matrices.insert(matrices.end(), cell.stiffness.begin(), cell.stiffness.end());
      }
    }
    TouchedSites touched(hierarchy);
    first_row_ = std::move(touched.first_row);
    fixed_[ELASTIC_MOMENTS] = upload(device_, Kind::words, moments);
    fixed_[ELASTIC_RESPONSE] = upload(device_, Kind::words, response);
    fixed_[ELASTIC_MATRICES] = upload(device_, Kind::words, matrices);
    fixed_[ELASTIC_INVERSE] = upload(device_, Kind::words, hierarchy.coarsest_inverse);
    fixed_[ELASTIC_TOUCHED] = upload(device_, Kind::words, touched.sites);
    fixed_[ELASTIC_MORE] = upload(device_, Kind::words, touched.row_begin);
  }

  [[nodiscard]] Dispatch dispatch_on(const Program& program) const {
    Dispatch dispatch{.program = &program};
    std::ranges::transform(fixed_, dispatch.arrays.begin(), [](const auto& array) { return array.get(); });
    return dispatch;
  }

  Dispatch dispatch_of(const ElasticCall& call) {
    const ElasticKernel& kernel = call.kernel;
    const ElasticShape shape = elastic_shape(is_software());
    // In the order of elastic.comp's constants; HAS_MASKED is for elastic.cl, which branches by it.
    ProgramKind kind{
        .kernel = Kernel::elastic,
        .constants = {{"STEP", static_cast<std::int32_t>(kernel.step)},
                      {"HAS_LOAD", kernel.has_load ? 1 : 0},
                      {"IS_IMAGE", kernel.is_image ? 1 : 0},
                      {"BY_LIST", kernel.masks == ElasticMasks::by_list ? 1 : 0},
                      {"LANES", has_planes() ? device_.shapes().front().invocations() : shape.lanes},
                      {"ROWS", shape.rows},
                      {"HAS_MASKED", kernel.masks == ElasticMasks::none ? 0 : 1}}};
    Dispatch dispatch = dispatch_on(programs_(kind));
    dispatch.arrays[ELASTIC_FROM] = &slot(call.from);
    dispatch.arrays[ELASTIC_SECOND] = &slot(call.second);
    dispatch.arrays[ELASTIC_STORED] = &slot(call.to);
    Told told{.parameters = call.parameters, .plane = static_cast<std::int32_t>(layout_.size)};
    dispatch.groups = elastic_groups(call, shape);
    if (has_planes()) {
      told.parameters.listed_first = first_row_.at(static_cast<std::size_t>(call.from.level));
      dispatch.groups = {1, call.parameters.height};
    }
    dispatch.tell(told);
    return dispatch;
  }

  Dispatch dispatch_of(const ElasticCoarse& coarse) {
    const ElasticShape shape = elastic_coarse_shape(is_software());
    Dispatch dispatch =
        dispatch_on(programs_({.kernel = Kernel::elastic_coarse,
                               .constants = {{"LANES", shape.lanes},
                                             {"ROWS", shape.rows},
                                             {"IN_SHARED", elastic_in_shared(is_software())}}}));
    for (std::size_t i = 0; i < elastic_slots_on_levels; ++i) {
      dispatch.arrays[ELASTIC_FROM + i] = slots_[i].get();
      dispatch.arrays[ELASTIC_STORED + i] = slots_[i].get();
    }
    dispatch.tell(coarse);
    return dispatch;
  }

  /// Words of elastic.comp and elastic.cl.
  struct Told {
    ElasticParameters parameters;
    std::int32_t plane = 0; ///< floats from a plane to the next
  };

  ComputeDevice& device_;
  Programs programs_;
  ElasticLayout layout_;
  std::array<std::unique_ptr<Array>, elastic_slots + 2> slots_; ///< x and y of all levels, and sums
  std::array<std::unique_ptr<Array>, binding::count> fixed_;    ///< what does not change, by its binding
  std::vector<std::int32_t> first_row_;                         ///< TouchedSites, where arrays are planes
};

class ElasticOnDevice final : public ElasticDevice {
public:
  explicit ElasticOnDevice(std::unique_ptr<ComputeDevice> device) : arrays_(std::move(device)) {
    arrays_([&](const ElasticArrays& arrays) {
      has_lists_ = !arrays.has_planes();
      coarse_size_ = arrays.coarse_size();
    });
  }

  bool has_lists() const override { return has_lists_; }
  std::int64_t coarse_size() const override { return coarse_size_; }
  void load(const ElasticHierarchy& hierarchy, const ElasticLayout& layout) override {
    arrays_([&](ElasticArrays& arrays) { arrays.load(hierarchy, layout); });
  }
  void write(ElasticArray to, const VectorField& values) override {
    arrays_([&](ElasticArrays& arrays) { arrays.write(to, values); });
  }
  void read(ElasticArray from, VectorField& values) override {
    arrays_([&](ElasticArrays& arrays) { arrays.read(from, values); });
  }
  float read_sum(ElasticArray from) override {
    return arrays_([&](ElasticArrays& arrays) { return arrays.read_sum(from); });
  }
  void run(std::span<const ElasticWork> work) override {
    arrays_([&](ElasticArrays& arrays) { arrays.run(work); });
  }

private:
  OnDevice<ElasticArrays> arrays_;
  bool has_lists_ = false;
  std::int64_t coarse_size_ = 0;
};

} // namespace

std::unique_ptr<ElasticDevice> make_elastic_on_device(std::unique_ptr<ComputeDevice> device) {
  return std::make_unique<ElasticOnDevice>(std::move(device));
}

} // namespace hdmbench
