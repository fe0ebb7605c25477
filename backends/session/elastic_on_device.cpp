#include "backends/session/device_backend.hpp"
#include "backends/session/elastic_level_session.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

namespace hdmbench {

namespace {

/// Numbers of a masked cell of a volume.
constexpr std::size_t matrix_size = 576;

/// Sites that are computed before the host waits, so that no driver takes the work for hung.
constexpr double most_in_flight = 2e8;

/// How the sites of a level are shared out in elastic.comp: invocations of a group, and sites of an
/// invocation, one below the other. A rasterizer on the CPU has one thread a group and pays for each of them;
/// a GPU wants many.
struct ElasticShape {
  int lanes;
  int rows;
};
constexpr ElasticShape elastic_shape(bool is_software) {
  return is_software ? ElasticShape{.lanes = 16, .rows = 16} : ElasticShape{.lanes = 64, .rows = 4};
}
/// Of elastic_volume.h: columns of a work item, too. Loops over many are what a compiler makes SIMD of.
struct VolumeShape {
  int lanes;
  int rows;
  int columns;
};
/// Of elastic_coarse.comp, which has its fields in shared memory on a GPU only.
constexpr ElasticShape elastic_coarse_shape(bool is_software) {
  return is_software ? ElasticShape{.lanes = 8, .rows = 10} : ElasticShape{.lanes = 256, .rows = 1};
}

/// Work groups of elastic.comp for a call, or for the sites of its list.
Extent elastic_groups(const ElasticCall& call, bool by_list, const ElasticShape& shape) {
  const auto groups = [](int items, int together) { return (items + together - 1) / together; };
  if (by_list) {
    const int all = groups(call.parameters.listed, shape.lanes);
    return {std::min(all, ELASTIC_LIST_GROUPS), groups(all, ELASTIC_LIST_GROUPS)};
  }
  const ElasticStep step = call.kernel.step;
  const bool sweeps = step == ElasticStep::relax || step == ElasticStep::residual;
  const bool corrects = step == ElasticStep::interpolate || step == ElasticStep::correct;
  const int columns = shape.lanes * (sweeps ? ELASTIC_COLUMNS : corrects ? 2 : 1);
  return {groups(call.parameters.width, columns), groups(call.parameters.height, shape.rows)};
}

/// So many numbers of each site of a device: a plane of each, or texels of two or four with those of a site
/// beside each other.
class SiteNumbers {
public:
  SiteNumbers(std::int64_t sites, std::size_t numbers, bool has_planes)
      : numbers_(numbers), plane_(has_planes ? static_cast<std::size_t>(sites) : 1),
        stride_(has_planes ? 1 : numbers), values_(numbers * static_cast<std::size_t>(sites)) {}

  /// Of a level; part.first counts from the first site here.
  void lay(std::size_t number, const RingedGrid& grid, const std::vector<float>& values,
           const ElasticLayout::Part& part) {
    lay_out(grid, values, part, values_.data() + number * plane_, stride_);
  }
  float& at(std::size_t number, std::int64_t site) {
    return values_[number * plane_ + static_cast<std::size_t>(site) * stride_];
  }
  [[nodiscard]] std::unique_ptr<Array> uploaded(ComputeDevice& device) const {
    return upload(device, stride_ == 1 ? Kind::words : numbers_ == 2 ? Kind::pairs : Kind::fours, values_);
  }

private:
  std::size_t numbers_;
  std::size_t plane_;
  std::size_t stride_;
  std::vector<float> values_;
};

class ElasticArrays {
public:
  static constexpr bool has_volumes = true;

  explicit ElasticArrays(ComputeDevice& device) : device_(device), programs_(device) {}

  static constexpr int block = 8; ///< three levels of the tree of 2 x 2 squares

  [[nodiscard]] std::int64_t coarse_size() const {
    const DeviceLimits& limits = device_.limits();
    const bool fits =
        limits.shared_bytes >= elastic_slots_on_levels * ELASTIC_SHARED_SITES * bytes_of(Kind::pairs) &&
        limits.group >= elastic_coarse_shape(is_software()).lanes;
    return !fits ? 0 : is_software() ? ELASTIC_COARSE_SITES : ELASTIC_SHARED_SITES;
  }

  void load(const ElasticHierarchy& hierarchy, const ElasticLayout& layout) {
    const Extent sites = layout.levels.front().sites;
    axes_ = sites.axes();
    if (axes_ == 2 && static_cast<std::size_t>(sites.height) > device_.limits().groups_y) {
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
      const std::size_t count = i < elastic_slots ? size : static_cast<std::size_t>(layout.sums_size);
      slots_[i] = device_.allocate(planes() * count, has_planes() ? Kind::words : texel());
      zeros.emplace_back(Fill{.array = slots_[i].get(), .bytes = slots_[i]->bytes(), .beside = true});
    }
    device_.run(zeros);
    axes_ == 3     ? upload_volume(hierarchy)
    : has_planes() ? upload_planes(hierarchy)
                   : upload_texels(hierarchy);
    device_.finish();
  }

  void write(ElasticArray to, const VectorField& values) {
    const ElasticLayout::Part& part = part_of(to);
    std::vector<float> rows = region(part);
    for (std::size_t plane = 0; plane < planes(); ++plane) {
      for_each_site(part, [&](std::size_t site, std::size_t at) {
        for (std::size_t axis = plane; axis < plane + components(); ++axis) {
          rows[floats() * at + axis - plane] = values[axis][site];
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
        for (std::size_t axis = plane; axis < plane + components(); ++axis) {
          values[axis][site] = rows[floats() * at + axis - plane];
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
      if (const auto* const call = std::get_if<ElasticCall>(&piece)) {
        commands.emplace_back(dispatch_of(*call, false));
        if (call->kernel.has_masked && (axes_ == 3 || !has_planes())) {
          commands.emplace_back(dispatch_of(*call, true));
        }
        in_flight +=
            static_cast<double>(call->parameters.width) * call->parameters.height * call->parameters.depth;
      } else {
        commands.emplace_back(dispatch_of(std::get<ElasticCoarse>(piece)));
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
  [[nodiscard]] bool has_planes() const { return device_.limits().has_planes; }
  [[nodiscard]] bool is_software() const { return device_.description().is_software; }
  [[nodiscard]] const ElasticLayout::Part& part_of(ElasticArray array) const {
    return layout_.levels.at(static_cast<std::size_t>(array.level));
  }
  [[nodiscard]] const Array& slot(ElasticArray array) const {
    return *slots_.at(static_cast<std::size_t>(array.slot));
  }
  /// Of an array, and components and floats of a site in each.
  [[nodiscard]] std::size_t planes() const { return has_planes() ? axes_ : 1; }
  [[nodiscard]] std::size_t components() const { return has_planes() ? 1 : axes_; }
  [[nodiscard]] std::size_t floats() const { return has_planes() ? 1 : bytes_of(texel()) / sizeof(float); }
  [[nodiscard]] Kind texel() const { return axes_ == 2 ? Kind::pairs : Kind::fours; }
  /// Zeros from the first site of a level to the last.
  [[nodiscard]] std::vector<float> region(const ElasticLayout::Part& part) const {
    return std::vector<float>(floats() * static_cast<std::size_t>((part.sites.depth - 1) * part.layer +
                                                                  (part.sites.height - 1) * part.pitch +
                                                                  part.sites.width));
  }
  /// Byte of the first site.
  [[nodiscard]] std::size_t offset(const ElasticLayout::Part& part, std::size_t plane) const {
    const auto first = static_cast<std::size_t>(part.first) + plane * static_cast<std::size_t>(layout_.size);
    return first * floats() * sizeof(float);
  }
  /// call(site in reading order, where it is in the region) for every site.
  template <typename Call>
  static void for_each_site(const ElasticLayout::Part& part, const Call& call) {
    for (int z = 0; z < part.sites.depth; ++z) {
      for (int y = 0; y < part.sites.height; ++y) {
        for (int x = 0; x < part.sites.width; ++x) {
          call(part.sites.index(x, y, z), static_cast<std::size_t>(z * part.layer + y * part.pitch + x));
        }
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
    fixed_[ELASTIC_TOUCHED] = upload(device_, Kind::pairs, listed_sites(hierarchy));
    fixed_[ELASTIC_KEPT] = device_.allocate(elastic_slots_on_levels * ELASTIC_COARSE_SITES, Kind::pairs);
  }

  /// Texels of two floats: for each level where its touched sites begin and how many they are, then x and y
  /// of each.
  std::vector<float> listed_sites(const ElasticHierarchy& hierarchy) {
    std::vector<float> texels(2 * hierarchy.levels.size());
    lists_.clear();
    for (const std::vector<TouchedSite>& sites : touched_sites(hierarchy)) {
      const std::size_t number = lists_.size();
      lists_.push_back(
          {static_cast<std::int32_t>(texels.size() / 2), static_cast<std::int32_t>(sites.size())});
      texels[2 * number] = static_cast<float>(lists_.back().first);
      texels[2 * number + 1] = static_cast<float>(lists_.back().count);
      for (const TouchedSite& site : sites) {
        texels.insert(texels.end(), {static_cast<float>(site.x), static_cast<float>(site.y)});
      }
    }
    require_listed(texels.size() / 2);
    return texels;
  }
  static void require_listed(std::size_t sites) {
    constexpr std::size_t most = std::size_t{1} << 24; // whole numbers in a float
    if (sites > most) {
      throw TooLarge(fmt::format("{} sites lie beside conditions, {} may be listed", sites, most));
    }
  }

  void upload_volume(const ElasticHierarchy& hierarchy) {
    const auto numbers = [&](std::int64_t sites, std::size_t count) {
      return SiteNumbers(sites, count, has_planes());
    };
    SiteNumbers moments = numbers(layout_.size - layout_.moments_from(), has_planes() ? 23 : 24);
    SiteNumbers response = numbers(layout_.size, has_planes() ? 6 : 8);
    SiteNumbers more = numbers(layout_.size, 2); // modulus, the number of a matrix or 0
    std::vector<float> matrices;
    std::vector<float> touched;
    lists_.clear();
    for (const ElasticLevel& level : hierarchy.levels) {
      const ElasticLayout::Part& part = layout_.levels[lists_.size()];
      ElasticLayout::Part with_moments = part;
      with_moments.first -= layout_.moments_from();
      for (std::size_t i = 0; i < level.moments.size(); ++i) {
        level.moments.size() == 1 ? more.lay(0, level.grid, level.moments[i], part)
                                  : moments.lay(i, level.grid, level.moments[i], with_moments);
      }
      for (std::size_t i = 0; i < level.response.size(); ++i) {
        response.lay(i, level.grid, level.response[i], part);
      }
      for (int z = 0; z < part.sites.depth; ++z) {
        for (int y = 0; y < part.sites.height; ++y) {
          const auto [first, last] = level.masked.row(y, z);
          for (std::size_t i = first; i < last; ++i) {
            more.at(1, part.first + z * part.layer + y * part.pitch + level.masked.x[i]) =
                static_cast<float>(matrices.size() / matrix_size + i + 1);
          }
        }
      }
      matrices.insert(matrices.end(), level.masked.stiffness.begin(), level.masked.stiffness.end());
      const std::vector<std::array<int, 3>> sites = sites_beside_masked(level);
      lists_.push_back(
          {static_cast<std::int32_t>(touched.size() / 3), static_cast<std::int32_t>(sites.size())});
      for (const std::array<int, 3>& site : sites) {
        touched.insert(touched.end(), site.begin(), site.end());
      }
    }
    require_listed(touched.size() / 3);
    fixed_[ELASTIC_MOMENTS] = moments.uploaded(device_);
    fixed_[ELASTIC_RESPONSE] = response.uploaded(device_);
    fixed_[ELASTIC_MORE] = more.uploaded(device_);
    fixed_[ELASTIC_MATRICES] = upload_threes(matrices);
    fixed_[ELASTIC_INVERSE] = upload_threes(hierarchy.coarsest_inverse);
    fixed_[ELASTIC_TOUCHED] = upload_threes(touched);
  }
  /// Of texels the fourth number is to spare.
  [[nodiscard]] std::unique_ptr<Array> upload_threes(const std::vector<float>& values) {
    if (has_planes()) {
      return upload(device_, Kind::words, values);
    }
    std::vector<float> texels(values.size() / 3 * 4);
    for (std::size_t i = 0; i < values.size(); ++i) {
      texels[i / 3 * 4 + i % 3] = values[i];
    }
    return upload(device_, Kind::fours, texels);
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
      matrices.insert(matrices.end(), level.masked.stiffness.begin(), level.masked.stiffness.end());
    }
    std::vector<TouchedSite> touched;
    std::vector<std::int32_t> row_begin; // of each row in `touched`, and the end of each level
    lists_.clear();
    for (const std::vector<TouchedSite>& sites : touched_sites(hierarchy)) {
      const int rows = hierarchy.levels[lists_.size()].grid.sites.height;
      lists_.push_back({.first = static_cast<std::int32_t>(row_begin.size())});
      for (int y = 0; y <= rows; ++y) {
        const auto begin = std::ranges::lower_bound(sites, y, {}, &TouchedSite::y);
        row_begin.push_back(static_cast<std::int32_t>(touched.size()) +
                            static_cast<std::int32_t>(begin - sites.begin()));
      }
      touched.insert(touched.end(), sites.begin(), sites.end());
    }
    fixed_[ELASTIC_MOMENTS] = upload(device_, Kind::words, moments);
    fixed_[ELASTIC_RESPONSE] = upload(device_, Kind::words, response);
    fixed_[ELASTIC_MATRICES] = upload(device_, Kind::words, matrices);
    fixed_[ELASTIC_INVERSE] = upload(device_, Kind::words, hierarchy.coarsest_inverse);
    fixed_[ELASTIC_TOUCHED] = upload(device_, Kind::words, touched);
    fixed_[ELASTIC_MORE] = upload(device_, Kind::words, row_begin);
  }

  [[nodiscard]] Dispatch dispatch_on(const Program& program) const {
    Dispatch dispatch{.program = &program};
    std::ranges::transform(fixed_, dispatch.arrays.begin(), [](const auto& array) { return array.get(); });
    return dispatch;
  }

  [[nodiscard]] VolumeShape volume_shape() const {
    const ElasticShape shape = elastic_shape(is_software());
    const int lanes = has_planes() ? shapes_for(device_).sweep.invocations() : shape.lanes;
    const int columns = !is_software() ? 1 : has_planes() && lanes == 1 ? 64 : ELASTIC_COLUMNS;
    return {.lanes = lanes, .rows = shape.rows, .columns = columns};
  }

  Dispatch volume_dispatch(ElasticCall call, bool by_list) {
    const ElasticKernel& kernel = call.kernel;
    const VolumeShape shape = volume_shape();
    // In the order of elastic_volume.comp's constants.
    Dispatch dispatch = dispatch_on(programs_({.kernel = Kernel::elastic_volume,
                                               .constants = {{"STEP", static_cast<std::int32_t>(kernel.step)},
                                                             {"HAS_LOAD", kernel.has_load ? 1 : 0},
                                                             {"IS_IMAGE", kernel.is_image ? 1 : 0},
                                                             {"BY_LIST", by_list ? 1 : 0},
                                                             {"LANES", shape.lanes},
                                                             {"ROWS", shape.rows},
                                                             {"COLUMNS", shape.columns}}}));
    const auto groups = [](int items, int together) { return (items + together - 1) / together; };
    const ElasticParameters& p = call.parameters;
    const int items = by_list ? lists_.at(static_cast<std::size_t>(call.from.level)).count
                              : groups(p.width, shape.columns) * p.height * groups(p.depth, shape.rows);
    const int all = groups(items, shape.lanes);
    dispatch.groups = {std::min(all, ELASTIC_LIST_GROUPS), groups(all, ELASTIC_LIST_GROUPS)};
    bind(dispatch, call);
    return dispatch;
  }

  /// The arrays of a call, and what is told.
  void bind(Dispatch& dispatch, ElasticCall& call) const {
    dispatch.arrays[ELASTIC_FROM] = &slot(call.from);
    dispatch.arrays[ELASTIC_SECOND] = &slot(call.second);
    dispatch.arrays[ELASTIC_STORED] = &slot(call.to);
    const List& list = lists_.at(static_cast<std::size_t>(call.from.level));
    call.parameters.listed_first = list.first;
    call.parameters.listed = list.count;
    dispatch.tell(call.parameters);
    if (axes_ == 2) {
      dispatch.word_count = ElasticParameters::words_of_image;
    }
  }

  Dispatch dispatch_of(ElasticCall call, bool by_list) {
    if (axes_ == 3) {
      return volume_dispatch(call, by_list);
    }
    const ElasticKernel& kernel = call.kernel;
    const ElasticShape shape = elastic_shape(is_software());
    // In the order of elastic.comp's constants; HAS_MASKED is for elastic.cl, which branches by it.
    Dispatch dispatch = dispatch_on(programs_(
        {.kernel = Kernel::elastic,
         .constants = {{"STEP", static_cast<std::int32_t>(kernel.step)},
                       {"HAS_LOAD", kernel.has_load ? 1 : 0},
                       {"IS_IMAGE", kernel.is_image ? 1 : 0},
                       {"BY_LIST", by_list ? 1 : 0},
                       {"LANES", has_planes() ? shapes_for(device_).sweep.invocations() : shape.lanes},
                       {"ROWS", shape.rows},
                       {"HAS_MASKED", has_planes() && kernel.has_masked ? 1 : 0}}}));
    bind(dispatch, call);
    dispatch.groups = has_planes() ? Extent{1, call.parameters.height} : elastic_groups(call, by_list, shape);
    return dispatch;
  }

  Dispatch dispatch_of(const ElasticCoarse& coarse) {
    const ElasticShape shape = elastic_coarse_shape(is_software());
    Dispatch dispatch = dispatch_on(programs_(
        {.kernel = Kernel::elastic_coarse,
         .constants = {{"LANES", shape.lanes}, {"ROWS", shape.rows}, {"IN_SHARED", is_software() ? 0 : 1}}}));
    for (std::size_t i = 0; i < elastic_slots_on_levels; ++i) {
      dispatch.arrays[ELASTIC_FROM + i] = slots_[i].get();
      dispatch.arrays[ELASTIC_STORED + i] = slots_[i].get();
    }
    dispatch.tell(coarse);
    return dispatch;
  }

  /// Of the touched sites of a level: where it begins in the list of sites, or, of planes, in that of rows.
  struct List {
    std::int32_t first = 0;
    std::int32_t count = 0;
  };

  ComputeDevice& device_;
  Programs programs_;
  ElasticLayout layout_;
  std::size_t axes_ = 2;
  std::array<std::unique_ptr<Array>, elastic_slots + 2> slots_; ///< components of all levels, and sums
  std::array<std::unique_ptr<Array>, binding::count> fixed_;    ///< what does not change, by its binding
  std::vector<List> lists_;                                     ///< per level
};

} // namespace

std::unique_ptr<ElasticSession> make_elastic_session(std::string name,
                                                     std::unique_ptr<ComputeDevice> device) {
  return std::make_unique<ElasticLevelSession<ComputeDevice, ElasticArrays>>(std::move(name),
                                                                             std::move(device));
}

} // namespace hdmbench
