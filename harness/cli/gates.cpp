#include "harness/cli/arguments.hpp"

#include "harness/check/verify.hpp"

#include <map>

namespace hdmbench::commands {

namespace {

const Option<bool> require_hardware("--require-hardware",
                                    "Leave out backends whose device is software; exit status 2 where one "
                                    "was named with --backends or --require, or no hardware is left");
const Option<bool>
    fail_on_skip("--fail-on-skip",
                 "Exit status 1 where a backend is left out or skipped because its device is not there");

const Option<std::filesystem::path> baseline("--baseline",
                                             "What verify --json wrote before: exit status 1 where a "
                                             "comparison that agreed is missing or reaches a lower tier");

json verify_rows(const std::filesystem::path& file) {
  ResultFile results = read_results(file);
  if (results.command != "verify") {
    throw InputError(fmt::format("{}: is of hdmbench {}; --baseline takes what verify --json wrote",
                                 file.string(), results.command));
  }
  return std::move(results.results);
}

/// A row by what was compared: "24 x 24 square, icm, openmp, free".
std::map<std::string, json> by_comparison(const json& rows) {
  std::map<std::string, json> result;
  for (const json& row : rows) {
    const auto word = [&](const char* key) { return row.value(key, ""); };
    const std::string ranks = row.contains("ranks") ? fmt::format(" on {} ranks", row["ranks"].dump()) : "";
    const Extent extent{row.value("width", 0), row.value("height", 0), row.value("depth", 1)};
    result.emplace(fmt::format("{} {}, {}, {}{}, {}", extent.text(), word("scene"), word("method"),
                               word("backend"), ranks, word("mode")),
                   row);
  }
  return result;
}

/// Its place among tier_names: a better one is larger, 0 is none.
std::ptrdiff_t tier_of(const json& row) {
  return std::ranges::find(tier_names, row.value("tier", "none")) - tier_names.begin();
}

/// Throws InputError where no row reached a tier: then nothing could be lost.
void require_something_to_lose(const std::filesystem::path& file) {
  const json rows = verify_rows(file);
  if (std::ranges::none_of(rows, [](const json& row) { return row.is_object() && tier_of(row) > 0; })) {
    throw InputError(fmt::format("{}: no comparison in it agreed, so that it holds for nothing; give "
                                 "--baseline results of verify in which something did",
                                 file.string()));
  }
}

/// A line for every comparison of before that reached a tier and now is missing or reaches a lower one.
std::string losses(const json& before, const json& now) {
  const std::map<std::string, json> rows = by_comparison(now);
  std::string lines;
  for (const auto& [name, old] : by_comparison(before)) {
    const auto found = rows.find(name);
    if (tier_of(old) == 0 || (found != rows.end() && tier_of(found->second) >= tier_of(old))) {
      continue;
    }
    lines += fmt::format("  {}: was {}, is {}\n", name, old.value("tier", ""),
                         found == rows.end() ? "missing" : found->second.value("verdict", ""));
    if (found != rows.end() && found->second.value("reason", "") != "") {
      lines.insert(lines.size() - 1, ": " + found->second.value("reason", ""));
    }
  }
  return lines;
}

} // namespace

Options gate_options(bool with_baseline) {
  const Options all = with_baseline ? Options{require_hardware, fail_on_skip, baseline}
                                    : Options{require_hardware, fail_on_skip};
  return all.under("For continuous integration");
}

Gates::Gates(Call& call) {
  if (!call[baseline].empty()) {
    require_something_to_lose(call[baseline]);
    if (call[option::json].empty()) {
      call[option::json] = folder_.emplace().path() / "verify.json";
    }
  }
  if (!call[require_hardware] && !call[fail_on_skip]) {
    return;
  }
  std::vector<std::string>& asked = call[option::backends];
  const auto registry = make_backends();
  std::vector<std::string> kept;
  bool any_hardware = false;
  for (const auto& backend : registry) {
    if (!asked.empty() && !contains(asked, backend->name())) {
      continue;
    }
    const bool is_processor = backend->threads(call.session()) > 0;
    std::string why;
    try {
      const Device device = backend->device(is_processor ? SessionOptions{} : call.session());
      any_hardware = any_hardware || (!is_processor && !device.is_software);
      if (call[require_hardware] && device.is_software) {
        why = fmt::format("{} is software, and --require-hardware wants hardware", device.name);
      }
    } catch (const DeviceError& error) {
      why = error.what();
    }
    if (!why.empty() && needs(call, backend->name())) {
      throw DeviceError(fmt::format("{} is needed but not there: {}", backend->name(), why));
    }
    if (why.empty()) {
      kept.emplace_back(backend->name());
    } else {
      skipped_ += fmt::format("  {}: {}\n", backend->name(), why);
    }
  }
  if (call[require_hardware]) {
    fmt::print("{}{}", skipped_.empty() ? "" : "Left out:\n", skipped_);
    if (!any_hardware) {
      throw DeviceError("no backend has a device that is hardware; leave out --require-hardware to run on "
                        "what there is");
    }
    if (asked.empty()) {
      std::erase(kept, registry.front()->name()); // runs beside the others anyway
      asked = kept;
    }
  }
}

int Gates::judge(int status, const Call& call) const {
  bool good = true;
  if (call[fail_on_skip] && !skipped_.empty()) {
    fmt::print("\n--fail-on-skip: not everything was run:\n{}", skipped_);
    good = false;
  }
  if (!call[baseline].empty() && call.speaks()) {
    const std::string lost = [&] {
      try {
        return losses(verify_rows(call[baseline]), verify_rows(call[option::json]));
      } catch (const json::exception& error) {
        throw InputError(fmt::format("{}: {}", call[baseline].string(), error.what()));
      }
    }();
    fmt::print("\n{}\n{}",
               lost.empty() ? "All that agreed in the baseline agrees" : "Lost since the baseline:", lost);
    good = good && lost.empty();
  }
  return status == success && !good ? disagreement : status;
}

} // namespace hdmbench::commands
