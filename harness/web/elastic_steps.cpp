#include "harness/web/elastic_steps.hpp"

#include "backends/cpu/cpu.hpp"
#include "backends/session/device_backend.hpp"
#include "backends/session/elastic_steps.hpp"
#include "harness/report/html.hpp"
#include "harness/solve/methods/elastic.hpp"
#include "kernels/data/input_error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace hdmbench {

namespace {

using nlohmann::json;

/// A page has at most so much base64 for a scene.
constexpr std::size_t most_bytes = std::size_t{32} << 20;

/// What a device is told.
struct Transcript {
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

class TranscriptArray final : public Array {
public:
  TranscriptArray(ComputeDevice& device, std::size_t count, Kind kind, Transcript& transcript)
      : Array(device, count, kind), number(transcript.arrays.size()) {
    transcript.arrays.push_back(bytes());
  }

  std::size_t number;
};

class TranscriptProgram final : public Program {
public:
  explicit TranscriptProgram(ProgramKind of) : kind(std::move(of)) {}

  ProgramKind kind;
};

/// Writes down what a GPU with planes is told.
class TranscriptDevice final : public ComputeDevice {
public:
  explicit TranscriptDevice(Transcript& transcript) : transcript_(transcript) {
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
    if (transcript_.passed != nullptr) {
      transcript_.passed->push_back({number_of(to), first, {values.begin(), values.end()}});
    } else {
      transcript_.told.push_back(
          {{"array", number_of(to)}, {"first", first}, {"bytes", transcript_.base64(values)}});
    }
  }
  void read(const Array& from, std::size_t first, std::span<std::byte> values) override {
    std::ranges::fill(values, std::byte{});
    transcript_.read.push_back({number_of(from), first, {values.begin(), values.end()}});
  }
  std::unique_ptr<Program> compile(const ProgramKind& kind) override {
    return std::make_unique<TranscriptProgram>(kind);
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
    return std::make_unique<TranscriptArray>(*this, count, kind, transcript_);
  }
  static std::size_t number_of(const Array& array) {
    return static_cast<const TranscriptArray&>(array).number;
  }

  void tell(const Fill& fill) {
    transcript_.told.push_back(
        {{"array", number_of(*fill.array)}, {"first", fill.first}, {"zeros", fill.bytes}});
  }
  void tell(const Dispatch& dispatch) {
    const ProgramKind& kind = static_cast<const TranscriptProgram*>(dispatch.program)->kind;
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
    transcript_.told.push_back({{"program", fmt::format("{} {}", text, kind.axes)},
                                {"constants", std::move(constants)},
                                {"arrays", std::move(arrays)},
                                {"words", std::span(dispatch.words).first(dispatch.word_count)},
                                {"groups", {dispatch.groups.width, dispatch.groups.height}}});
  }

  Transcript& transcript_;
  Device description_{.name = "transcript", .driver = "none"};
  DeviceLimits limits_;
};

/// Scalar, led by a method, and the session of a device that is told the same.
class WrittenRun final : public ElasticSession {
public:
  explicit WrittenRun(ElasticSession& reference)
      : reference_(reference),
        device_(make_elastic_session("transcript", std::make_unique<TranscriptDevice>(transcript_))) {}

  void take(const MethodStep& step) override {
    VectorField expected;
    reference_.take(step);
    reference_.read(step.made_on(), step.to, expected);
    device_->take(step);
    VectorField none;
    device_->read(step.made_on(), step.to, none); // so that the device is told all
    keep(step.name(), step.made_on(), step.to, expected);
  }
  /// Every device computes these here, as in verify, whether or not solutions want it to.
  bool has_own_laws() const override { return true; }
  std::optional<LeastVolume> law_forces(const LawForces& tissues, const VectorField& displacement,
                                        VectorField& force) override {
    const LeastVolume least = tissues(displacement, force);
    VectorField none;
    transcript_.read.clear();
    static_cast<void>(device_->law_forces(tissues, displacement, none));
    const Transcript::Passed shares =
        transcript_.read.at(0); // what has kept least, by work items, and their sites
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
    transcript_.read.clear();
    static_cast<void>(device_->dot(first, second));
    Transcript::Passed made = transcript_.read.at(0);
    const auto bytes = std::bit_cast<std::array<std::byte, sizeof expected>>(expected);
    made.bytes.assign(bytes.begin(), bytes.end());
    keep("dot product", 0, {made}, ElasticLayout::Part{.sites = {1, 1}, .pitch = 1, .layer = 1});
    return expected;
  }

  /// Returns all that was written down.
  [[nodiscard]] json written() { return {{"arrays", transcript_.arrays}, {"steps", std::move(steps_)}}; }

private:
  void do_load(ElasticHierarchy& hierarchy) override {
    reference_.load(hierarchy);
    device_->load(hierarchy);
  }

  /// Keeps what the device was told, and the field that it has to make of that.
  void keep(std::string_view name, int level, ElasticField field, const VectorField& expected) {
    json told = std::exchange(transcript_.told, json::array());
    std::vector<Transcript::Passed> made;
    transcript_.passed = &made;
    device_->write(level, field, expected);
    transcript_.passed = nullptr;
    transcript_.told = std::move(told);
    keep(name, level, made, ElasticLayout::alone(expected.extent));
  }
  /// `part` says where in each plane of `made` the sites of a field are, but for the first.
  void keep(std::string_view name, int level, const std::vector<Transcript::Passed>& made,
            const ElasticLayout::Part& part) const {
    json step{{"step", name},
              {"level", level},
              {"told", std::exchange(transcript_.told, json::array())},
              {"made", json::array()},
              {"sites", {part.sites.width, part.sites.height, part.sites.depth}},
              {"pitch", part.pitch},
              {"layer", part.layer}};
    for (const Transcript::Passed& plane : made) {
      step["made"].push_back(
          {{"array", plane.array}, {"first", plane.first}, {"bytes", transcript_.base64(plane.bytes)}});
    }
    steps_.push_back(std::move(step));
  }

  ElasticSession& reference_;
  mutable Transcript transcript_;
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
