#include "harness/judge/tradeoff.hpp"

#include "harness/check/faults/faulty_backend.hpp"
#include "harness/scene/method.hpp"
#include "test/sessions.hpp"

namespace hdmbench {
namespace {

Judged point(const char* method, std::vector<double> seconds, double error, bool rival) {
  Judged result;
  result.method = method;
  result.seconds = std::move(seconds);
  result.deviations.to_fem_no_poisson = error;
  result.is_rival = rival;
  result.poisson_used = rival ? std::optional(0.0) : std::nullopt;
  return result;
}

TEST(ParetoFront, WhatIsNoResultIsNeverOnIt) {
  std::vector<Judged> rows{point("icm", {1.0}, 1.0, false), point("icm", {0.1}, NAN, false),
                           point("icm", {0.1}, HUGE_VAL, false), point("icm", {}, 0.0, false),
                           point("icm", {0.1}, 0.0, false)};
  rows.back().status = JudgedStatus::unverified;
  mark_front(rows);
  EXPECT_TRUE(rows.front().is_on_front);
  EXPECT_EQ(std::ranges::count(rows, true, &Judged::is_on_front), 1);
}

TEST(ParetoFront, RandomRowsAreBeatenOrOnIt) {
  std::mt19937 engine(11);
  std::vector<Judged> rows;
  for (int i = 0; i < 300; ++i) {
    const auto seconds = static_cast<double>(engine() % 50);
    rows.push_back(point("icm", {seconds}, static_cast<double>(engine() % 50), false));
  }
  mark_front(rows);
  const auto cost = [](const Judged& row) { return row.seconds.front(); };
  const auto error = [](const Judged& row) { return row.deviations.to_fem_no_poisson; };
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const bool is_beaten = std::ranges::any_of(rows, [&](const Judged& other) {
      const bool is_better = cost(other) < cost(rows[i]) || error(other) < error(rows[i]);
      const bool is_equal = cost(other) == cost(rows[i]) && error(other) == error(rows[i]);
      return (cost(other) <= cost(rows[i]) && error(other) <= error(rows[i]) && is_better) ||
             (is_equal && &other < &rows[i]);
    });
    EXPECT_EQ(rows[i].is_on_front, !is_beaten) << i;
  }
}

class Tradeoff : public testing::Test {
protected:
  std::vector<Judged> measured(const std::vector<const Backend*>& backends,
                               const std::vector<std::string>& names,
                               const std::vector<std::string>& charted = {}) {
    JudgeOptions options;
    options.charted = charted;
    options.repeats = 2;
    options.methods = names;
    return measure_tradeoff(scene_, backends, options, progress_);
  }
  // The points of icm on one backend.
  static std::vector<Judged> on(const std::vector<Judged>& tradeoff, std::string_view backend) {
    std::vector<Judged> points;
    std::ranges::copy_if(tradeoff, std::back_inserter(points),
                         [&](const Judged& point) { return point.backend == backend; });
    return points;
  }

  const Backend& scalar_ = test::scalar();
  const Backend& openmp_ = test::find("openmp");
  Scene scene_ = load_scene("circular", {.size = Extent{32, 32}});
  Progress progress_{false};
};

TEST_F(Tradeoff, MeasuresMethodsAtAllEffortsAndTheirRivals) {
  for (const auto& [name, extent] : {std::pair{"circular", Extent{32, 32}}, {"ball", {12, 11, 13}}}) {
    SCOPED_TRACE(name);
    scene_ = load_scene(name, {.size = extent});
    const std::vector<Judged> tradeoff =
        measured({&scalar_, &openmp_}, {"icm", "fem", "fem-cg", "interpolation"});
    std::set<std::string> efforts_seen;
    double before = 0.0;
    for (const Judged& point : on(tradeoff, "openmp")) {
      EXPECT_EQ(point.status, JudgedStatus::ok) << point.reason;
      EXPECT_GT(*point.fine_sweep_equivalents, before);
      before = *point.fine_sweep_equivalents;
      efforts_seen.insert(point.effort);
    }
    EXPECT_EQ(efforts_seen.size(), 4U) << "5, 20, 200 and the scene's own iterations";
    EXPECT_EQ(on(tradeoff, "scalar").size(), 1U) << "the usual effort only";
    for (const Judged& point : on(tradeoff, "")) {
      EXPECT_TRUE(point.is_rival);
      EXPECT_EQ(point.status, JudgedStatus::ok) << point.method << ": " << point.reason;
      EXPECT_TRUE(point.seconds.size() == 2U || extent.axes() == 3) << "fewer samples of what takes long";
      const bool is_truth = point.method == "fem" && point.poisson_used == 0.0;
      EXPECT_EQ(point.deviations.to_fem_no_poisson < 1e-12, is_truth) << point.method << point.effort;
      if (point.effort == "tolerance 1e-06" && point.poisson_used == 0.0) {
        EXPECT_LT(point.deviations.to_fem_no_poisson, 1e-3);
      }
    }
    EXPECT_EQ(std::ranges::count_if(tradeoff, [](const auto& point) { return point.method == "fem-cg"; }), 6);
  }
}

TEST_F(Tradeoff, ChartsTheBackendsThatWereNamed) {
  const std::vector<Judged> tradeoff = measured({&scalar_, &openmp_}, {"icm", "sequential"}, {"scalar"});
  EXPECT_EQ(on(tradeoff, "scalar").size(), 7U) << "all efforts of both methods: 4 and 3";
  EXPECT_EQ(on(tradeoff, "openmp").size(), 2U) << "the usual effort only";
  const std::vector<Judged> both = measured({&scalar_, &openmp_}, {"icm"}, {"openmp", "scalar"});
  EXPECT_EQ(on(both, "scalar").size(), 4U);
  EXPECT_EQ(on(both, "openmp").size(), 4U);
  for (const Judged& point : both) {
    EXPECT_EQ(point.status, JudgedStatus::ok) << point.reason;
  }
}

/// The thesis's energy knows neither laws nor loads: the elastic one and its rivals are left.
TEST_F(Tradeoff, ChartsLawsAndLoadsAgainstTheirOwnTruth) {
  use_energy(scene_, energy_near(ReferenceSolution::finite_elements));
  for (std::vector<float>& component : scene_.full.target.planes) {
    std::ranges::for_each(component, [](float& target) { target *= 0.1F; });
  }
  scene_.full.law_parameter = ScalarField(scene_.extent());
  const std::vector<Judged> laws = measured({&scalar_, &openmp_}, {});
  const auto of = [](const std::vector<Judged>& rows, std::string_view method) {
    std::vector<Judged> some;
    std::ranges::copy_if(rows, std::back_inserter(some),
                         [&](const Judged& row) { return row.method == method; });
    return some;
  };
  for (const Judged& row : laws) {
    EXPECT_EQ(row.status, JudgedStatus::ok) << row.method << ": " << row.reason;
    EXPECT_FALSE(row.deviations.to_fem_no_poisson || row.deviations.to_fixed_point || row.mean_energy);
    if (row.asked) {
      EXPECT_LT(row.deviations.to_fem, *row.asked) << row.backend;
    }
  }
  EXPECT_EQ(of(laws, requested_name).size(), 10U);
  ASSERT_EQ(of(laws, "newton").size(), 1U);
  EXPECT_EQ(of(laws, "newton").front().deviations.to_fem, 0.0);
  ASSERT_EQ(of(laws, elastic_conjugate_gradients).size(), 1U);
  const Judged linear = of(laws, elastic_conjugate_gradients).front();
  EXPECT_EQ(linear.variant, linear_law);
  EXPECT_GT(linear.deviations.to_fem, 0.02) << "the law does not matter";
  const std::vector<Judged> positions = of(laws, "xpbd");
  ASSERT_EQ(positions.size(), 4U);
  EXPECT_LT(positions[3].deviations.to_fem, positions[0].deviations.to_fem);
  const nlohmann::json equal = compare_at(scene_, laws, 0.01);
  EXPECT_EQ(equal["against"], "FEM");
  EXPECT_EQ(equal["direct"]["method"], "newton");
  EXPECT_EQ(equal["ours"]["method"], requested_name);

  scene_.full.law_parameter = {};
  scene_.full.force = VectorField(scene_.extent());
  scene_.full.force[0][scene_.extent().index(16, 16)] = 30.0F;
  const std::vector<Judged> loads = measured({&scalar_, &openmp_}, {});
  EXPECT_EQ(of(loads, "fem").size(), 1U);
  EXPECT_EQ(of(loads, "icm").size(), 0U);
  const std::vector<Judged> steps = of(loads, elastic_conjugate_gradients);
  ASSERT_GT(steps.size(), 3U);
  EXPECT_LT(std::ranges::min(steps, {}, error_to_chart).deviations.to_fem, 1e-3);
}

/// Void goes on as what is in it turns, and so moves farther than any tissue.
TEST_F(Tradeoff, HowFarVoidMovesIsNoSignOfDivergence) {
  scene_ = load_scene("circular", {.size = Extent{32, 32}});
  use_energy(scene_, energy_near(ReferenceSolution::finite_elements));
  Level& full = scene_.full;
  full.target = VectorField(full.extent);
  full.confidence = VectorField(full.extent);
  std::ranges::fill(full.modulus.values, std::ldexp(1.0F, -25));
  for (int y = 13; y < 20; ++y) {
    for (int x = 13; x < 20; ++x) {
      full.modulus.values[full.extent.index(x, y)] = 1.0F;
    }
  }
  for (const int x : {13, 19}) {
    const std::size_t site = full.extent.index(x, 16);
    full.target[1][site] = x == 13 ? -1.0F : 1.0F;
    full.confidence[0][site] = full.confidence[1][site] = 1.0F;
  }
  const std::vector<Judged> rows = measured({&scalar_, &openmp_}, {std::string(requested_name)});
  EXPECT_FALSE(rows.empty());
  for (const Judged& row : rows) {
    EXPECT_EQ(row.status, JudgedStatus::ok) << row.reason;
  }
}

TEST_F(Tradeoff, PlantedFaultsAreKeptWithTheirReason) {
  const auto spoil = [](float value) {
    return [value](VectorField& field) { field[0][field[0].size() / 2] += value; };
  };
  const std::vector<std::tuple<faults::Fault, JudgedStatus, const char*>> cases{
      {{.name = "one bit",
        .in_read = [](VectorField& field) { field[1].back() = std::nextafter(field[1].back(), 99.0F); }},
       JudgedStatus::unverified,
       "sites differ from scalar"},
      {{.name = "nan", .in_read = spoil(std::nanf(""))}, JudgedStatus::failed, "not finite"},
      {{.name = "far off", .in_read = spoil(1e6F)}, JudgedStatus::failed, "diverged"},
      {{.name = "throws", .in_step = [](int) -> int { throw DeviceError("the device is lost"); }},
       JudgedStatus::failed,
       "the device is lost"}};
  for (const auto& [fault, status, reason] : cases) {
    SCOPED_TRACE(fault.name);
    const faults::FaultyBackend faulty(scalar_, fault);
    std::vector<Judged> tradeoff = measured({&scalar_, &faulty}, {"icm"});
    const std::vector<Judged> points = on(tradeoff, fault.name);
    ASSERT_EQ(points.size(), 1U) << "a point that fails must not be dropped";
    EXPECT_EQ(points[0].status, status) << points[0].reason;
    EXPECT_THAT(points[0].reason, HasSubstr(reason));
    // Not even where it would win.
    for (Judged& point : tradeoff) {
      if (point.backend == fault.name) {
        point.seconds = {1e-9};
        point.deviations.to_fem_no_poisson = 1e-9;
      }
    }
    mark_front(tradeoff);
    EXPECT_FALSE(on(tradeoff, fault.name)[0].is_on_front);
    EXPECT_EQ(to_json(scene_, points[0])["status"], name_of(status));
  }
}

TEST(EqualAccuracy, TakesTheFastestOnBothSides) {
  const std::vector<Judged> points{
      point("icm", {2.0, 2.0, 2.5}, 0.2, false), point("cascade", {0.9, 1.0, 1.2}, 0.3, false),
      point("closed-form", {0.1}, 0.4, false), point("fem", {4.0, 5.0, 6.0}, 0.0, true)};
  const Scene scene = load_scene("square", {.size = Extent{9, 9}});
  const nlohmann::json equal = compare_at(scene, points, 0.35);
  EXPECT_EQ(equal["ours"]["method"], "cascade");
  EXPECT_DOUBLE_EQ(equal["direct"]["ratio"], 5.0);
  EXPECT_TRUE(equal["coarse"].is_null());
  EXPECT_TRUE(compare_at(scene, points, 0.1)["ours"].is_null());
}

} // namespace
} // namespace hdmbench
