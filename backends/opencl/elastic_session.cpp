#include "backends/opencl/elastic_session.hpp"

#include "backends/opencl/programs.hpp"

#include <fmt/format.h>
#include <shaders/elastic_cell.hpp>
#include <shaders/elastic_opencl.hpp>
#include <shaders/elastic_site.hpp>
#include <shaders/elastic_steps.hpp>
#include <shaders/language_opencl.hpp>

#include <limits>
#include <map>
#include <span>
#include <utility>
#include <vector>

namespace hdmbench::opencl {

namespace {

/// Of elastic.cl: a site beside masked cells.
struct TouchedSite {
  cl_int x = 0;
  std::array<cl_int, 4> masked{-1, -1, -1, -1};
};

/// Those of all levels, row by row, and where a row begins.
struct TouchedSites {
  explicit TouchedSites(const ElasticHierarchy& hierarchy) {
    cl_int first_matrix = 0;
    for (const ElasticLevel& level : hierarchy.levels) {
      first_row.push_back(row_begin.size());
      for (int y = 0; y < level.grid.sites.height; ++y) {
        row_begin.push_back(static_cast<cl_int>(sites.size()));
        std::map<int, TouchedSite> row;
        for (const int below : {0, 1}) {
          const auto [first, last] = level.masked.row(y - 1 + below);
          for (std::size_t i = first; i < last; ++i) {
            const int x = level.masked.cells[i].x;
            const cl_int number = first_matrix + static_cast<cl_int>(i);
            row[x].masked.at(static_cast<std::size_t>(2 * below + 1)) = number;
            row[x + 1].masked.at(static_cast<std::size_t>(2 * below)) = number;
          }
        }
        for (auto& [x, site] : row) {
          site.x = x;
          sites.push_back(site);
        }
      }
      row_begin.push_back(static_cast<cl_int>(sites.size()));
      first_matrix += static_cast<cl_int>(level.masked.cells.size());
    }
  }

  std::vector<TouchedSite> sites;
  std::vector<cl_int> row_begin;
  std::vector<std::size_t> first_row; ///< per level, in row_begin
};

class OpenClElastic final : public ElasticDevice {
public:
  explicit OpenClElastic(Queue queue)
      : queue_(std::move(queue)), lanes_(shapes_for(queue_.device()).front().lanes) {}

  void load(const ElasticHierarchy& hierarchy, const ElasticLayout& layout) override {
    require_fits(hierarchy, layout);
    layout_ = layout;
    const auto size = static_cast<std::size_t>(layout.size);
    for (Buffer& slot : slots_) {
      clear(slot, 2 * size);
    }
    for (Buffer& sums : sums_) {
      clear(sums, static_cast<std::size_t>(layout.sums_size));
    }
    upload_sites(hierarchy, size);
    upload_masked(hierarchy);
    upload(inverse_, std::span<const float>(hierarchy.coarsest_inverse));
  }

  void write(ElasticArray to, const VectorField& values) override {
    const ElasticLayout::Part& part = part_of(to);
    std::vector<float> rows(region(part));
    for (const bool is_y : {false, true}) {
      const std::vector<float>& plane = is_y ? values.y : values.x;
      for (int y = 0; y < part.sites.height; ++y) {
        std::copy_n(plane.data() + part.sites.index(0, y), part.sites.width, rows.data() + y * part.pitch);
      }
      queue_.write(slots_.at(static_cast<std::size_t>(to.slot)), offset(part, is_y), rows);
    }
  }

  void read(ElasticArray from, VectorField& values) override {
    const ElasticLayout::Part& part = part_of(from);
    std::vector<float> rows(region(part));
    for (const bool is_y : {false, true}) {
      queue_.read(slots_.at(static_cast<std::size_t>(from.slot)), offset(part, is_y), rows);
      std::vector<float>& plane = is_y ? values.y : values.x;
      for (int y = 0; y < part.sites.height; ++y) {
        std::copy_n(rows.data() + y * part.pitch, part.sites.width, plane.data() + part.sites.index(0, y));
      }
    }
  }

  float read_sum(ElasticArray from) override {
    float sum = 0.0F;
    queue_.read(buffer(from), 0, {&sum, 1});
    return sum;
  }

  void run(std::span<const ElasticWork> work) override {
    for (const ElasticWork& call : work) {
      run(std::get<ElasticCall>(call));
    }
  }

private:
  void run(const ElasticCall& call) {
    const Kernel& kernel = compiled(call.kernel);
    cl_uint index = 0;
    kernel.set(index++, buffer(call.from));
    kernel.set(index++, buffer(call.second));
    kernel.set(index++, buffer(call.to));
    kernel.set(index++, moments_);
    kernel.set(index++, response_);
    kernel.set(index++, touched_);
    kernel.set(index++, row_begin_.at(static_cast<std::size_t>(call.from.level)));
    kernel.set(index++, call.kernel.step == ElasticStep::solve ? inverse_ : matrices_);
    kernel.set(index++, static_cast<cl_uint>(layout_.size));
    kernel.set(index, call.parameters);
    queue_.run(kernel, static_cast<std::size_t>(call.parameters.height), static_cast<std::size_t>(lanes_));
  }

  [[nodiscard]] const ElasticLayout::Part& part_of(ElasticArray array) const {
    return layout_.levels.at(static_cast<std::size_t>(array.level));
  }
  [[nodiscard]] const Buffer& buffer(ElasticArray array) const {
    return array.slot < elastic_slots ? slots_.at(static_cast<std::size_t>(array.slot))
                                      : sums_.at(static_cast<std::size_t>(array.slot - elastic_sums));
  }
  /// Floats from the first site of a level to the last.
  [[nodiscard]] static std::size_t region(const ElasticLayout::Part& part) {
    return static_cast<std::size_t>((part.sites.height - 1) * part.pitch + part.sites.width);
  }
  /// Byte of the first site.
  [[nodiscard]] std::size_t offset(const ElasticLayout::Part& part, bool is_y) const {
    return static_cast<std::size_t>(part.first + (is_y ? layout_.size : 0)) * sizeof(float);
  }

  void require_fits(const ElasticHierarchy& hierarchy, const ElasticLayout& layout) const {
    const FoundDevice& device = queue_.device();
    const std::size_t plane = static_cast<std::size_t>(layout.size) * sizeof(float);
    const std::size_t largest = 6 * plane;
    const std::size_t all = (2 * elastic_slots + 6 + 3) * plane;
    const Extent sites = hierarchy.levels.front().grid.sites;
    if (largest > device.largest_buffer || all > device.memory ||
        layout.size > std::numeric_limits<std::int32_t>::max()) {
      throw TooLarge(
          fmt::format("{}: {} x {} sites need {} bytes for the elastic energy, {} of them in one buffer; the "
                      "device has {} and takes {} in one",
                      device.description.name, sites.width, sites.height, all, largest, device.memory,
                      device.largest_buffer));
    }
  }

  void clear(Buffer& buffer, std::size_t floats) const {
    queue_.make_room(buffer, floats * sizeof(float));
    queue_.clear(buffer, floats * sizeof(float));
  }

  template <typename Value>
  void upload(Buffer& buffer, std::span<const Value> values) const {
    queue_.make_room(buffer, std::max<std::size_t>(values.size_bytes(), sizeof(Value)));
    if (!values.empty()) {
      queue_.write_bytes(buffer, values.size_bytes(), values.data());
    }
  }

  void upload_sites(const ElasticHierarchy& hierarchy, std::size_t size) {
    std::vector<float> moments(6 * size);
    std::vector<float> response(3 * size);
    for (std::size_t level = 0; level < hierarchy.levels.size(); ++level) {
      const ElasticLevel& here = hierarchy.levels[level];
      const auto lay = [&](const auto& planes, std::vector<float>& to) {
        for (std::size_t i = 0; i < planes.size(); ++i) {
          lay_out(here.grid, planes[i], layout_.levels[level], to.data() + i * size, 1);
        }
      };
      lay(here.moments, moments);
      lay(here.response, response);
    }
    upload(moments_, std::span<const float>(moments));
    upload(response_, std::span<const float>(response));
  }

  void upload_masked(const ElasticHierarchy& hierarchy) {
    const TouchedSites touched(hierarchy);
    upload(touched_, std::span<const TouchedSite>(touched.sites));
    row_begin_.clear();
    for (std::size_t level = 0; level < hierarchy.levels.size(); ++level) {
      const auto rows = static_cast<std::size_t>(hierarchy.levels[level].grid.sites.height) + 1;
      upload(row_begin_.emplace_back(),
             std::span<const cl_int>(touched.row_begin).subspan(touched.first_row[level], rows));
    }
    std::vector<float> matrices;
    for (const ElasticLevel& level : hierarchy.levels) {
      for (const MaskedCell& cell : level.masked.cells) {
        matrices.insert(matrices.end(), cell.stiffness.begin(), cell.stiffness.end());
      }
    }
    upload(matrices_, std::span<const float>(matrices));
  }

  const Kernel& compiled(const ElasticKernel& kernel) {
    auto found = kernels_.find(kernel);
    if (found == kernels_.end()) {
      found = kernels_
                  .emplace(kernel,
                           queue_.make_kernel(elastic_text(kernel, lanes_), build_options, "elastic_step"))
                  .first;
    }
    return found->second;
  }

  Queue queue_;
  int lanes_;
  ElasticLayout layout_;
  std::array<Buffer, elastic_slots> slots_; ///< planes x and y of all levels
  std::array<Buffer, 2> sums_;
  Buffer moments_;  ///< six planes
  Buffer response_; ///< three
  Buffer touched_;
  std::vector<Buffer> row_begin_; ///< per level
  Buffer matrices_;
  Buffer inverse_;
  std::map<ElasticKernel, Kernel> kernels_;
};

} // namespace

std::unique_ptr<ElasticDevice> make_elastic_device(Queue queue) {
  return std::make_unique<OpenClElastic>(std::move(queue));
}

std::string elastic_text(const ElasticKernel& kernel, int lanes) {
  std::string text = fmt::format("{}#define LANES {}\n", elastic_definitions(kernel), lanes);
  for (const std::string_view part : {sources::language_opencl, sources::elastic_steps, sources::elastic_cell,
                                      sources::elastic_site, sources::elastic_opencl}) {
    text += part;
  }
  return text;
}

} // namespace hdmbench::opencl
