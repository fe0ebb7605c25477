#include "harness/web/elastic_steps.hpp"

#include "backends/cpu/cpu.hpp"
#include "backends/session/device_backend.hpp"
#include "backends/session/elastic_steps.hpp"
#include "harness/report/html.hpp"
#include "harness/solve/methods/elastic.hpp"
#include "kernels/data/input_error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace hdmbench {

namespace {

using nlohmann::json;

/// Base64 of all steps of a scene.
constexpr std::size_t most_bytes = std::size_t{32} << 20;

/// What a device is told.
struct Paper {
  /// Bytes between host and device.
  struct Passed {
    std::size_t array = 0;
    std::size_t first = 0;
    std::vector<std::byte> bytes;
  };

  /// Throws InputError where all would be too much.
  std::string base64(std::span<const std::byte> numbers) {
    std::string text = report::base64({reinterpret_cast<const char*>(numbers.data()), numbers.size()});
    bytes += text.size();
    if (bytes > most_bytes) {
      throw InputError(fmt::format("a page with all steps of this scene would have more than {} MB: take a "
                                   "smaller --size or fewer --iterations",
                                   most_bytes >> 20));
    }
    return text;
  }

  json arrays = json::array(); ///< how many bytes each has
  json told = json::array();
  std::vector<Passed>* passed = nullptr; ///< where they go that are written in place of `told`
  std::size_t bytes = 0;                 ///< of all base64
  std::vector<Passed> read;              ///< all zeros: nothing is computed
};

class PaperArray final : public Array {
public:
  PaperArray(ComputeDevice& device, std::size_t count, Kind kind, Paper& paper)
      : Array(device, count, kind), number(paper.arrays.size()) {
    paper.arrays.push_back(bytes());
  }

  std::size_t number;
};

class PaperProgram final : public Program {
public:
  explicit PaperProgram(ProgramKind of) : kind(std::move(of)) {}

  ProgramKind kind;
};

/// Writes down what a GPU with planes is told.
class PaperDevice final : public ComputeDevice {
public:
  explicit PaperDevice(Paper& paper) : paper_(paper) {
    constexpr std::size_t many = std::size_t{1} << 31;
    limits_ = {.elements = many,
               .array_bytes = many,
               .memory = many,
               .groups_x = 65535,
               .groups_y = 65535,
               .group = 64,
               .has_planes = true};
  }

  const Device& description() const override { return description_; }
  const DeviceLimits& limits() const override { return limits_; }
  void write(const Array& to, std::size_t first, std::span<const std::byte> values) override {
    if (paper_.passed != nullptr) {
      paper_.passed->push_back({number_of(to), first, {values.begin(), values.end()}});
    } else {
      paper_.told.push_back({{"array", number_of(to)}, {"first", first}, {"bytes", paper_.base64(values)}});
    }
  }
  void read(const Array& from, std::size_t first, std::span<std::byte> values) override {
    std::ranges::fill(values, std::byte{});
    paper_.read.push_back({number_of(from), first, {values.begin(), values.end()}});
  }
  std::unique_ptr<Program> compile(const ProgramKind& kind) override {
    return std::make_unique<PaperProgram>(kind);
  }
  ProgramText text_of(const ProgramKind& /*kind*/) const override { return {}; }
  void run(std::span<const Commands::value_type> commands) override {
    for (const auto& command : commands) {
      std::visit([&](const auto& one) { tell(one); }, command);
    }
  }
  void finish() override {}
  std::optional<double> device_seconds() override { return {}; }

private:
  std::unique_ptr<Array> make(std::size_t count, Kind kind) override {
    return std::make_unique<PaperArray>(*this, count, kind, paper_);
  }
  static std::size_t number_of(const Array& array) { return static_cast<const PaperArray&>(array).number; }

  void tell(const Fill& fill) {
    paper_.told.push_back({{"array", number_of(*fill.array)}, {"first", fill.first}, {"zeros", fill.bytes}});
  }
  void tell(const Dispatch& dispatch) {
    const ProgramKind& kind = static_cast<const PaperProgram*>(dispatch.program)->kind;
    json constants;
    for (const ProgramKind::Constant& one : kind.constants) {
      constants[std::string(one.name)] = one.value;
    }
    json arrays = json::array();
    for (std::size_t number = 0; number < dispatch.arrays.size(); ++number) {
      if (dispatch.arrays[number] != nullptr) {
        arrays.push_back({number, number_of(*dispatch.arrays[number])});
      }
    }
    const char* const text = kind.kernel == Kernel::laws ? "laws" : "elastic";
    paper_.told.push_back({{"program", fmt::format("{} {}", text, kind.axes)},
                           {"constants", std::move(constants)},
                           {"arrays", std::move(arrays)},
                           {"words", std::span(dispatch.words).first(dispatch.word_count)},
                           {"groups", {dispatch.groups.width, dispatch.groups.height}}});
  }

  Paper& paper_;
  Device description_{.name = "paper", .driver = "none"};
  DeviceLimits limits_;
};

/// Scalar, led by a method, and the session of a device that is told the same.
class WrittenRun final : public ElasticSession {
public:
  explicit WrittenRun(ElasticSession& reference)
      : reference_(reference), device_(make_elastic_session("paper", std::make_unique<PaperDevice>(paper_))) {
  }

  void take(const MethodStep& step) override {
    VectorField expected;
    reference_.take(step);
    reference_.read(step.made_on(), step.to, expected);
    device_->take(step);
    VectorField none;
    device_->read(step.made_on(), step.to, none); // so that the device is told all
    keep(step.name(), step.made_on(), step.to, expected);
  }
  /// As verify does: all that devices compute of these is compared.
  bool has_own_laws() const override { return true; }
  std::optional<LeastVolume> law_forces(const LawForces& tissues, const VectorField& displacement,
                                        VectorField& force) override {
    const LeastVolume least = tissues(displacement, force);
    VectorField none;
    paper_.read.clear();
    static_cast<void>(device_->law_forces(tissues, displacement, none));
    const Paper::Passed shares = paper_.read.at(0); // what has kept least, by work items, and their sites
    keep("forces of laws", 0, ElasticField::image, force);
    steps_.back()["least"] = {{"array", shares.array},
                              {"size", shares.bytes.size()},
                              {"share", std::bit_cast<std::int32_t>(static_cast<float>(least.share))},
                              {"site", least.site}};
    return least;
  }
  void read(int level, ElasticField field, VectorField& values) const override {
    reference_.read(level, field, values);
  }
  float dot(ElasticField first, ElasticField second) const override {
    const float expected = reference_.dot(first, second);
    paper_.read.clear();
    static_cast<void>(device_->dot(first, second));
    Paper::Passed made = paper_.read.at(0);
    const auto bytes = std::bit_cast<std::array<std::byte, sizeof expected>>(expected);
    made.bytes.assign(bytes.begin(), bytes.end());
    keep("dot product", 0, {made}, ElasticLayout::Part{.sites = {1, 1}, .pitch = 1, .layer = 1});
    return expected;
  }

  /// Returns all that was written down.
  [[nodiscard]] json written() { return {{"arrays", paper_.arrays}, {"steps", std::move(steps_)}}; }

private:
  void do_load(ElasticHierarchy& hierarchy) override {
    reference_.load(hierarchy);
    device_->load(hierarchy);
  }

  /// Keeps what the device was told and that it has to make a field of.
  void keep(std::string_view name, int level, ElasticField field, const VectorField& expected) {
    json told = std::exchange(paper_.told, json::array());
    std::vector<Paper::Passed> made;
    paper_.passed = &made;
    device_->write(level, field, expected);
    paper_.passed = nullptr;
    paper_.told = std::move(told);
    keep(name, level, made, ElasticLayout::alone(expected.extent));
  }
  /// `part` says where in each plane of `made` the sites of a field are, but for the first.
  void keep(std::string_view name, int level, const std::vector<Paper::Passed>& made,
            const ElasticLayout::Part& part) const {
    json step{{"step", name},
              {"level", level},
              {"told", std::exchange(paper_.told, json::array())},
              {"made", json::array()},
              {"sites", {part.sites.width, part.sites.height, part.sites.depth}},
              {"pitch", part.pitch},
              {"layer", part.layer}};
    for (const Paper::Passed& plane : made) {
      step["made"].push_back(
          {{"array", plane.array}, {"first", plane.first}, {"bytes", paper_.base64(plane.bytes)}});
    }
    steps_.push_back(std::move(step));
  }

  ElasticSession& reference_;
  mutable Paper paper_;
  std::unique_ptr<ElasticSession> device_;
  mutable json steps_ = json::array();
};

} // namespace

json elastic_steps_of(const Scene& scene, Progress& progress) {
  if (has_laws(scene.full) && &law_of(scene.full) != &laws::neo_hookean::law) {
    throw InputError(
        fmt::format("{} has a law whose text the page has not: it has that of the shipped ones", scene.name));
  }
  const std::unique_ptr<Backend> backend = make_scalar();
  const std::unique_ptr<ElasticSession> session = backend->open_elastic({});
  WrittenRun run(*session);
  static_cast<void>(solve_elastic(scene, run, progress));
  json written = run.written();
  const Extent full = scene.full.extent;
  written.update({{"name", scene.name},
                  {"method", has_laws(scene.full) ? "laws of large strains" : method_name(scene)},
                  {"width", full.width},
                  {"height", full.height},
                  {"depth", full.depth},
                  {"axes", full.axes()}});
  return written;
}

} // namespace hdmbench
