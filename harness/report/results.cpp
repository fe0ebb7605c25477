#include "harness/report/results.hpp"

#include "harness/report/joined.hpp"
#include "harness/report/json_reader.hpp"
#include "kernels/input_error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <set>

namespace hdmbench::report {

namespace {

using Path = std::filesystem::path;

std::vector<Path> result_files(std::span<const Path> paths) {
  std::vector<Path> files;
  std::set<Path> seen;
  const auto add = [&](const Path& file) {
    if (seen.insert(std::filesystem::weakly_canonical(file)).second) {
      files.push_back(file);
    }
  };
  for (const Path& path : paths) {
    if (!std::filesystem::is_directory(path)) {
      add(path);
      continue;
    }
    std::vector<Path> inside;
    for (const auto& entry : std::filesystem::directory_iterator(path)) {
      if (entry.path().extension() == ".json" && !entry.is_directory()) {
        inside.push_back(entry.path());
      }
    }
    if (inside.empty()) {
      throw InputError(
          fmt::format("{}: the folder has no *.json file; write one with --json", path.string()));
    }
    std::ranges::sort(inside);
    std::ranges::for_each(inside, add);
  }
  if (files.empty()) {
    throw InputError("no result files were given; hdmbench verify, bench, accuracy, run and devices write "
                     "them with --json FILE");
  }
  return files;
}

Context read_context(const JsonReader& document) {
  if (document.count("schema") != 1) {
    document.fail("schema", fmt::format("is {}, but this program reads schema 1", document.count("schema")));
  }
  const JsonReader context = document.object("context");
  Context result;
  result.file = document.file();
  result.command = document.text("command");
  result.machine = context.text("machine");
  result.cpu = context.text("cpu");
  result.cores = context.count("cores");
  result.operating_system = context.text("operating_system");
  result.compiler = context.text("compiler");
  result.flags = context.text("flags");
  result.commit = context.text("commit");
  result.date = context.text("date");
  result.version = context.text("version");
  result.arguments = context.text("arguments");
  result.quick = context.flag("quick");
  return result;
}

DeviceRow read_device(const JsonReader& json) {
  DeviceRow row;
  row.backend = json.text("backend");
  row.available = json.flag("available");
  row.device = json.text("device");
  row.driver = json.text("driver");
  row.reason = json.text("reason");
  row.description = json.text("description");
  row.software = json.flag("software");
  row.updates = json.texts("updates");
  return row;
}

Verdict read_verdict(const JsonReader& json) {
  const std::vector<std::string> names{"agree", "certified", "disagree", "mistrusted", "skipped"};
  const std::string name = json.text("verdict", names);
  return static_cast<Verdict>(std::ranges::find(names, name) - names.begin());
}

Tier read_tier(const JsonReader& json) {
  const std::vector<std::string> names(tier_names.begin(), tier_names.end());
  return static_cast<Tier>(std::ranges::find(names, json.text("tier", names)) - names.begin());
}

// 9 digits tell any two floats apart.
std::string plain(const nlohmann::json& value) {
  if (value.is_string()) {
    return value.get<std::string>();
  }
  if (value.is_null()) {
    return "not finite";
  }
  if (value.is_number_float()) {
    return fmt::format("{:.9g}", value.get<double>());
  }
  if (!value.is_array()) {
    return value.dump();
  }
  std::vector<std::string> parts;
  std::ranges::transform(value, std::back_inserter(parts), plain);
  return "(" + joined(parts, ", ") + ")";
}

FirstDifference read_first_difference(const JsonReader& json) {
  FirstDifference first;
  first.level = json.count("level");
  first.iteration = json.count("iteration");
  first.x = json.count("x");
  first.y = json.count("y");
  for (const auto& [key, value] : json.json().items()) {
    if (key != "level" && key != "iteration" && key != "x" && key != "y") {
      std::string name = key;
      std::ranges::replace(name, '_', ' ');
      first.more += (first.more.empty() ? "" : ", ") + name + ' ' + plain(value);
    }
  }
  return first;
}

VerifyRow read_verify(const JsonReader& json) {
  VerifyRow row;
  row.scene = json.text("scene");
  row.width = json.count("width");
  row.height = json.count("height");
  row.backend = json.text("backend");
  row.device = json.text("device");
  row.method = json.has("method") ? json.text("method") : "";
  row.mode = json.text("mode", {"resync", "free"});
  row.levels = json.count("levels");
  row.iterations = json.count("iterations");
  row.sites_compared = json.count("sites_compared");
  row.sites_differing = json.count("sites_differing");
  row.certified_ties = json.count("certified_ties");
  row.uncertified = json.count("uncertified");
  row.not_finite = json.has("not_finite") ? json.count("not_finite") : 0;
  row.counts_differing = json.has("counts_differing") ? json.count("counts_differing") : 0;
  row.max_abs_difference = json.number_or_null("max_abs_difference");
  if (const auto first = json.object_or_null("first_difference")) {
    row.first_difference = read_first_difference(*first);
  }
  row.tier = read_tier(json);
  row.verdict = read_verdict(json);
  row.reason = json.text("reason");

  const bool passes = row.verdict == Verdict::agree || row.verdict == Verdict::certified;
  if (passes && row.sites_compared == 0) {
    json.fail("verdict", "is a pass although no site was compared");
  }
  if (row.verdict == Verdict::agree && row.sites_differing > 0) {
    json.fail("verdict", fmt::format("is \"agree\" although {} sites differ", row.sites_differing));
  }
  if (passes && row.counts_differing > 0) {
    json.fail("verdict",
              fmt::format("is a pass although {} counts of changed sites differ", row.counts_differing));
  }
  if (passes && row.uncertified > 0) {
    json.fail("verdict",
              fmt::format("is a pass although {} differing sites are uncertified", row.uncertified));
  }
  if (passes != (row.tier != Tier::none) ||
      (row.verdict == Verdict::certified) != (row.tier == Tier::certified)) {
    json.fail("tier", fmt::format("is \"{}\", which the verdict contradicts",
                                  tier_names[static_cast<std::size_t>(row.tier)]));
  }
  return row;
}

BenchRow read_bench(const JsonReader& json) {
  BenchRow row;
  row.scene = json.text("scene");
  row.width = json.count("width");
  row.height = json.count("height");
  row.backend = json.text("backend");
  row.device = json.text("device");
  row.method = json.text("method");
  row.iterations = json.count("iterations");
  row.seconds = json.numbers("seconds");
  row.seconds_median = json.number_or_null("seconds_median");
  row.msites_per_second = json.number_or_null("msites_per_second");
  row.setup_seconds = json.number_or_null("setup_seconds");
  row.projection_seconds = json.number_or_null("projection_seconds");
  row.upload_seconds = json.number_or_null("upload_seconds");
  row.compute_seconds = json.number_or_null("compute_seconds");
  row.readback_seconds = json.number_or_null("readback_seconds");
  row.speed_up_over_scalar = json.number_or_null("speed_up_over_scalar");
  row.valid = (!json.has("valid") || json.holds("valid")) && json.flag("valid"); // null: not compared
  row.reason = json.text("reason");

  if (!row.valid) {
    row.speed_up_over_scalar.reset();
    return row;
  }
  if (row.width == 0 || row.height == 0) {
    json.fail("width", "and \"height\" of a valid row must be at least 1");
  }
  require_samples(json, row.seconds, row.seconds_median);
  return row;
}

RunRow read_run(const JsonReader& json) {
  RunRow row;
  row.scene = json.text("scene");
  row.title = json.text("title");
  row.width = json.count("width");
  row.height = json.count("height");
  row.backend = json.text("backend");
  row.device = json.text("device");
  row.method = json.text("method");
  row.seconds = json.number("seconds");
  row.levels = json.count("levels");
  row.iterations = json.count("iterations");
  row.mean_energy = json.number_or_null("mean_energy");
  row.largest_displacement = json.number_or_null("largest_displacement");
  row.spacing = json.number("spacing");
  if (json.has("field")) { // not written by a build without images
    row.field = json.text("field");
  }
  if (!json.has("pictures")) {
    return row;
  }
  const JsonReader pictures = json.object("pictures");
  for (const char* const key : {"before", "after", "grid", "magnitude"}) {
    if (pictures.has(key)) {
      row.pictures.emplace(key, json.file().parent_path() / pictures.text(key));
    }
  }
  return row;
}

// An empty device (skipped: there was none) is any device of its backend.
bool same_device(const std::string& a, const std::string& b) {
  return a.empty() || b.empty() || a == b;
}

template <typename Row>
bool same_place(const Row& a, const Row& b) {
  return a.scene == b.scene && a.width == b.width && a.height == b.height && a.backend == b.backend &&
         same_device(a.device, b.device);
}

bool replaces(const DeviceRow&, const DeviceRow&) {
  return true;
}
bool replaces(const InstructionsRow&, const InstructionsRow&) {
  return true;
}
bool replaces(const VerifyRow& a, const VerifyRow& b) {
  return same_place(a, b) && a.mode == b.mode && a.method == b.method;
}
bool replaces(const BenchRow& a, const BenchRow& b) {
  return same_place(a, b) && a.method == b.method;
}
bool replaces(const GoldenRow& a, const GoldenRow& b) {
  return same_place(a, b) && a.method == b.method;
}
bool replaces(const RunRow& a, const RunRow& b) {
  return same_place(a, b) && a.method == b.method;
}
// Another Poisson ratio is another truth.
bool replaces(const AccuracyRow& a, const AccuracyRow& b) {
  return same_place(a, b) && a.method == b.method && a.variant == b.variant && a.poisson == b.poisson &&
         a.poisson_used == b.poisson_used;
}
bool replaces(const FailingCallsRow& a, const FailingCallsRow& b) {
  return a.backend == b.backend && a.api == b.api && a.kind == b.kind;
}
bool replaces(const TradeoffRow& a, const TradeoffRow& b) {
  return same_place(a, b) && a.method == b.method && a.effort == b.effort && a.poisson == b.poisson &&
         a.poisson_used == b.poisson_used;
}
bool replaces(const EqualAccuracyRow& a, const EqualAccuracyRow& b) {
  return a.scene == b.scene && a.width == b.width && a.height == b.height && a.target == b.target &&
         a.poisson == b.poisson;
}

bool replaces(const FaultRow& a, const FaultRow& b) {
  return a.fault == b.fault && a.backend == b.backend;
}
bool replaces(const AtlasRow& a, const AtlasRow& b) {
  return a.entry == b.entry;
}

// Rows of one file never replace each other. Only those of a `kind` where one is given.
template <typename Row>
void merge(Results& results, std::vector<Row>& rows, std::size_t context, const JsonReader& document,
           Row (*read)(const JsonReader&), const std::string& kind = {}) {
  for (const JsonReader& json : document.objects("results")) {
    if (!kind.empty() && json.text("kind", {"point", "equal accuracy"}) != kind) {
      continue;
    }
    Row row = read(json);
    row.context = context;
    ++results.contexts[context].rows;
    std::erase_if(rows, [&](const Row& older) {
      const bool gone = older.context != context &&
                        results.machine_of(older.context) == results.machine_of(context) &&
                        replaces(row, older);
      results.contexts[older.context].replaced += gone ? 1 : 0;
      return gone;
    });
    rows.push_back(std::move(row));
  }
}

struct Document {
  Path file;
  nlohmann::json json;
  Context context;
};

} // namespace

bool Results::is_software(const std::string& machine, const std::string& backend,
                          const std::string& device) const {
  return std::ranges::any_of(devices, [&](const DeviceRow& row) {
    return row.software && row.backend == backend && row.device == device &&
           machine_of(row.context) == machine;
  });
}

Results load_results(std::span<const Path> paths) {
  std::vector<Document> documents;
  for (const Path& file : result_files(paths)) {
    Document document{file, read_json(file), {}};
    document.context = read_context(JsonReader(document.json, file, ""));
    documents.push_back(std::move(document));
  }
  std::ranges::stable_sort(documents, {}, [](const Document& document) { return document.context.date; });

  Results results;
  for (const Document& document : documents) {
    const std::size_t context = results.contexts.size();
    results.contexts.push_back(document.context);
    const JsonReader reader(document.json, document.file, "");
    const std::string& command = document.context.command;
    if (command == "devices") {
      merge(results, results.devices, context, reader, read_device);
    } else if (command == "verify") {
      merge(results, results.verify, context, reader, read_verify);
    } else if (command == "faults") {
      merge(results, results.faults, context, reader, read_fault);
    } else if (command == "bench") {
      merge(results, results.bench, context, reader, read_bench);
    } else if (command == "run") {
      merge(results, results.run, context, reader, read_run);
    } else if (command == "accuracy") {
      merge(results, results.accuracy, context, reader, read_accuracy);
    } else if (command == "atlas") {
      merge(results, results.atlas, context, reader, read_atlas);
    } else if (command == "instructions") {
      merge(results, results.instructions, context, reader, read_instructions);
    } else if (command == "golden") {
      merge(results, results.golden, context, reader, read_golden);
    } else if (command == "failing-calls") {
      merge(results, results.failing_calls, context, reader, read_failing_calls);
    } else if (command == "tradeoff") {
      merge(results, results.tradeoff, context, reader, read_tradeoff, "point");
      merge(results, results.equal_accuracy, context, reader, read_equal_accuracy, "equal accuracy");
    }
    if (std::ranges::find(results.machines, document.context.machine) == results.machines.end()) {
      results.machines.push_back(document.context.machine);
    }
  }
  return results;
}

} // namespace hdmbench::report
