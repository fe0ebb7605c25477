#pragma once

#include "backends/device/device.hpp"
#include "backends/session/elastic_steps.hpp"
#include "kernels/data/elastic/law_forces.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <vector>

namespace hdmbench {

/// The forces of tissues with laws of large strains on a device that is programmed by kernels
/// (kernels/shaders/laws.h), to the bit those of LawForces. The forces of cells are kept for some layers of
/// them at a time: those of all would be more than all else. All throw DeviceError.
class LawsOnDevice {
public:
  explicit LawsOnDevice(ComputeDevice& device) : device_(device), programs_(device) {}

  /// Uploads tissues, unless they are there. Returns false where they are too large for the device. They must
  /// outlive the calls of forces().
  bool load(const LawForces& tissues);
  /// Gives the memory back; load() is next.
  void forget();

  /// Sets the field in `to` to the forces under that in `from`, both of the image in `place`, in which an
  /// image has its rows where a volume has planes, with floats of the planes of components so far apart;
  /// waits until it is done. Returns the cell that has kept least.
  LeastVolume forces(const Array& from, const Array& to, const ElasticParameters::Place& place,
                     std::int64_t plane);

private:
  /// Layers of cells, and of the sites whose forces they make.
  struct Slab {
    int first = 0;
    int cells = 0;
    int first_of_sites = 0;
    int sites = 0;
  };

  /// Return how many cells there are along x, along y and in a layer.
  [[nodiscard]] int cells_across() const { return seen_.width - 1; }
  [[nodiscard]] int cells_down() const { return std::max(seen_.height - 1, 1); }
  [[nodiscard]] int of_layer() const { return cells_across() * cells_down(); }
  /// Returns how many layers of cells have their forces kept at a time, at least two where there are so many.
  [[nodiscard]] int layers_kept() const;
  /// Returns how many cells these are.
  [[nodiscard]] std::size_t cells_kept() const {
    return static_cast<std::size_t>(layers_kept()) * static_cast<std::size_t>(of_layer());
  }
  /// Returns the slabs in which all layers are computed, one after the other.
  [[nodiscard]] std::vector<Slab> slabs() const;
  void upload();
  /// Returns the least of what so many slabs have kept.
  [[nodiscard]] LeastVolume least(std::size_t slab_count);
  [[nodiscard]] Dispatch dispatch_of(int step, std::int64_t items);
  /// Returns how many cells or sites of a row a work item has.
  [[nodiscard]] int columns() const;

  ComputeDevice& device_;
  Programs programs_;
  const LawForces* tissues_ = nullptr;
  std::shared_ptr<const void> loaded_; ///< LawForces::identity()
  bool fits_ = false;
  Extent seen_; ///< sites, those of an image as if it had one row and many planes
  bool has_fibres_ = false;
  std::int64_t tissue_origin_ = 0; ///< of planes of sites, and from one to the next
  std::int64_t tissue_plane_ = 0;
  std::array<std::unique_ptr<Array>, binding::count> arrays_; ///< by their binding
};

} // namespace hdmbench
