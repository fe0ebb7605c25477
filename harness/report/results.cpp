#include "harness/report/results.hpp"

#include "harness/choices.hpp"
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

std::string read_choice(const JsonReader& json) {
  Choice choice{.what = json.text("what"), .options = {}};
  const std::string chosen = json.text("chosen");
  bool found = false;
  for (const JsonReader& option : json.objects("options")) {
    choice.options.push_back(
        {.name = option.text("name"), .coarse_group = 0, .seconds = option.numbers("seconds")});
    if (choice.options.back().seconds.empty()) {
      option.fail("seconds", "is empty");
    }
    if (choice.options.back().name == chosen) {
      choice.chosen = choice.options.size() - 1;
      found = true;
    }
  }
  if (!found) {
    json.fail("chosen", "is none of the options");
  }
  return describe(choice);
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
  if (json.has("choices")) { // older files have none
    for (const JsonReader& choice : json.objects("choices")) {
      row.choices.push_back(read_choice(choice));
    }
  }
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
// With other threads it is another timing, unless one of the two does not tell.
bool replaces(const BenchRow& a, const BenchRow& b) {
  return same_place(a, b) && a.method == b.method && (!a.threads || !b.threads || a.threads == b.threads);
}
bool replaces(const CompareRow& a, const CompareRow& b) {
  return same_place(a, b) && a.method == b.method && a.threads == b.threads;
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
    } else if (command == "compare") {
      merge(results, results.compare, context, reader, read_compare);
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
