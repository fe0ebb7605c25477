#include "harness/measure/bench.hpp"

#include "backends/shared/stopwatch.hpp"
#include "harness/check/compare.hpp"
#include "harness/check/verify.hpp"
#include "harness/measure/bench_case.hpp"
#include "harness/measure/median.hpp"
#include "harness/scene/method.hpp"
#include "harness/scene/row_fields.hpp"
#include "kernels/data/input_error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <ostream>
#include <utility>

namespace hdmbench {

using nlohmann::json;

namespace {

/// Shaders are compiled, or specialised for a size, when they first run: let every level run once, and twice
/// with what the elastic energy does from its second cycle on. A copy of the scene would need its memory.
void warm_up(Scene& scene, Solver& solver) {
  const Schedule schedule = scene.schedule;
  scene.schedule.iterations = std::min(schedule.iterations, 2);
  scene.schedule.growth = 0.0;
  scene.schedule.stop = Stop::fixed;
  Progress silent(false);
  try {
    (void)solver.solve(scene, silent);
  } catch (...) {
    scene.schedule = schedule;
    throw;
  }
  scene.schedule = schedule;
}

json in_giga(std::vector<double> rates) {
  std::ranges::for_each(rates, [](double& rate) { rate *= giga; });
  return rates;
}

json new_row(const Scene& scene, const Backend& backend, const SessionOptions& session) {
  const bool is_dense = session.work == Work::dense;
  const int threads = backend.threads(session);
  json row = with_size({{"scene", scene.name},
                        {"backend", backend.name()},
                        {"device", ""},
                        {"driver", ""},
                        {"energy", scene.energy->name},
                        {"method", method_name(scene) + (is_dense ? "" : "-active")},
                        {"work", work_names.at(static_cast<std::size_t>(session.work))},
                        {"threads", threads > 0 ? json(threads) : json()},
                        {"effort", scene.schedule.iterations},
                        {"seconds", json::array()},
                        {"valid", false},
                        {"reason", ""}},
                       scene.extent());
  for (const char* const key :
       {"iterations", "fine_sweep_equivalents", "seconds_median", "msites_per_second", "setup_seconds",
        "projection_seconds", "upload_seconds", "compute_seconds", "readback_seconds"}) {
    row[key] = 0;
  }
  for (const char* const key :
       {"reference", "speed_up_over_scalar", "speed_up_over_dense", "peak_memory_bytes", "bytes_per_site",
        "bytes_per_site_update", "operations_per_site_update", "gigabytes_per_second",
        "gigaoperations_per_second", "percent_of_ceiling", "binding", "ceiling", "processor_seconds",
        "solutions_per_sample", "spread_percent"}) {
    row[key] = nullptr;
  }
  return row;
}

/// Sets the counters of a repetition of so many solutions, each of so many site updates.
void count(benchmark::UserCounters& counters, const Timings& sum, double solutions, double updates,
           const std::optional<SolutionCost>& cost, const std::optional<Ceilings>& most, json& row) {
  for (const auto& [key, part] : parts) {
    if (sum.*part > 0.0) { // of samples that are all 0 the library writes a deviation that is no JSON
      counters[key] = sum.*part / solutions;
    }
  }
  const double compute = sum.compute / solutions;
  if (compute <= 0.0) {
    return;
  }
  counters["site_updates_per_second"] = updates / compute;
  if (cost && updates > 0.0) {
    row["bytes_per_site_update"] = cost->bytes / updates;
    row["operations_per_site_update"] = cost->operations / updates;
    counters["bytes_per_second"] = cost->bytes / compute;
    counters["operations_per_second"] = cost->operations / compute;
  }
  if (cost && most) {
    const CeilingShare share = ceiling_share(*cost, *most, compute);
    row["binding"] = share.binding;
    counters["percent_of_ceiling"] = share.percent;
  }
}

} // namespace

Bench::Bench(Progress& progress) : progress_(progress) {}

Bench::~Bench() {
  benchmark::ClearRegisteredBenchmarks(); // they refer to the cases
}

void Bench::add(const Load& load, const Plan& plan) {
  const std::size_t place = places_.size();
  places_.push_back({.load = load, .options = {}});
  progress_.describe("prepare a scene");
  scene_.reset();
  const std::size_t resident = resident_bytes();
  scene_ = load();
  if (!scene_) {
    places_.pop_back();
    return;
  }
  const std::size_t now = resident_bytes();
  loaded_ = place;
  const Scene& scene = *scene_;
  Place& made = places_.back();
  made.options = plan(scene);
  made.name = fmt::format("{} {}", scene.name, scene.extent().text());
  made.levels = level_work(scene);
  made.scene_bytes = now - std::min(now, resident);

  const BenchOptions& options = made.options;
  const bool may_skip = why_left_out(Mode::active, scene).empty();
  for (const Backend* backend : options.backends) {
    const auto add_run = [&](int threads, Work work) {
      SessionOptions session = options.session;
      session.threads = threads;
      session.work = work;
      add_case(scene, place, *backend, std::move(session));
    };
    const bool is_reference = options.checked && backend == options.backends.front();
    const bool scales = backend->threads({.device = {}, .threads = 2}) == 2;
    for (int count = 1; options.scaling && scales && count < backend->threads(options.session); count *= 2) {
      add_run(count, Work::dense); // the run with all of them follows
    }
    const bool skips = options.active && may_skip && backend->skips();
    if (options.dense || is_reference || !skips) {
      add_run(options.session.threads, Work::dense);
    }
    if (skips) {
      add_run(options.session.threads, Work::active);
    }
  }
}

void Bench::add_case(const Scene& scene, std::size_t place, const Backend& backend, SessionOptions session) {
  const BenchOptions& options = places_[place].options;
  json row = new_row(scene, backend, session);
  if (options.command) {
    row["command"] = options.command(scene, backend, session);
  }
  std::string name =
      fmt::format("{}/{}/{}/{}/{}/{}", scene.name, scene.extent().text("x"), scene.energy->name,
                  method_name(scene), backend.name(), row["work"].get<std::string>());
  if (!row["threads"].is_null()) {
    name += fmt::format("/threads:{}", row["threads"].get<int>());
  }
  const bool is_first =
      std::ranges::none_of(cases_, [&](const auto& one) { return one->place == place && one->is_reference; });
  register_case({.name = std::move(name),
                 .place = place,
                 .backend = &backend,
                 .session = std::move(session),
                 .is_reference = options.checked && &backend == options.backends.front() && is_first,
                 .refusal = why_not_solved(scene, backend),
                 .row = std::move(row)});
}

void Bench::register_case(Case made) {
  while (std::ranges::any_of(cases_, [&](const auto& other) { return other->name == made.name; })) {
    made.name += "/again"; // another scene of this name, or one that was asked for twice
  }
  Case& one = *cases_.emplace_back(std::make_unique<Case>(std::move(made)));
  const auto run = [this, &one](benchmark::State& state) {
    try {
      if (!one.refusal.empty()) {
        state.SkipWithError(one.refusal.c_str());
      } else if (one.kernels) {
        measure_kernel(one, state);
      } else {
        measure(one, state);
      }
    } catch (const DeviceError& error) {
      state.SkipWithError(error.what());
    }
  };
  benchmark::RegisterBenchmark(one.name.c_str(), run)
      ->UseManualTime()
      ->MeasureProcessCPUTime()
      ->Unit(benchmark::kMillisecond);
}

Scene& Bench::scene_of(std::size_t place) {
  if (!scene_ || loaded_ != place) {
    expected_ = VectorField();
    scene_.reset(); // before the next one needs the room
    const std::size_t resident = resident_bytes();
    scene_ = places_[place].load();
    if (!scene_) {
      throw InputError(fmt::format("{}: its files are gone", places_[place].name));
    }
    const std::size_t now = resident_bytes();
    places_[place].scene_bytes = now - std::min(now, resident);
    loaded_ = place;
  }
  return *scene_;
}

std::optional<Ceilings> Bench::ceilings_of(const Case& one) {
  const auto [found, is_new] = ceilings_.try_emplace(
      {std::string(one.backend->name()), one.backend->threads(one.session)}, std::nullopt);
  if (is_new) {
    progress_.describe(fmt::format("what {} can do at most", one.backend->name()));
    try {
      found->second = one.backend->ceilings(one.session);
    } catch (const DeviceError&) { // then there are none
    }
  }
  return found->second;
}

void Bench::set_ceilings(Case& one) {
  if (!places_[one.place].options.ceilings) {
    return;
  }
  one.most = ceilings_of(one);
  if (one.most) {
    one.row["ceiling"] = {{"copy_gigabytes_per_second", median(one.most->copy_bytes_per_second) * giga},
                          {"gigaoperations_per_second", median(one.most->operations_per_second) * giga},
                          {"copy_samples", in_giga(one.most->copy_bytes_per_second)},
                          {"operation_samples", in_giga(one.most->operations_per_second)}};
  }
}

void Bench::open(Case& one, Scene& scene) {
  Place& place = places_[one.place];
  const Device device = one.backend->device(one.session);
  one.row.update({{"device", device.name}, {"driver", device.driver}});
  if (one.is_dense()) {
    if (scene.energy->is_of_cells() && place.steps.empty()) {
      place.steps = steps_taken(scene, progress_);
    }
    one.cost = scene.energy->is_of_cells() ? std::optional(solution_cost(place.steps, *one.backend, device))
                                           : solution_cost(place.levels, *one.backend, device, scene.full);
    set_ceilings(one);
  }
  one.resident = resident_bytes();
  one.memory.emplace();
  double setup = 0.0;
  one.solver = std::make_unique<Solver>(*one.backend, one.session);
  timed(setup, [&] { warm_up(scene, *one.solver); });
  one.row["setup_seconds"] = setup;
}

void Bench::measure(Case& one, benchmark::State& state) {
  Scene& scene = scene_of(one.place);
  if (!one.solver) {
    open(one, scene);
  }
  progress_.describe(fmt::format("bench {}", one.name));
  Timings sum;
  Solution solution;
  for (const auto& turn : state) {
    (void)turn;
    solution = Solution(); // before the next one needs the room
    solution = one.solver->solve(scene, progress_);
    state.SetIterationTime(solution.timings.total());
    sum.add(solution.timings);
  }
  const auto solutions = static_cast<double>(state.iterations());
  const auto sites = static_cast<double>(scene.extent().sites());
  const double updates = total_site_updates(solution.levels);
  one.row.update(
      {{"iterations", total_iterations(solution.levels)}, {"fine_sweep_equivalents", updates / sites}});
  if (const std::optional<std::size_t> peak = one.memory->bytes()) {
    const std::size_t taken = *peak - std::min(*peak, one.resident) + places_[one.place].scene_bytes;
    one.row.update({{"peak_memory_bytes", *peak}, {"bytes_per_site", static_cast<double>(taken) / sites}});
  }
  count(state.counters, sum, solutions, updates, one.cost, one.most, one.row);
  if (const Case* const first = measured(one.place, [](const Case& other) { return other.is_reference; })) {
    state.counters["speed_up"] = first->row["seconds_median"].get<double>() * solutions / sum.total();
  }
  state.SetLabel(
      fmt::format("{}, {}", one.row["device"].get<std::string>(), one.row["driver"].get<std::string>()));
  if (const std::string why = why_wrong(one, scene, solution.displacement); !why.empty()) {
    one.row["seconds"].push_back(sum.total() / solutions);
    one.row["seconds_median"] = median(one.row["seconds"]);
    state.SkipWithError(why.c_str());
  }
}

std::string Bench::why_wrong(Case& one, Scene& scene, const VectorField& found) {
  const BenchOptions& options = places_[one.place].options;
  if (!options.checked) {
    one.row.update({{"valid", nullptr}, {"reason", "not checked against scalar"}});
    return "";
  }
  const Backend& reference = *options.backends.front();
  one.row["reference"] = reference.name();
  if (expected_.extent != found.extent) {
    expected_ = one.is_reference ? found : VectorField();
  }
  if (expected_.extent != found.extent) { // its case was filtered out, or comes later
    SessionOptions session = options.session;
    session.work = Work::dense;
    try {
      expected_ = Solver(reference, session).solve(scene, progress_).displacement;
    } catch (const DeviceError& error) {
      return fmt::format("{} did not run, so there is nothing to check against", reference.name());
    }
  }
  if (const FieldDifference apart = compare(expected_, found); apart.sites != 0) {
    return fmt::format("{} sites differ from {}, by up to {:.3g} px", apart.sites, reference.name(),
                       apart.largest);
  }
  one.row["valid"] = true;
  return "";
}

const Bench::Case* Bench::measured(std::size_t place, const std::function<bool(const Case&)>& fits) const {
  const auto found = std::ranges::find_if(
      cases_, [&](const auto& one) { return one->place == place && one->is_measured() && fits(*one); });
  return found == cases_.end() ? nullptr : found->get();
}

void Bench::compare_speeds(Case& one) const {
  const auto times_as_long = [&](const Case* other) -> json {
    if (other == nullptr || !one.is_measured() || one.row["valid"] == false) {
      return nullptr;
    }
    return other->row["seconds_median"].get<double>() / one.row["seconds_median"].get<double>();
  };
  if (one.row["reference"] == "scalar") {
    one.row["speed_up_over_scalar"] =
        times_as_long(measured(one.place, [](const Case& other) { return other.is_reference; }));
  }
  if (!one.is_dense()) {
    one.row["speed_up_over_dense"] = times_as_long(measured(one.place, [&](const Case& other) {
      return other.is_dense() && other.backend == one.backend && other.row["threads"] == one.row["threads"] &&
             other.row["valid"] == one.row["valid"];
    }));
  }
}

} // namespace hdmbench
