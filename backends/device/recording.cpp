#include "backends/device/recording.hpp"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <optional>

namespace hdmbench {

namespace {

/// A word with another number in it, where 0 and -0 are one.
bool is_other(std::uint32_t a, std::uint32_t b) {
  constexpr std::uint32_t all_but_sign = 0x7fffffff;
  return a != b && ((a | b) & all_but_sign) != 0;
}

std::uint32_t word_at(const std::vector<std::byte>& bytes, std::size_t at) {
  std::uint32_t word = 0;
  std::memcpy(&word, &bytes[at], sizeof word);
  return word;
}

} // namespace

void DeviceRecording::in_phase(Phase phase, const std::function<void()>& call) {
  struct Ended {
    Phase& phase;
    ~Ended() { phase = Phase::idle; }
  } const ended{phase_};
  phase_ = phase;
  call();
}

void DeviceRecording::record(const std::function<void()>& take) {
  step_ = {};
  arrays_.clear();
  programs_.clear();
  in_phase(Phase::told, take);
}

std::size_t DeviceRecording::number_of(ComputeDevice& device, const Array& array) {
  const auto known = std::ranges::find(arrays_, &array);
  if (known != arrays_.end()) {
    return static_cast<std::size_t>(known - arrays_.begin());
  }
  arrays_.push_back(&array);
  RecordedStep::KeptArray& kept = step_.arrays.emplace_back();
  kept.kind = array.kind();
  kept.before.resize(array.bytes());
  device.read(array, 0, kept.before);
  return arrays_.size() - 1;
}

std::optional<RecordedStep> DeviceRecording::step(const std::function<void()>& read,
                                                  const std::function<void()>& write_found,
                                                  const std::function<void()>& write_expected) {
  const auto passed_in = [&](Phase phase, const std::function<void()>& call) {
    passed_.clear();
    in_phase(phase, call);
    return std::exchange(passed_, {});
  };
  const std::vector<Passed> made = passed_in(Phase::read, read);
  const std::vector<Passed> found = passed_in(Phase::written, write_found);
  const std::vector<Passed> expected = passed_in(Phase::written, write_expected);
  if (step_.programs.empty() || made.empty()) {
    return std::nullopt;
  }
  auto as_found = found.begin();
  auto as_expected = expected.begin();
  for (const Passed& one : made) {
    const auto is_there = [&](const Passed& written) {
      return written.first == one.first && written.bytes.size() == one.bytes.size();
    };
    as_found = std::find_if(as_found, found.end(), is_there);
    as_expected = std::find_if(as_expected, expected.end(), is_there);
    const auto array = std::ranges::find(arrays_, one.array);
    if (as_found == found.end() || as_expected == expected.end() || array == arrays_.end()) {
      return std::nullopt;
    }
    std::vector<std::byte> right = one.bytes;
    for (std::size_t at = 0; at + sizeof(std::uint32_t) <= right.size(); at += sizeof(std::uint32_t)) {
      if (is_other(word_at(as_found->bytes, at), word_at(as_expected->bytes, at))) {
        std::memcpy(&right[at], &as_expected->bytes[at], sizeof(std::uint32_t));
      }
    }
    step_.made.push_back(
        {static_cast<std::size_t>(array - arrays_.begin()), one.first, one.bytes, std::move(right)});
    ++as_found;
    ++as_expected;
  }
  return std::exchange(step_, {});
}

namespace {

class RecordedArray final : public Array {
public:
  RecordedArray(ComputeDevice& device, std::unique_ptr<Array> made)
      : Array(device, made->count(), made->kind()), inner(std::move(made)) {}

  std::unique_ptr<Array> inner;
};

class RecordedProgram final : public Program {
public:
  RecordedProgram(ProgramKind kind_, std::unique_ptr<Program> made)
      : kind(std::move(kind_)), inner(std::move(made)) {}

  ProgramKind kind;
  std::unique_ptr<Program> inner;
};

const Array& inner_of(const Array& array) {
  return *static_cast<const RecordedArray&>(array).inner;
}

} // namespace

/// Hands all verbs on, and keeps them while its recording wants them.
class RecordedDevice final : public ComputeDevice {
  using Phase = DeviceRecording::Phase;

public:
  RecordedDevice(std::unique_ptr<ComputeDevice> device, DeviceRecording& recording)
      : device_(std::move(device)), recording_(recording) {}

  const Device& description() const override { return device_->description(); }
  const DeviceLimits& limits() const override { return device_->limits(); }
  void write(const Array& to, std::size_t first, std::span<const std::byte> values) override {
    if (recording_.phase_ == Phase::written) {
      recording_.passed_.push_back({&to, first, {values.begin(), values.end()}});
    } else if (recording_.phase_ == Phase::told) {
      const std::vector<std::byte> kept(values.begin(), values.end()); // verbs may change staging memory
      tell_bytes(to, first, kept);
      device_->write(inner_of(to), first, kept);
    } else {
      device_->write(inner_of(to), first, values);
    }
  }
  void read(const Array& from, std::size_t first, std::span<std::byte> values) override {
    device_->read(inner_of(from), first, values);
    if (recording_.phase_ == Phase::read) {
      recording_.passed_.push_back({&from, first, {values.begin(), values.end()}});
    }
  }
  std::unique_ptr<Program> compile(const ProgramKind& kind) override {
    return std::make_unique<RecordedProgram>(kind, device_->compile(kind));
  }
  ProgramText text_of(const ProgramKind& kind) const override { return device_->text_of(kind); }
  void run(std::span<const Commands::value_type> commands) override {
    if (recording_.phase_ == Phase::written) {
      return;
    }
    if (recording_.phase_ == Phase::told) {
      for (const auto& command : commands) {
        std::visit([&](const auto& one) { tell(one); }, command);
      }
    }
    Commands inner(commands.begin(), commands.end());
    for (auto& command : inner) {
      std::visit([](auto& one) { hand_on(one); }, command);
    }
    device_->run(inner);
  }
  void finish() override { device_->finish(); }
  std::span<std::byte> staging() override { return device_->staging(); }
  std::optional<double> device_seconds() override { return device_->device_seconds(); }
  void settle() noexcept override { device_->settle(); }
  void abandon() noexcept override { device_->abandon(); }

private:
  std::unique_ptr<Array> make(std::size_t count, Kind kind) override {
    return std::make_unique<RecordedArray>(*this, device_->allocate(count, kind));
  }
  void enter() override { use_.emplace(*device_); }
  void leave() noexcept override { use_.reset(); }

  static void hand_on(Dispatch& dispatch) {
    dispatch.program = static_cast<const RecordedProgram*>(dispatch.program)->inner.get();
    for (const Array*& array : dispatch.arrays) {
      array = array == nullptr ? nullptr : &inner_of(*array);
    }
  }
  static void hand_on(Fill& fill) { fill.array = &inner_of(*fill.array); }

  /// Nothing of a batch has been done when its first command is told, so arrays have what they had before.
  void tell(const Dispatch& dispatch) {
    RecordedStep& step = recording_.step_;
    step.device = description();
    RecordedStep::Told told{.dispatch = dispatch};
    told.dispatch.program = nullptr;
    told.dispatch.arrays = {};
    for (std::size_t number = 0; number < dispatch.arrays.size(); ++number) {
      if (dispatch.arrays[number] != nullptr) {
        told.arrays.emplace_back(number, recording_.number_of(*this, *dispatch.arrays[number]));
      }
    }
    const auto known = std::ranges::find(recording_.programs_, dispatch.program);
    told.program = static_cast<std::size_t>(known - recording_.programs_.begin());
    if (known == recording_.programs_.end()) {
      recording_.programs_.push_back(dispatch.program);
      step.programs.push_back(text_of(static_cast<const RecordedProgram*>(dispatch.program)->kind));
    }
    step.told.push_back(std::move(told));
  }
  void tell(const Fill& fill) { tell_bytes(*fill.array, fill.first, std::vector<std::byte>(fill.bytes)); }
  void tell_bytes(const Array& to, std::size_t first, std::vector<std::byte> bytes) {
    const std::size_t number = recording_.number_of(*this, to);
    recording_.step_.device = description();
    recording_.step_.told.push_back({.arrays = {{0, number}}, .first = first, .bytes = std::move(bytes)});
  }

  std::unique_ptr<ComputeDevice> device_;
  DeviceRecording& recording_;
  std::optional<Use> use_;
};

std::unique_ptr<ComputeDevice> recorded(std::unique_ptr<ComputeDevice> device, DeviceRecording* recording) {
  return recording == nullptr ? std::move(device)
                              : std::make_unique<RecordedDevice>(std::move(device), *recording);
}

} // namespace hdmbench
