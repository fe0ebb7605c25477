#include "backends/session/laws_on_device.hpp"

#include "backends/session/level_arrays.hpp"
#include "kernels/shaders/law_steps.h"

#include <algorithm>
#include <bit>
#include <utility>
#include <vector>

namespace hdmbench {

namespace {

/// Cells whose forces are kept at a time, unless a layer has more: texels of 64 MiB.
constexpr int most_cells = 1 << 19;
/// Work items that look for the cell that has kept least, of which the host looks through the rest.
constexpr int items_of_least = 1024;
/// Cells that are computed before the host waits, so that no driver takes the work for hung.
constexpr std::int64_t most_in_flight = 20'000'000;

/// What kernels are told, in the order of kernels/shaders/laws.h.
struct LawParameters {
  std::array<float, 3> one_over_sides{};
  std::int32_t plane = 0; ///< of the field
  float mu = 0.0F;        ///< as CellConstants
  float lame = 0.0F;
  float half_modulus = 0.0F;
  float least_modulus = 0.0F;
  ElasticParameters::Place field{};
  std::int32_t first_layer = 0; ///< of cells
  std::int32_t layers = 0;
  std::int32_t first_layer_of_sites = 0;
  std::int32_t layers_of_sites = 0;
  std::int32_t cells = 0; ///< whose forces there is room for
  std::int32_t first_item = 0;
  std::int32_t tissue_plane = 0;
  std::int32_t tissue_origin = 0;
};

std::vector<std::int32_t> site_bits(const LawForces& tissues) {
  const Level& level = tissues.level();
  std::vector<std::int32_t> bits(level.extent.sites());
#pragma omp parallel for if (bits.size() > sites_worth_threads)
  for (int row = 0; row < level.extent.rows(); ++row) {
    for (int x = 0; x < level.extent.width; ++x) {
      const std::size_t site = level.extent.index(x, row);
      for (std::size_t axis = 0; axis < level.extent.axes(); ++axis) {
        bits[site] |= (level.confidence[axis][site] >= 1.0F ? 1 : 0) << axis;
      }
      bits[site] |= (tissues.can_move(x, static_cast<std::size_t>(row)) ? 1 : 0) << LAW_COUNTS;
    }
  }
  return bits;
}

} // namespace

bool LawsOnDevice::load(const LawForces& tissues) {
  tissues_ = &tissues;
  if (loaded_ == tissues.identity()) {
    return fits_;
  }
  loaded_ = nullptr;
  const Extent extent = tissues.level().extent;
  seen_ = extent.axes() == 3 ? extent : Extent{extent.width, 1, extent.height};
  has_fibres_ = has_fibres(tissues.level());
  fits_ = true;
  try {
    upload();
  } catch (const TooLarge&) {
    arrays_ = {};
    fits_ = false;
  }
  loaded_ = tissues.identity();
  return fits_;
}

void LawsOnDevice::forget() {
  loaded_ = nullptr;
  arrays_ = {};
}

void LawsOnDevice::upload() {
  const Level& level = tissues_->level();
  const std::size_t axes = level.extent.axes();
  const bool has_planes = device_.limits().has_planes;
  const SiteLayout layout(level.extent, has_planes);
  tissue_origin_ = static_cast<std::int64_t>(layout.origin);
  tissue_plane_ = static_cast<std::int64_t>(layout.plane);
  const ScalarField linear = has_laws(level) ? ScalarField{} : ScalarField(level.extent, -1.0F);
  make_room(device_, arrays_[LAW_TISSUE], layout.count(2), layout.kind(2));
  write_sites(device_, *arrays_[LAW_TISSUE], 0, layout,
              {level.modulus.values, has_laws(level) ? level.law_parameter.values : linear.values});
  if (has_fibres_) {
    const ScalarField none = axes == 3 ? ScalarField{} : ScalarField(level.extent, 0.0F);
    make_room(device_, arrays_[LAW_FIBRES], layout.count(4), layout.kind(4));
    write_sites(device_, *arrays_[LAW_FIBRES], 0, layout,
                {level.fibre[0], level.fibre[1], axes == 3 ? level.fibre[2] : none.values,
                 level.fibre_compression.values});
  } else {
    make_room(device_, arrays_[LAW_FIBRES], 1, layout.kind(4));
  }
  const std::vector<std::int32_t> bits = site_bits(*tissues_);
  make_room(device_, arrays_[LAW_SITE_BITS], bits.size(), Kind::words);
  device_.write(*arrays_[LAW_SITE_BITS], 0, std::as_bytes(std::span(bits)));
  constexpr std::size_t corners = 8;
  make_room(device_, arrays_[LAW_FORCES], corners * cells_kept() * (has_planes ? axes : 1),
            has_planes ? Kind::words : layout.kind(axes));
  make_room(device_, arrays_[LAW_SHARES], cells_kept(), Kind::words);
  make_room(device_, arrays_[LAW_LEAST_OF_ITEMS], std::size_t{2} * items_of_least * slabs().size(),
            Kind::words);
}

int LawsOnDevice::layers_kept() const {
  return std::min(std::max(most_cells / of_layer(), 2), seen_.depth - 1);
}

std::vector<LawsOnDevice::Slab> LawsOnDevice::slabs() const {
  std::vector<Slab> all;
  // A slab of several does the layer of cells before its first sites again.
  const int most = std::max(layers_kept() - 1, 1);
  for (int first = 0; first < seen_.depth; first += most) {
    const int end = std::min(first + most, seen_.depth);
    const int first_of_cells = std::max(first - 1, 0);
    all.push_back({.first = first_of_cells,
                   .cells = std::min(end, seen_.depth - 1) - first_of_cells,
                   .first_of_sites = first,
                   .sites = end - first});
  }
  return all;
}

LeastVolume LawsOnDevice::forces(const Array& from, const Array& to, const ElasticParameters::Place& place,
                                 std::int64_t plane) {
  const CellConstants& constants = tissues_->constants();
  LawParameters told{.one_over_sides = constants.one_over_sides,
                     .plane = static_cast<std::int32_t>(plane),
                     .mu = constants.mu,
                     .lame = constants.lame,
                     .half_modulus = constants.half_modulus,
                     .least_modulus = constants.least_modulus,
                     .field = place,
                     .cells = static_cast<std::int32_t>(cells_kept()),
                     .tissue_plane = static_cast<std::int32_t>(tissue_plane_),
                     .tissue_origin = static_cast<std::int32_t>(tissue_origin_)};
  const auto strips = [&](int across) { return std::int64_t{(across + columns() - 1) / columns()}; };
  const std::vector<Slab> all = slabs();
  Commands commands;
  std::int64_t in_flight = 0;
  for (const Slab& slab : all) {
    told.first_layer = slab.first;
    told.layers = slab.cells;
    told.first_layer_of_sites = slab.first_of_sites;
    told.layers_of_sites = slab.sites;
    for (const auto& [step, items] :
         {std::pair{LAW_CELLS, strips(cells_across()) * cells_down() * slab.cells},
          {LAW_SITES, strips(seen_.width) * seen_.height * slab.sites},
          {LAW_LEAST, std::int64_t{items_of_least}}}) {
      Dispatch dispatch = dispatch_of(step, items);
      dispatch.arrays[LAW_DISPLACEMENT] = &from;
      dispatch.arrays[LAW_STORED] = step == LAW_SITES ? &to : arrays_[LAW_FORCES].get();
      // What is stored to is not fetched as well.
      dispatch.arrays[LAW_FORCES] = step == LAW_SITES ? arrays_[LAW_FORCES].get() : &from;
      dispatch.tell(told);
      commands.emplace_back(dispatch);
    }
    told.first_item += items_of_least;
    in_flight += std::int64_t{slab.cells} * of_layer();
    if (in_flight > most_in_flight) {
      device_.run(std::exchange(commands, {}));
      device_.finish();
      in_flight = 0;
    }
  }
  device_.run(commands);
  return least(all.size());
}

LeastVolume LawsOnDevice::least(std::size_t slab_count) {
  std::vector<std::array<std::int32_t, 2>> of_items(items_of_least * slab_count);
  device_.read(*arrays_[LAW_LEAST_OF_ITEMS], 0, std::as_writable_bytes(std::span(of_items)));
  LeastVolume least;
  for (const auto& [bits, site] : of_items) {
    const LeastVolume one{.share = double{std::bit_cast<float>(bits)},
                          .site = static_cast<std::size_t>(site)};
    if (one.share < least.share || (one.share == least.share && one.site < least.site)) {
      least = one;
    }
  }
  return least;
}

Dispatch LawsOnDevice::dispatch_of(int step, std::int64_t items) {
  // A compiler of OpenCL C for a CPU makes SIMD of a loop, a rasterizer of the items of a group.
  const bool has_planes = device_.limits().has_planes;
  const bool is_software = device_.description().is_software;
  const int together = !is_software ? std::min(64, device_.limits().group) : has_planes ? 1 : 16;
  Dispatch dispatch{.program = &programs_({.kernel = Kernel::laws,
                                           .constants = {{"STEP", step},
                                                         {"FIBRES", has_fibres_ && step == LAW_CELLS ? 1 : 0},
                                                         {"LANES", together},
                                                         {"COLUMNS", columns()}},
                                           .law = &tissues_->law(),
                                           .axes = tissues_->level().extent.axes()})};
  constexpr std::int64_t most_groups = 32768; // in a row
  const auto all = (items + together - 1) / together;
  dispatch.groups = {static_cast<int>(std::min(all, most_groups)),
                     static_cast<int>((all + most_groups - 1) / most_groups)};
  std::ranges::transform(arrays_, dispatch.arrays.begin(), [](const auto& array) { return array.get(); });
  return dispatch;
}

int LawsOnDevice::columns() const {
  return device_.description().is_software && device_.limits().has_planes ? 64 : 1;
}

} // namespace hdmbench
