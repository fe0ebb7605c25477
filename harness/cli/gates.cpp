#include "harness/cli/gates.hpp"

#include "harness/check/verify.hpp"

#include <vector>

namespace hdmbench::commands {

namespace {

std::vector<VerifyRow> verify_rows(const std::filesystem::path& file) {
  const ResultFile results = read_results(file);
  if (results.command != "verify") {
    throw InputError(fmt::format("{}: is of hdmbench {}; --baseline takes what verify --json wrote",
                                 file.string(), results.command));
  }
  return results.rows<VerifyRow>();
}

bool same_comparison(const VerifyRow& a, const VerifyRow& b) {
  return a.scene == b.scene && a.width == b.width && a.height == b.height && a.method == b.method &&
         a.backend == b.backend && a.mode == b.mode && a.ranks == b.ranks;
}

/// A line for every comparison of before that reached a tier and now is missing or reaches a lower one.
std::string losses(const std::vector<VerifyRow>& before, const std::vector<VerifyRow>& now) {
  std::string lines;
  for (const VerifyRow& old : before) {
    const auto found =
        std::ranges::find_if(now, [&](const VerifyRow& row) { return same_comparison(old, row); });
    if (old.tier == Tier::none || (found != now.end() && found->tier >= old.tier)) {
      continue;
    }
    lines += fmt::format("  {} x {} {}, {}, {}, {}: was {}, {}\n", old.width, old.height, old.scene,
                         old.method, old.backend, name_of(old.mode), name_of(old.tier),
                         found == now.end() ? "is missing"
                                            : fmt::format("is {}{}{}", name_of(found->verdict),
                                                          found->reason.empty() ? "" : ": ", found->reason));
  }
  return lines;
}

} // namespace

void Gates::add_to(CLI::App& command, bool with_baseline) {
  const OptionGroup group(command, "For continuous integration");
  add_flag(command, "--require-hardware", require_hardware_,
           "Leave out backends whose device is software; exit status 2 where one was named with "
           "--backends or --require, or no hardware is left");
  add_flag(command, "--fail-on-skip", fail_on_skip_,
           "Exit status 1 where a backend is left out or skipped because its device is not there");
  if (with_baseline) {
    add_option(command, "--baseline", baseline_,
               "What verify --json wrote before: exit status 1 where a comparison that agreed is missing "
               "or reaches a lower tier");
  }
}

void Gates::prepare(CommonArguments& arguments, Call& call) {
  if (!baseline_.empty()) {
    (void)verify_rows(baseline_);
    if (call.json.empty()) {
      call.json = folder_.emplace().path() / "verify.json";
    }
  }
  if (!require_hardware_ && !fail_on_skip_) {
    return;
  }
  const auto registry = make_backends();
  std::vector<std::string> kept;
  bool any_hardware = false;
  for (const auto& backend : registry) {
    if (!arguments.backends.empty() &&
        std::ranges::find(arguments.backends, backend->name()) == arguments.backends.end()) {
      continue;
    }
    const bool is_processor = backend->threads(arguments.session) > 0;
    std::string why;
    try {
      const Device device = backend->device(is_processor ? SessionOptions{} : arguments.session);
      any_hardware = any_hardware || (!is_processor && !device.is_software);
      if (require_hardware_ && device.is_software) {
        why = fmt::format("{} is software, and --require-hardware wants hardware", device.name);
      }
    } catch (const DeviceError& error) {
      why = error.what();
    }
    if (!why.empty() && arguments.needs(backend->name())) {
      throw DeviceError(fmt::format("{} is needed but not there: {}", backend->name(), why));
    }
    if (why.empty()) {
      kept.emplace_back(backend->name());
    } else {
      skipped_ += fmt::format("  {}: {}\n", backend->name(), why);
    }
  }
  if (require_hardware_) {
    fmt::print("{}{}", skipped_.empty() ? "" : "Left out:\n", skipped_);
    if (!any_hardware) {
      throw DeviceError("no backend has a device that is hardware; leave out --require-hardware to run on "
                        "what there is");
    }
    if (arguments.backends.empty()) {
      std::erase(kept, registry.front()->name()); // runs beside the others anyway
      arguments.backends = kept;
    }
  }
}

int Gates::judge(int status, const Call& call) const {
  bool good = true;
  if (fail_on_skip_ && !skipped_.empty()) {
    fmt::print("\n--fail-on-skip: not everything was run:\n{}", skipped_);
    good = false;
  }
  if (!baseline_.empty() && call.speaks()) {
    const std::string lost = losses(verify_rows(baseline_), verify_rows(call.json));
    fmt::print("\n{}\n{}",
               lost.empty() ? "All that agreed in the baseline agrees" : "Lost since the baseline:", lost);
    good = good && lost.empty();
  }
  return status == success && !good ? disagreement : status;
}

} // namespace hdmbench::commands
