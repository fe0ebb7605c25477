#include "backends/session/device_backend.hpp"
#include "backends/session/elastic_level_session.hpp"
#include "backends/session/laws_on_device.hpp"
#include "backends/session/level_arrays.hpp"
#include "backends/session/part_rows.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <functional>
#include <iterator>
#include <map>
#include <set>
#include <utility>
#include <vector>

namespace hdmbench {

namespace {

/// Sites that are computed before the host waits, so that no driver takes the work for hung.
constexpr double most_in_flight = 2e8;

/// One work group of a GPU computes fewer coarse sites than one on a CPU, as a dispatch of all groups soon
/// takes less. Measured on an NVIDIA H200 with CUDA by changing this number: `bench ball --energy elastic
/// --sizes 64x64x64` computes for 12 ms with 2720, for 8 with 700 and with 0; images of 1200 x 1200 take as
/// long with 500, 700 and 1300, and longer with 0.
constexpr std::int64_t most_coarse_sites_on_gpu = 700;

/// How the sites of a level are shared out: work items of a group, and sites of an item along the last axis
/// and side by side. A rasterizer on the CPU has one thread a group and pays for each of them; of loops over
/// many columns a compiler of OpenCL C makes SIMD; a GPU wants many items.
struct ElasticShape {
  int lanes;
  int rows;
  int columns;
};

int groups(int items, int together) {
  return (items + together - 1) / together;
}

/// Numbers of the sites or cells of all levels, as they lie on a device: a plane of each, or texels of four
/// with those of a site beside each other. The values of levels must live until they are written.
class SiteNumbers {
public:
  SiteNumbers(std::int64_t sites, std::size_t numbers, bool has_planes)
      : sites_(static_cast<std::size_t>(sites)), planes_(has_planes ? numbers : 1),
        stride_(has_planes ? 1 : (numbers + 3) / 4 * 4) {}

  /// The values of a number on a level; part.first counts from the first site here.
  void lay(std::size_t number, const RingedGrid& grid, const std::vector<float>& values,
           const ElasticLayout::Part& part) {
    laid_.push_back({number / stride_, number % stride_, &grid, values.data(), part});
  }
  void write(ComputeDevice& device, std::unique_ptr<Array>& to) const {
    const std::size_t floats = sites_ * stride_;
    const Kind kind = stride_ == 1 ? Kind::words : Kind::fours;
    make_room(device, to, std::max<std::size_t>(planes_ * floats * sizeof(float) / bytes_of(kind), 1), kind);
    for (std::size_t plane = 0; plane < planes_; ++plane) {
      write_parts(device, *to, plane * floats, floats, stride_,
                  [&](std::size_t begin, std::span<float> part) { fill(plane, begin / stride_, part); });
    }
  }

private:
  struct Laid {
    std::size_t plane;
    std::size_t number; ///< of the plane
    const RingedGrid* grid;
    const float* values;
    ElasticLayout::Part part;
  };

  /// Fills `to` with the part of a plane that begins with site `begin`.
  void fill(std::size_t plane, std::size_t begin, std::span<float> to) const {
    clear(to);
    const auto first_site = static_cast<std::int64_t>(begin);
    const auto end_site = static_cast<std::int64_t>(begin + to.size() / stride_);
    for (const Laid& laid : laid_) {
      if (laid.plane == plane) {
        for_each_row(laid.part, first_site, end_site, [&](int y, int z, int first, int end, std::int64_t at) {
          const float* const row = laid.values + laid.grid->index(0, y, z);
          for (int x = first; x < end; ++x) {
            to[static_cast<std::size_t>(at + x - first_site) * stride_ + laid.number] = row[x];
          }
        });
      }
    }
  }

  std::size_t sites_;
  std::size_t planes_;
  std::size_t stride_; ///< floats from a site to the next
  std::vector<Laid> laid_;
};

class ElasticArrays {
public:
  explicit ElasticArrays(ComputeDevice& device) : device_(device), programs_(device) {}

  static constexpr int block = ELASTIC_BLOCK;
  static constexpr bool has_laws = true;

  /// To be asked after load(). PoCL takes 5 s to compile the kernel of all steps of a volume, which brings
  /// nothing there. Measured by changing this line, `bench ball --energy elastic --backends opencl`: with it
  /// and without 14 and 12 ms at 16 x 16 x 16, 35 and 32 at 129 x 20 x 9, 186 and 183 at 64 x 64 x 64.
  [[nodiscard]] std::int64_t coarse_size() const {
    if (device_.limits().group < shape(true).lanes || (is_software() && has_planes() && axes_ == 3)) {
      return 0;
    }
    return is_software() ? ELASTIC_COARSE_SITES : most_coarse_sites_on_gpu;
  }

  void load(const ElasticHierarchy& hierarchy, const ElasticLayout& layout) {
    axes_ = layout.levels.front().sites.axes();
    variants_.clear(); // their programs know the number of axes
    if (layout.size != layout_.size) {
      fixed_ = {}; // before the new ones, so that both need not fit
      slots_ = {};
      laws_.forget();
    }
    layout_ = layout;
    has_boxes_ = hierarchy.levels.front().ratio.has_boxes(); // then maybe of coarse levels, too
    const auto size = static_cast<std::size_t>(layout.size);
    Commands zeros;
    for (std::size_t i = 0; i < slots_.size(); ++i) {
      const std::size_t count = i < elastic_slots ? size : static_cast<std::size_t>(layout.sums_size);
      make_room(device_, slots_[i], planes() * count, has_planes() ? Kind::words : texel());
      zeros.emplace_back(Fill{.array = slots_[i].get(), .bytes = slots_[i]->bytes(), .beside = true});
    }
    device_.run(zeros);
    upload_fixed(hierarchy);
    device_.finish();
  }

  void write(ElasticArray to, const VectorField& values) {
    for (std::size_t plane = 0; plane < planes(); ++plane) {
      write_parts(device_, slot(to), first_float(to, plane), region_floats(to), floats(),
                  [&](std::size_t begin, std::span<float> part) {
                    clear(part);
                    for_each_site_of(to, begin, part, [&](std::size_t site, float* numbers) {
                      for (std::size_t i = 0; i < components(); ++i) {
                        numbers[i] = values[plane + i][site];
                      }
                    });
                  });
    }
  }

  void read(ElasticArray from, VectorField& values) {
    for (std::size_t plane = 0; plane < planes(); ++plane) {
      read_parts(device_, slot(from), first_float(from, plane), region_floats(from), floats(),
                 [&](std::size_t begin, std::span<const float> part) {
                   for_each_site_of(from, begin, part, [&](std::size_t site, const float* numbers) {
                     for (std::size_t i = 0; i < components(); ++i) {
                       values[plane + i][site] = numbers[i];
                     }
                   });
                 });
    }
  }

  [[nodiscard]] bool is_software() const { return device_.description().is_software; }
  bool load(const LawForces& tissues) { return laws_.load(tissues); }
  LeastVolume law_forces(ElasticArray from, ElasticArray to) {
    return laws_.forces(slot(from), slot(to), seen_by_kernels(place_of(part_of(from), part_of(from).sites)),
                        layout_.size);
  }

  std::optional<double> device_seconds() { return device_.device_seconds(); }

  float read_sum(ElasticArray from) {
    std::array<float, 1> sum{};
    device_.read(slot(from), 0, std::as_writable_bytes(std::span(sum)));
    return sum.front();
  }

  void run(std::span<const ElasticWork> work) {
    compile(work);
    Commands commands;
    double in_flight = 0.0;
    for (const ElasticWork& piece : work) {
      if (const auto* const call = std::get_if<ElasticCall>(&piece)) {
        commands.emplace_back(dispatch_of(*call, false));
        if (call->kernel.has_masked) {
          commands.emplace_back(dispatch_of(*call, true));
        }
        const ElasticParameters::Place& to = call->parameters.to;
        in_flight += static_cast<double>(to.width) * to.height * to.depth;
      } else {
        commands.emplace_back(dispatch_of(std::get<ElasticTogether>(piece)));
      }
      if (in_flight > most_in_flight) {
        device_.run(std::exchange(commands, {}));
        device_.finish();
        in_flight = 0.0;
      }
    }
    if (!commands.empty()) {
      device_.run(commands);
    }
  }

private:
  [[nodiscard]] bool has_planes() const { return device_.limits().has_planes; }
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
  /// Returns how many floats lie from the first site of a level to the last.
  [[nodiscard]] std::size_t region_floats(ElasticArray of) const {
    const ElasticLayout::Part& part = part_of(of);
    return floats() * static_cast<std::size_t>((part.sites.depth - 1) * part.layer +
                                               (part.sites.height - 1) * part.pitch + part.sites.width);
  }
  /// Returns where in an array the first site of a plane begins.
  [[nodiscard]] std::size_t first_float(ElasticArray of, std::size_t plane) const {
    return (static_cast<std::size_t>(part_of(of).first) + plane * static_cast<std::size_t>(layout_.size)) *
           floats();
  }
  /// call(site in reading order, its numbers in `floats`) for the sites of a region that lie in a part of it,
  /// which begins with float `begin`.
  template <typename Floats, typename Call>
  void for_each_site_of(ElasticArray of, std::size_t begin, Floats part, const Call& call) const {
    ElasticLayout::Part region = part_of(of);
    region.first = 0;
    const auto from = static_cast<std::int64_t>(begin / floats());
    const auto to = from + static_cast<std::int64_t>(part.size() / floats());
    for_each_row(region, from, to, [&](int y, int z, int first, int end, std::int64_t at) {
      const std::size_t row = region.sites.index(0, y, z);
      for (int x = first; x < end; ++x) {
        call(row + static_cast<std::size_t>(x),
             part.data() + static_cast<std::size_t>(at + x - from) * floats());
      }
    });
  }

  /// What does not change: of sites and cells in arrays of the layout, and lists.
  void upload_fixed(const ElasticHierarchy& hierarchy) {
    SiteNumbers moments(layout_.size - layout_.moments_from(), moments_of_cells(axes_), has_planes());
    SiteNumbers response(layout_.size, axes_ == 3 ? 7 : 3, has_planes()); // and moduli of a volume's sites
    std::vector<const float*> matrices;                                   // of masked cells
    for (std::size_t number = 0; number < hierarchy.levels.size(); ++number) {
      const ElasticLevel& level = hierarchy.levels[number];
      const ElasticLayout::Part& part = layout_.levels[number];
      ElasticLayout::Part with_moments = part;
      with_moments.first -= layout_.moments_from();
      for (std::size_t i = 0; i < level.moments.size(); ++i) {
        level.moments.size() == 1 ? response.lay(6, level.grid, level.moments[i], part)
                                  : moments.lay(i, level.grid, level.moments[i], with_moments);
      }
      for (std::size_t i = 0; i < level.response.size(); ++i) {
        response.lay(i, level.grid, level.response[i], part);
      }
      for (std::size_t cell = 0; cell < level.masked.x.size(); ++cell) {
        matrices.push_back(level.masked.matrix(cell));
      }
    }
    touched_ = touched_sites(hierarchy);
    moments.write(device_, fixed_[ELASTIC_MOMENTS]);
    response.write(device_, fixed_[ELASTIC_RESPONSE]);
    write_blocks(matrices);
    put_components(ELASTIC_INVERSE, hierarchy.coarsest_inverse);
    put(ELASTIC_TOUCHED, Kind::words, touched_);
    if (!has_planes()) {
      make_room(device_, fixed_[ELASTIC_KEPT], elastic_slots_on_levels * ELASTIC_COARSE_SITES, texel());
    }
  }

  /// Writes of each matrix a block, filled up to fours, for the force on every corner by every other one:
  /// column by column.
  void write_blocks(const std::vector<const float*>& matrices) {
    const std::size_t corners = std::size_t{1} << axes_;
    const std::size_t each = (axes_ * axes_ + 3) / 4 * 4;
    const std::size_t blocks = corners * corners * each; // floats of a matrix
    const Kind kind = has_planes() ? Kind::words : Kind::fours;
    std::unique_ptr<Array>& to = fixed_[ELASTIC_MATRICES];
    make_room(device_, to,
              std::max(matrices.size() * blocks * sizeof(float) / bytes_of(kind), std::size_t{1}), kind);
    write_parts(device_, *to, 0, matrices.size() * blocks, blocks,
                [&](std::size_t begin, std::span<float> part) {
#pragma omp parallel for if (part.size() > floats_worth_threads)
                  for (std::size_t at = 0; at < part.size(); ++at) {
                    const float* const matrix = matrices[(begin + at) / blocks];
                    const std::size_t pair = at / each % (corners * corners);
                    const std::size_t i = at % each;
                    const std::size_t column = pair / corners * axes_ + i / axes_;
                    part[at] = i < axes_ * axes_
                                   ? matrix[column * corners * axes_ + pair % corners * axes_ + i % axes_]
                                   : 0.0F;
                  }
                });
  }
  /// Into an array of so many elements, which stays where it is as long as their number does: where memory
  /// is taken anew, the system has to clear it first.
  template <typename Value>
  void put(std::size_t number, Kind kind, const std::vector<Value>& values) {
    const auto bytes = std::as_bytes(std::span(values));
    make_room(device_, fixed_[number], std::max<std::size_t>(bytes.size() / bytes_of(kind), 1), kind);
    if (!values.empty()) {
      device_.write(*fixed_[number], 0, bytes);
    }
  }
  /// Numbers of one axis after the other.
  void put_components(std::size_t number, const std::vector<float>& values) {
    if (has_planes()) {
      put(number, Kind::words, values);
      return;
    }
    std::vector<float> texels(values.size() / axes_ * floats());
    for (std::size_t i = 0; i < values.size(); ++i) {
      texels[i / axes_ * floats() + i % axes_] = values[i];
    }
    put(number, texel(), texels);
  }

  [[nodiscard]] ElasticShape shape(bool is_together) const {
    if (!is_software()) {
      return {.lanes = is_together ? 256 : std::min(64, device_.limits().group), .rows = 1, .columns = 1};
    }
    return has_planes()  ? ElasticShape{.lanes = 1, .rows = 16, .columns = axes_ == 2 ? 256 : 64}
           : is_together ? ElasticShape{.lanes = 8, .rows = 10, .columns = 2}
                         : ElasticShape{.lanes = 16, .rows = 16, .columns = 4};
  }

  /// A kernel and how it is dispatched: what has a program of its own.
  struct Variant {
    bool is_together = false;
    ElasticKernel kernel;
    bool by_list = false;

    auto operator<=>(const Variant&) const = default;
  };
  [[nodiscard]] Variant together() const {
    return {.is_together = true, .kernel = {.has_load = true, .has_boxes = has_boxes_}};
  }

  [[nodiscard]] ProgramKind kind_of(const Variant& variant) const {
    const auto& [is_together, kernel, by_list] = variant;
    const ElasticShape items = shape(is_together);
    // Kernels know the rows of an image as planes.
    const int halved = axes_ == 3 ? kernel.halved : (kernel.halved & 3) | (kernel.halved & 2) << 1;
    // In the order of elastic.comp's constants.
    return {.kernel = Kernel::elastic,
            .constants = {{"TOGETHER", is_together ? 1 : 0},
                          {"STEP", static_cast<std::int32_t>(kernel.step)},
                          {"HAS_LOAD", kernel.has_load ? 1 : 0},
                          {"IS_IMAGE", kernel.is_image ? 1 : 0},
                          {"BY_LIST", by_list ? 1 : 0},
                          {"LANES", items.lanes},
                          {"ROWS", items.rows},
                          {"COLUMNS", items.columns},
                          {"BOXES", kernel.has_boxes ? 1 : 0},
                          {"HALVED", halved}},
            .axes = axes_};
  }

  /// Compiles together what the work needs: that often takes longer than the work.
  void compile(std::span<const ElasticWork> work) {
    std::set<Variant, std::greater<>> missing; // the kernel of all steps is the first: it takes longest
    const auto want = [&](const Variant& variant) {
      if (!variants_.contains(variant)) {
        missing.insert(variant);
      }
    };
    for (const ElasticWork& piece : work) {
      if (const auto* const call = std::get_if<ElasticCall>(&piece)) {
        want({.kernel = call->kernel});
        if (call->kernel.has_masked) {
          want({.kernel = call->kernel, .by_list = true});
        }
      } else {
        want(together());
      }
    }
    std::vector<ProgramKind> kinds;
    std::ranges::transform(missing, std::back_inserter(kinds),
                           [&](const Variant& variant) { return kind_of(variant); });
    programs_.prepare(std::move(kinds));
    for (const Variant& variant : missing) {
      variants_.emplace(variant, &programs_(kind_of(variant)));
    }
  }

  /// With the arrays that do not change.
  Dispatch dispatch_of(const Variant& variant) {
    Dispatch dispatch{.program = variants_.at(variant)};
    std::ranges::transform(fixed_, dispatch.arrays.begin(), [](const auto& array) { return array.get(); });
    return dispatch;
  }

  Dispatch dispatch_of(ElasticCall call, bool by_list) {
    Dispatch dispatch = dispatch_of({.kernel = call.kernel, .by_list = by_list});
    ElasticParameters& p = call.parameters;
    p.listed_first = touched_.at(2 * static_cast<std::size_t>(call.from.level));
    p.listed = touched_.at(2 * static_cast<std::size_t>(call.from.level) + 1);
    for (ElasticParameters::Place* const place : {&p.to, &p.from, &p.second}) {
      *place = seen_by_kernels(*place);
    }
    const ElasticShape items = shape(false);
    const int count =
        by_list ? p.listed : groups(p.to.width, items.columns) * p.to.height * groups(p.to.depth, items.rows);
    constexpr int most_groups = 32768; // in a row
    const int all = groups(count, items.lanes);
    dispatch.groups = {std::min(all, most_groups), groups(all, most_groups)};
    dispatch.arrays[ELASTIC_FROM] = &slot(call.from);
    dispatch.arrays[ELASTIC_SECOND] = &slot(call.second);
    dispatch.arrays[ELASTIC_THIRD] = &slot(call.second); // where there has to be one
    dispatch.arrays[ELASTIC_STORED] = &slot(call.to);
    dispatch.tell(p);
    return dispatch;
  }

  Dispatch dispatch_of(ElasticTogether steps) {
    const ElasticParameters::Place finest =
        seen_by_kernels({.width = steps.width, .height = steps.height, .depth = steps.depth});
    steps.height = finest.height;
    steps.depth = finest.depth;
    Dispatch dispatch = dispatch_of(together());
    for (std::size_t i = 0; i < elastic_slots_on_levels; ++i) {
      dispatch.arrays[ELASTIC_FROM + i] = slots_[i].get();
      dispatch.arrays[ELASTIC_STORED + i] = slots_[i].get();
    }
    dispatch.tell(steps);
    return dispatch;
  }

  /// An image has its rows where a volume has its planes.
  [[nodiscard]] ElasticParameters::Place seen_by_kernels(ElasticParameters::Place place) const {
    if (axes_ == 2) {
      std::swap(place.height, place.depth);
      place.layer = place.pitch;
    }
    return place;
  }

  ComputeDevice& device_;
  Programs programs_;
  std::map<Variant, const Program*> variants_; ///< what was compiled since load()
  LawsOnDevice laws_{device_};
  ElasticLayout layout_;
  std::size_t axes_ = 2;
  bool has_boxes_ = false;
  std::array<std::unique_ptr<Array>, elastic_slots + 2> slots_; ///< components of all levels, and sums
  std::array<std::unique_ptr<Array>, binding::count> fixed_;    ///< what does not change, by its binding
  std::vector<std::int32_t> touched_;                           ///< touched_sites()
};

} // namespace

std::unique_ptr<ElasticSession> make_elastic_session(std::string name,
                                                     std::unique_ptr<ComputeDevice> device) {
  return std::make_unique<ElasticLevelSession<ComputeDevice, ElasticArrays>>(std::move(name),
                                                                             std::move(device));
}

} // namespace hdmbench
