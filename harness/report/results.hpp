#pragma once

#include "harness/check/failing_calls_row.hpp"
#include "harness/check/faults/fault_row.hpp"
#include "harness/check/golden_row.hpp"
#include "harness/check/probe.hpp"
#include "harness/check/verify_row.hpp"
#include "harness/judge/accuracy/accuracy_row.hpp"
#include "harness/judge/atlas/atlas_row.hpp"
#include "harness/judge/continuum/continuum.hpp"
#include "harness/judge/registration/knobs.hpp"
#include "harness/judge/registration/people.hpp"
#include "harness/judge/registration/registration_row.hpp"
#include "harness/judge/run_row.hpp"
#include "harness/judge/tradeoff/tradeoff_row.hpp"
#include "harness/measure/bench_row.hpp"
#include "harness/measure/comparison/rows.hpp"
#include "harness/measure/context.hpp"
#include "harness/measure/device_row.hpp"
#include "harness/measure/implementations.hpp"
#include "harness/measure/instructions_row.hpp"
#include "harness/measure/scaling_row.hpp"

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

/// What the result files say; nothing here knows HTML.
namespace hdmbench::report {

/// A result file whose rows were read.
struct Source : Context {
  std::filesystem::path file;
  std::string command;      ///< "verify"
  std::size_t rows = 0;     ///< read from the file
  std::size_t replaced = 0; ///< of them, by newer ones; not in Results
};

/// A row and where it was read.
template <typename Row>
struct From : Row {
  std::size_t source = 0; ///< index into Results::sources
};

using AccuracyRow = From<hdmbench::AccuracyRow>;
using AtlasRow = From<atlas::AtlasRow>;
using BenchRow = From<hdmbench::BenchRow>;
using ComparedRow = From<comparison::ComparedRow>;
using ContinuumRow = From<hdmbench::ContinuumRow>;
using DeviceRow = From<hdmbench::DeviceRow>;
using EqualAccuracyRow = From<hdmbench::EqualAccuracyRow>;
using FailingCallsRow = From<hdmbench::FailingCallsRow>;
using FaultRow = From<hdmbench::FaultRow>;
using GoldenRow = From<hdmbench::GoldenRow>;
using ImplementationRow = From<hdmbench::ImplementationRow>;
using InstructionsRow = From<hdmbench::InstructionsRow>;
using ProbeRow = From<hdmbench::ProbeRow>;
using DetectionRow = From<hdmbench::DetectionRow>;
using InclusionRow = From<hdmbench::InclusionRow>;
using KnobRow = From<hdmbench::KnobRow>;
using PeopleRow = From<hdmbench::PeopleRow>;
using RegistrationRow = From<hdmbench::RegistrationRow>;
using RivalRow = From<hdmbench::RivalRow>;
using RunRow = From<hdmbench::RunRow>;
using ScalingRow = From<hdmbench::ScalingRow>;
using TradeoffRow = From<hdmbench::TradeoffRow>;
using VerifyRow = From<hdmbench::VerifyRow>;

struct Results {
  std::vector<Source> sources; ///< oldest first
  std::vector<std::string> machines;
  std::vector<DeviceRow> devices;
  std::vector<VerifyRow> verify;
  std::vector<ImplementationRow> implementations;
  std::vector<ProbeRow> probe;
  std::vector<FaultRow> faults;
  std::vector<BenchRow> bench;
  std::vector<ComparedRow> compare;
  std::vector<RunRow> run;
  std::vector<ScalingRow> scaling;
  std::vector<RegistrationRow> registrations;
  std::vector<DetectionRow> detections;
  std::vector<RivalRow> rivals;
  std::vector<PeopleRow> people;
  std::vector<InclusionRow> inclusions;
  std::vector<KnobRow> knobs;
  std::vector<AccuracyRow> accuracy;
  std::vector<ContinuumRow> continuum;
  std::vector<AtlasRow> atlas;
  std::vector<InstructionsRow> instructions;
  std::vector<GoldenRow> golden;
  std::vector<FailingCallsRow> failing_calls;
  std::vector<TradeoffRow> tradeoff;
  std::vector<EqualAccuracyRow> equal_accuracy;

  template <typename Row>
  [[nodiscard]] const std::string& machine_of(const From<Row>& row) const {
    return sources[row.source].machine;
  }

  /// A file that a row names.
  template <typename Row>
  [[nodiscard]] std::filesystem::path path_of(const From<Row>& row, const std::string& name) const {
    return sources[row.source].file.parent_path() / name;
  }

  /// The rows of one machine.
  template <typename Row>
  [[nodiscard]] std::vector<Row> of(const std::vector<Row>& rows, const std::string& machine) const {
    std::vector<Row> result;
    for (const Row& row : rows) {
      if (machine_of(row) == machine) {
        result.push_back(row);
      }
    }
    return result;
  }

  /// Whether `backend` on `device` of `machine` is the CPU in disguise; false where no devices row tells.
  [[nodiscard]] bool is_software(const std::string& machine, const std::string& backend,
                                 const std::string& device) const;
};

/// Reads files, or the *.json files of folders. Of the same command, machine, scene, size, backend, device
/// and mode or method (for accuracy also variant and Poisson ratios, for tradeoff effort) only the
/// newest row stays; a machine's newest `devices`, `implementations` or `instructions` file replaces the
/// older ones. Throws InputError naming file and key for whatever is missing, mistyped or contradicts itself
/// (a row that "agrees" with differing sites).
[[nodiscard]] Results load_results(std::span<const std::filesystem::path> paths);

} // namespace hdmbench::report
