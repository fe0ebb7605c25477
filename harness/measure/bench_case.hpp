#pragma once

#include "harness/measure/bench.hpp"
#include "harness/measure/memory_use.hpp"
#include "harness/solve/methods/solver.hpp"

#include <benchmark/benchmark.h>

#include <array>

/// What Bench is made of: for its own two sources.
namespace hdmbench {

struct Bench::Place {
  Load load;
  BenchOptions options;
  std::string name{}; ///< "square 300 x 300"
  std::vector<LevelWork> levels{};
  std::vector<StepsTaken> steps{}; ///< of the elastic energy; empty: not counted yet
  std::size_t scene_bytes = 0;     ///< that loading it took
};

struct Bench::Case {
  std::string name;
  std::size_t place;
  const Backend* backend;
  SessionOptions session;
  bool is_reference = false;
  std::string refusal{}; ///< why it is not run; empty: it is
  nlohmann::json row{};
  std::shared_ptr<Kernels> kernels{}; ///< null: a whole solution is timed
  std::size_t kernel = 0;             ///< of these
  bool is_prepared = false;
  std::unique_ptr<Solver> solver{}; ///< from the first of its repetitions to the last
  std::optional<PeakMemory> memory{};
  std::size_t resident = 0; ///< when it was opened, bytes
  std::optional<Ceilings> most{};
  std::optional<SolutionCost> cost{};
  bool is_reported = false;

  /// After its last repetition.
  void close() {
    is_reported = true;
    solver.reset();
    memory.reset();
  }
  [[nodiscard]] bool is_dense() const { return session.work == Work::dense; }
  [[nodiscard]] bool is_measured() const { return is_reported && !row["seconds"].empty(); }
};

inline constexpr double giga = 1e-9; ///< 10^9 of a unit in one

/// The parts of a solution as the library has them, means of a repetition.
inline constexpr std::array parts{
    std::pair{"projection_seconds", &Timings::projection}, std::pair{"upload_seconds", &Timings::upload},
    std::pair{"compute_seconds", &Timings::compute}, std::pair{"readback_seconds", &Timings::readback}};

/// Makes rows of what the library reports, and hands it on where it is to be printed.
class Bench::Reporter final : public benchmark::BenchmarkReporter {
public:
  /// `printer`: the library's own; null: nothing is printed.
  Reporter(Bench& bench, std::unique_ptr<benchmark::BenchmarkReporter> printer, const Hear& hear)
      : bench_(bench), printer_(std::move(printer)), hear_(hear) {}

  bool ReportContext(const Context& context) override;
  /// The repetitions of a case, or what the library makes of them.
  void ReportRuns(const std::vector<Run>& runs) override;
  void Finalize() override;

private:
  void take(const std::vector<Run>& runs, nlohmann::json& row) const;
  void show();

  Bench& bench_;
  std::unique_ptr<benchmark::BenchmarkReporter> printer_;
  const Hear& hear_;
  std::vector<Case*> shown_{}; ///< of one scene, not yet shown
};

} // namespace hdmbench
