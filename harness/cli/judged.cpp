// The commands that judge methods against truths: accuracy, tradeoff, continuum and atlas.

#include "harness/cli/arguments.hpp"
#include "harness/judge/atlas/atlas.hpp"
#include "harness/judge/tradeoff.hpp"
#include "harness/scene/laws.hpp"

#include <cstdio>
#include <map>
#include <numeric>
#include <set>
#include <utility>

namespace hdmbench::commands {

namespace {

using std::string_view_literals::operator""sv;

const Option<std::vector<std::string>> accuracies("--at",
                                                  "Accuracies at which the fastest are compared: RMSD to FEM "
                                                  "with nu 0, of laws and\nloads with the scene's nu",
                                                  {"0.35px", "0.01px"});

/// "fem, nu 0.3", "icm on openmp", "icm: step set without 0".
std::string name_of(const Judged& row) {
  return fmt::format("{}{}{}", row.method,
                     row.poisson_used ? fmt::format(", nu {:.2g}", *row.poisson_used) : "",
                     !row.variant.empty()   ? ": " + row.variant
                     : !row.backend.empty() ? " on " + row.backend
                                            : "");
}

/// A table of rows as to_json() has them.
std::string judged_table(const json& rows) {
  return table_text(rows, "method|variant|poisson_used:nu|backend|effort|seconds_median:time|"
                          "rmsd_to_fem:px to FEM|estimated_error:estimated|status|rmsd_to_fem_nu0:nu 0|"
                          "rmsd_to_fixed_point:fixed point|mean_energy|iterations|asked:px asked");
}

/// What is not ok: a line for each status and reason.
std::string failures_text(const std::vector<Judged>& rows) {
  std::map<std::pair<JudgedStatus, std::string>, std::set<std::string>> failed;
  for (const Judged& row : rows) {
    if (row.status != JudgedStatus::ok) {
      failed[{row.status, row.reason}].insert(name_of(row));
    }
  }
  std::string text;
  for (const auto& [why, names] : failed) {
    text += fmt::format("  {}: {}: {}\n", hdmbench::name_of(why.first), joined(names, ", "), why.second);
  }
  return text;
}

void print_published(const Scene& scene) {
  for (const json& row : published()["accuracy"]) {
    if (row["scene"] == scene.name && scene.extent() == Extent{300, 300}) {
      constexpr std::string_view measured =
          "{rmsd} px to FEM, mean energy {mean_energy}, {iterations} iterations, ";
      fmt::print("{}{}{}", row_text("  thesis, table {table}: {method} ", row),
                 row.contains("rmsd") ? row_text(measured, row) : "", row_text("{seconds} s\n", row));
    }
  }
}

/// Measures every scene; `show` prints its rows, given what to_result() makes of them, and may add more to
/// the results.
template <typename ToResult, typename Show>
int judge_scenes(const Call& call, const std::vector<std::string>& by_default, JudgeOptions options,
                 decltype(measure_accuracy)* measure, const ToResult& to_result, const Show& show) {
  const auto registry = make_backends();
  const std::vector<const Backend*> backends = choose_backends(call, registry);
  Progress progress;
  json results = json::array();
  bool sound = true;
  for (const Scene& scene : load_scenes(call, by_default)) {
    const auto with = [&](const std::vector<Judged>& rows) {
      json all = results;
      std::ranges::transform(rows, std::back_inserter(all),
                             [&](const Judged& row) { return to_result(scene, row); });
      return all;
    };
    options.heard = [&](const std::vector<Judged>& rows) { call.keep(with(rows)); };
    const std::vector<Judged> rows = measure(scene, backends, options, progress);
    progress.clear();
    fmt::print("\n{}, {}: {}\n", scene.name, scene.extent().text(), scene.title);
    const auto before = std::ssize(results);
    results = with(rows);
    show(scene, rows, json(json::array_t(results.begin() + before, results.end())), results);
    fmt::print("{}", failures_text(rows));
    sound = sound && std::ranges::none_of(rows, [&](const Judged& row) {
              return row.status == JudgedStatus::unverified ||
                     (row.status == JudgedStatus::failed && measure == measure_accuracy);
            });
    std::fflush(stdout); // into a pipe too: the next scene may take long
  }
  call.write(std::move(results));
  return sound ? success : disagreement;
}

int run_accuracy(Call& call) {
  call.schedule.meets_truths = true;
  const std::vector<std::string> by_default{"square",   "square-modified", "square-single-level",
                                            "circular", "circular-radial", "brain"};
  const auto is_of_cells = [](const Scene& scene) { return scene.energy->is_of_cells(); };
  if (call.schedule.given.contains("iterations") &&
      std::ranges::any_of(load_scenes(call, by_default), is_of_cells)) {
    throw InputError("accuracy takes every elastic method at its usual effort; leave out --iterations");
  }
  JudgeOptions options{.session = call.session(),
                       .repeats = call[option::repeat],
                       .charted = call[option::backends],
                       .quick = call[option::quick]};
  if (!call[option::json].empty() && have_images()) {
    options.pictures = std::filesystem::absolute(call[option::json]).parent_path();
  }
  fmt::print(
      "RMSD over all sites but void, in pixels. Interfaces, elsewhere: to FEM with the scene's nu, over\n"
      "the free sites within 5 px of two materials and over all other free sites.\n");
  const auto to_result = [](const Scene& scene, const Judged& row) { return to_json(scene, row); };
  return judge_scenes(call, by_default, options, measure_accuracy, to_result,
                      [](const Scene& scene, const std::vector<Judged>& rows, json own, json& /*results*/) {
                        print_published(scene);
                        std::erase_if(own.get_ref<json::array_t&>(),
                                      [](const json& row) { return row["seconds"].empty(); });
                        fmt::print("{}", judged_table(own));
                        for (const Judged& row : rows) {
                          if (row.variant.empty() && !row.note.empty()) {
                            fmt::print("  {}: {}\n", name_of(row), row.note);
                          }
                        }
                      });
}

/// `equal`: as compare_at has it.
void print_equal_accuracy(const json& equal) {
  constexpr std::string_view at = "  At {target:.3g} px to {against}: ";
  const json& ours = equal["ours"];
  if (ours.is_null()) {
    if (!equal["nearest"].is_null()) {
      fmt::print("{}{}", row_text(at, equal),
                 row_text("no method is that near; the nearest is {nearest:.3g} px away.\n", equal));
    }
    return;
  }
  fmt::print("{}{}", row_text(at, equal),
             row_text("{method}, {effort} on {backend} is the fastest, {seconds_median_text};\n", ours));
  for (const auto& [key, title] : {std::pair("direct", "direct FEM"),
                                   {"iterative", "FEM by conjugate gradients"},
                                   {"multigrid", "FEM by multigrid of others"},
                                   {"coarse", "FEM on a coarse mesh"},
                                   {"positions", "position-based dynamics"}}) {
    const json& rival = equal[key];
    const bool is_meant =
        equal["against"] == "FEM nu 0" ? key != "positions"sv : key == "direct"sv || key == "positions"sv;
    if (is_meant || !rival.is_null()) {
      fmt::print("    {} {}\n", title,
                 rival.is_null()
                     ? "was not measured, or is nowhere that near."
                     : row_text("({effort}, {seconds_median_text}) takes {ratio:.3g} times as long.", rival));
    }
  }
}

/// The line that repeats a point: `run` solves by methods, this command by rivals.
std::string repeat(const Call& call, const Scene& scene, const Judged& row) {
  const std::string law = row.variant == linear_law ? std::string(law_names().front()) : call[option::law];
  const std::string where =
      fmt::format("{}{}{}", shell_word(scene.source), size_words(scene), law.empty() ? "" : " --law " + law);
  if (row.is_rival) {
    return fmt::format("hdmbench tradeoff {} --methods {}{}", where, row.method,
                       schedule_words(call.schedule));
  }
  const std::string how = row.asked ? fmt::format("--energy elastic --accuracy {}px --explain", *row.asked)
                                    : fmt::format("--method {} --iterations {}", row.method, *row.told);
  ScheduleOverrides schedule = call.schedule;
  if (row.poisson_used && *row.poisson_used != scene.elastic.poisson) {
    schedule.given["poisson"] = fmt::format("{}", *row.poisson_used);
  }
  return fmt::format("hdmbench run {} --backend {} {}{}{}", where, row.backend, how,
                     row.backend == "scalar" ? "" : session_words(call.session()), schedule_words(schedule));
}

int run_tradeoff(Call& call) {
  call.schedule.meets_truths = true;
  std::vector<double> targets;
  std::ranges::transform(call[accuracies], std::back_inserter(targets),
                         [](const std::string& text) { return parse_pixels(text); });
  JudgeOptions options{.session = call.session(),
                       .repeats = call[option::repeat],
                       .charted = call[option::backends],
                       .methods = std::exchange(call[option::methods], {}), // load_scenes knows no rivals
                       .quick = call[option::quick]};
  if (options.methods == std::vector<std::string>{"all"}) {
    options.methods.clear();
  }
  fmt::print(
      "Times are medians of up to {} samples of a whole solution, after one that compiles programs and is\n"
      "not timed. RMSD to finite elements and to the fixed point over all sites but void, in pixels. Shown\n"
      "of the points are the front, and what was asked for.\n",
      options.repeats);
  std::vector<std::string> by_default{"square", "circular", "circular-radial", "brain"};
  by_default.resize(call[option::quick] ? 1 : by_default.size());
  const auto to_result = [&](const Scene& scene, const Judged& row) {
    json result = to_json(scene, row);
    result["kind"] = "point";
    result["command"] = repeat(call, scene, row);
    return result;
  };
  return judge_scenes(
      call, by_default, options, measure_tradeoff, to_result,
      [&](const Scene& scene, const std::vector<Judged>& rows, const json& own, json& results) {
        json shown = json::array();
        for (std::size_t i = 0; i < rows.size(); ++i) {
          if (!rows[i].seconds.empty() &&
              (rows[i].is_on_front || rows[i].asked || !rows[i].variant.empty())) {
            shown.push_back(own[i]);
          }
        }
        std::ranges::sort(shown.get_ref<json::array_t&>(), {},
                          [](const json& row) { return row["seconds_median"].get<double>(); });
        fmt::print("{}", judged_table(shown));
        for (const double target : targets) {
          print_equal_accuracy(results.emplace_back(compare_at(scene, rows, target)));
        }
      });
}

const Option<std::vector<int>> sides("--sizes", "Sides of the images, several with commas",
                                     {50, 75, 100, 150, 200, 300, 400, 600}, CLI::Range(8, 4096));

/// Moduli of the inclusion over that around it.
constexpr std::array contrasts{0.1, 3.0, 10.0, 100.0};

int run_continuum(Call& call) {
  std::vector<int> sizes = call[option::quick] ? std::vector{50, 100, 200} : call[sides];
  std::ranges::sort(sizes);
  const auto registry = make_backends();
  const Backend& backend = find_backend(registry, call[option::backend]);
  Progress progress;
  progress.set_total(contrasts.size() * std::inner_product(sizes.begin(), sizes.end(), sizes.begin(), 0.0));
  json rows = json::array();
  for (const double contrast : contrasts) {
    const json more = measure_continuum(contrast, sizes, backend, call.session(), progress);
    rows.insert(rows.end(), more.begin(), more.end());
    call.keep(rows);
  }
  progress.clear();
  fmt::print(
      "A sheet with a round inclusion, stretched by 50 px, whose displacement is known in closed form. RMSD\n"
      "in pixels. Discretisation: finite elements on the pixels, direct and in double, from the closed "
      "form.\n"
      "Algebraic: our field at its usual effort from these finite elements; float32: when it rests. Order:\n"
      "of discretisation, since the first size.\n\n{}",
      table_text(rows, "contrast|size|discretisation.rmsd:discretisation|order|algebraic.rmsd:algebraic|"
                       "rounding.rmsd:float32|total.rmsd:our field in all|total.largest:largest"));
  call.write(std::move(rows));
  return success;
}

const Option<std::vector<std::string>> entries("entries", "Entries by name (none: all; see --list)");

/// A row a value of the knob, a column a method.
void print_entry(const atlas::EntryResult& result) {
  const atlas::Entry& entry = *result.entry;
  json rows = json::array();
  std::string columns = fmt::format("knob:{}", entry.knob);
  for (std::size_t of = 0; of < result.series.size(); ++of) {
    const atlas::SeriesResult& series = result.series[of];
    const std::string key = fmt::format("series{}", of);
    columns += fmt::format("|{}:{}", key, series.name);
    for (std::size_t i = 0; i < series.points.size(); ++i) {
      const atlas::Point& point = series.points[i];
      json& row = i < rows.size() ? rows[i] : rows.emplace_back();
      row["knob"] = fmt::format("{:.6g}", point.knob);
      row[key] =
          (point.error ? fmt::format("{:.3g}", *point.error) : "not finite") + (point.failed ? " !" : "");
      std::set<std::string> warned = row.value("warned", std::set<std::string>{});
      warned.insert(point.warnings.begin(), point.warnings.end());
      row["warned"] = warned;
    }
  }
  fmt::print("\n{}: {}\n  why        {}\n  measured   {}; ! is more than {:.6g}\n{}\n{}  survives   {}\n",
             entry.name, entry.title, entry.mechanism, entry.measure, entry.limit,
             table_text(rows, columns + "|warned:warned of"),
             table_text(result.series, "name:method|last_good|first_failed|absence:refuses"), entry.survivor);
  std::fflush(stdout); // into a pipe too: the next entry may take seconds
}

int run_atlas(Call& call) {
  if (call[option::list]) {
    json rows = json::array();
    for (const atlas::Entry& entry : atlas::entries()) {
      rows.push_back({{"entry", entry.name}, {"title", entry.title}, {"knob", entry.knob}});
    }
    fmt::print("{}", table_text(rows, "entry|title:what fails|knob"));
    return success;
  }
  std::vector<const atlas::Entry*> chosen;
  for (const std::string& name : call[entries]) {
    chosen.push_back(&atlas::find_entry(name));
  }
  if (chosen.empty()) {
    std::ranges::transform(atlas::entries(), std::back_inserter(chosen),
                           [](const atlas::Entry& entry) { return &entry; });
  }
  const auto registry = make_backends();
  const Backend& backend = find_backend(registry, call[option::backend]);
  Progress progress;
  double total = 0.0;
  for (const atlas::Entry* const entry : chosen) {
    total += static_cast<double>((call[option::quick] ? entry->quick_knobs : entry->knobs).size());
  }
  progress.set_total(total);
  json rows = json::array();
  for (const atlas::Entry* const entry : chosen) {
    const atlas::EntryResult result = atlas::run_entry(*entry, backend, call[option::quick], progress);
    progress.clear();
    print_entry(result);
    if (!call[option::json].empty()) {
      rows.push_back(atlas::atlas_row(result, std::filesystem::absolute(call[option::json]).parent_path()));
      call.keep(rows);
    }
  }
  call.write(std::move(rows));
  return success;
}

} // namespace

void add_accuracy(CLI::App& program, Call& call) {
  add_command(
      program, call, "accuracy", run_accuracy,
      "Measure every method against the truths.\n"
      "Measure every method against finite elements and the exact fixed point: Tables 5.1, 5.3, 5.5 and\n"
      "5.7 of the thesis by default, and a brain. Exit status 1 where a field is not scalar's to the bit.",
      {comparison_options().without({"--method", "--methods", "--update", "--stop", "--epsilon"}),
       Options(option::repeat, "Samples of the seconds, fewer where they take long")});
}

void add_tradeoff(CLI::App& program, Call& call) {
  add_command(
      program, call, "tradeoff", run_tradeoff,
      "Chart speed against accuracy, with rivals.\n"
      "Speed against accuracy: every method at several efforts, and its rivals (finite elements direct, by\n"
      "conjugate gradients and on a coarse mesh, interpolation), timed and measured against the truths.\n"
      "Prints the Pareto front per scene; the report draws the chart. Exit status 1 where a field is not\n"
      "scalar's to the bit.",
      {comparison_options().without({"--method", "--iterations", "--update", "--steps"}), option::law,
       accuracies, Options(option::repeat, "Samples per point, fewer where they take long", 5)});
}

void add_continuum(CLI::App& program, Call& call) {
  add_command(program, call, "continuum", run_continuum,
              "How far is a mesh of pixels from the continuum?\n"
              "How far a mesh of pixels is from the continuum: a round inclusion whose displacement is known "
              "exactly,\n"
              "on meshes of several sizes; errors of discretisation, of the solver and of float32 apart.",
              {sides, backend_options(), Options(option::quick, "Three sizes to 200; the results say so"),
               option::json},
              {"--quick excludes --sizes"});
}

void add_atlas(CLI::App& program, Call& call) {
  add_command(program, call, "atlas", run_atlas,
              "Where the methods fail, and what survives.\n"
              "Where the methods fail: families of scenes along one knob each, from healthy to harmful, the "
              "error of every\n"
              "method, from where on it fails, how that shows, and what survives.",
              {option::list, entries,
               Options(option::backend, "Where it is computed; the bits are the same everywhere", "scalar"),
               Options(option::quick, "Fewer values of every knob; the results say so"),
               Options(option::json, "Write the results to this file, pictures beside it")},
              {"--list excludes entries --backend --quick --json"});
}

} // namespace hdmbench::commands
