#pragma once

#include "backends/backend.hpp"
#include "harness/measure/cost.hpp"
#include "harness/measure/result_file.hpp"
#include "harness/scene/scene.hpp"
#include "harness/solve/progress.hpp"

#include <nlohmann/json.hpp>

#include <cstddef>
#include <functional>
#include <iosfwd>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace benchmark {
class State;
}

namespace hdmbench {

/// How a scene is timed.
struct BenchOptions {
  std::vector<const Backend*> backends{}; ///< the reference first where there is one
  SessionOptions session{};               ///< but for its work
  /// Backends that leave out what rests run a second time so, where the scene's schedule lets them.
  bool dense = true;
  bool active = false;
  bool scaling = false;  ///< backends with threads of their own run with 1, 2, 4 ... of them, too
  bool checked = true;   ///< the first backend is the reference for speed and bits; else nothing is checked
  bool ceilings = false; ///< what devices can do at most is measured, too
  /// The command line that makes a row of a backend again. Null: rows have none.
  std::function<std::string(const Scene& scene, const Backend& backend, const SessionOptions& session)>
      command{};
};

/// The steps of an energy by themselves (kernels.hpp), at one extent.
struct KernelPlan {
  BenchOptions options;
  bool elastic = false;
  Extent extent{};
};

class Kernels;

/// Adds commit, compiler and machine to what the library's own files say of a run. Once in a process.
void tell_library(const Context& context);

/// Whole solutions as cases of Google Benchmark, which repeats and times them: manual time is Timings of a
/// solution without set-up, processor time that of all threads of this process. A case is named
/// SCENE/SIZE/ENERGY/METHOD/BACKEND/WORK, with /threads:N where the backend has threads of its own.
class Bench {
public:
  using Load = std::function<std::optional<Scene>()>;
  using Plan = std::function<BenchOptions(const Scene& scene)>;
  /// Who is told of rows.
  struct Hear {
    std::function<void(const nlohmann::json& rows)> show; ///< those of one scene, when it is done
    std::function<void(const nlohmann::json& rows)> keep; ///< all so far, after every case
  };

  explicit Bench(Progress& progress);
  ~Bench();
  Bench(const Bench&) = delete;
  Bench& operator=(const Bench&) = delete;

  /// Registers the cases of a scene, if it can be loaded; it is loaded again when its first case runs, unless
  /// it was the last one.
  void add(const Load& load, const Plan& plan);
  /// Registers the steps of an energy, one by one: "seconds" are those of one of several that are waited for
  /// together, "alone_seconds" the least of one with its own wait.
  void add_kernels(const KernelPlan& plan);

  /// A row for each case as it is before it runs, with a reason where the backend cannot solve the scene.
  [[nodiscard]] nlohmann::json registered() const;

  /// Runs the cases. `flags` are the library's own, "--benchmark_filter=openmp"; where they name a format or
  /// list the cases, the library prints to `printed`. Returns the rows of `bench`'s results in the order of
  /// registration: null is what does not apply or was not measured, giga is 10^9. "seconds" are the library's
  /// repetitions, each the mean of "solutions_per_sample" solutions. A case whose backend is not there has a
  /// row without seconds and with the reason. "peak_memory_bytes" are what this process occupied at most
  /// while the backend was opened and solved, the scene and the driver included; "bytes_per_site" are what
  /// scene and solution took of them. Throws InputError for flags that the library does not take, or where no
  /// case fits the filter.
  nlohmann::json run(std::vector<std::string> flags, std::ostream& printed, const Hear& hear);

private:
  struct Case;
  struct Place; ///< a scene and how it is timed
  class Reporter;

  void add_case(const Scene& scene, std::size_t place, const Backend& backend, SessionOptions session);
  /// The scene, loaded if it is not the one that is there.
  Scene& scene_of(std::size_t place);
  void register_case(Case one);
  void measure(Case& one, benchmark::State& state);
  void measure_kernel(Case& one, benchmark::State& state);
  void open(Case& one, Scene& scene);
  std::optional<Ceilings> ceilings_of(const Case& one);
  /// Puts the ceilings into its row, where they are asked for and there.
  void set_ceilings(Case& one);
  /// Why a field is not the reference's; empty: it is, or nothing is checked.
  std::string why_wrong(Case& one, Scene& scene, const VectorField& found);
  void compare_speeds(Case& one) const;
  /// Returns the rows of the cases that were run.
  [[nodiscard]] nlohmann::json rows() const;
  [[nodiscard]] const Case* measured(std::size_t place, const std::function<bool(const Case&)>& fits) const;

  Progress& progress_;
  std::vector<Place> places_;
  std::vector<std::unique_ptr<Case>> cases_; ///< in place: the library's functions refer to them
  std::optional<Scene> scene_;               ///< of places_[loaded_]
  std::size_t loaded_ = 0;
  std::shared_ptr<Kernels> open_; ///< those that have sessions; null: none have
  VectorField expected_;          ///< the reference's for scene_; empty: not yet known
  /// The ceilings of a backend with so many threads; none where they cannot be measured.
  std::map<std::pair<std::string, int>, std::optional<Ceilings>> ceilings_;
};

} // namespace hdmbench
