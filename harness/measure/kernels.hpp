#pragma once

#include "backends/backend.hpp"
#include "backends/shared/elastic_costs.hpp"

#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace hdmbench {

/// One step of a method by itself.
struct TimedKernel {
  std::string name;        ///< "sweep, unobserved", "relax", "dot"
  int level = 0;           ///< that it works on; 0 is the image
  Extent sites{};          ///< of that level
  StepCost cost{};         ///< for each site; 0: not declared
  bool is_on_host = false; ///< part of the set-up, which no device does
};

/// The steps of an energy on images or volumes of one extent, on one backend: of the thesis's energy a sweep
/// over sites that are all of one SiteKind, of the elastic energy all steps of its methods on the image and
/// the level below, the sum of a product, the forces of neo-Hookean tissue with the copies of a field to the
/// device and back (the host's where a backend has none of its own), and what is made of the moduli before.
class Kernels {
public:
  /// Opens nothing. `backend` must outlive this object. Throws InputError where the elastic energy has no
  /// second level at this extent.
  Kernels(const Backend& backend, SessionOptions session, bool elastic, Extent extent);
  ~Kernels();
  Kernels(const Kernels&) = delete;
  Kernels& operator=(const Kernels&) = delete;

  [[nodiscard]] const std::vector<TimedKernel>& all() const { return all_; }
  /// Makes ready to run this one: opens sessions and uploads. Throws DeviceError.
  void prepare(std::size_t kernel);
  /// Runs it so many times, one after the other, and waits for the last one. Throws DeviceError.
  void run(std::size_t kernel, int times);
  /// Returns Timed::device_seconds() of the session that run() used last.
  [[nodiscard]] std::optional<double> device_seconds();
  /// Gives back what prepare() has taken.
  void close();

private:
  struct Open;

  const Backend& backend_;
  SessionOptions session_;
  bool elastic_;
  Extent extent_;
  std::vector<TimedKernel> all_{};
  std::vector<MethodStep> steps_{}; ///< of the elastic energy, the first of all_
  std::size_t law_forces_ = 0;      ///< the place of those in all_
  std::unique_ptr<Open> open_;      ///< null: nothing is
};

} // namespace hdmbench
