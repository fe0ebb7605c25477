// Every backend of the registry, in every way that it has, gives scalar's bits in all cases of bit_cases.cpp
// and on random levels, by the thesis's energy, a coupled one and the elastic one; a new backend is tested by
// being there. HDMBENCH_RANDOM_CASES=10000 (120 unless said) random levels, of which
// HDMBENCH_RANDOM_CASE=NUMBER repeats one. And what a session promises its caller beside bits.

#include "backends/cpu/cpu.hpp"
#include "backends/shared/energy_programs.hpp"
#include "harness/scene/level_sequence.hpp"
#include "test/bit_cases.hpp"
#include "test/elastic_cases.hpp"
#include "test/files.hpp"
#include "test/sessions.hpp"

#include <link.h>

#include <atomic>
#include <set>

namespace hdmbench {
namespace {

using test::ExpectedBits;
using test::Group;
using test::Texture;
using test::Way;

/// Skips where the backend is not there.
class BackendTest : public testing::TestWithParam<std::string> {
protected:
  void SetUp() override {
    if (const std::string reason = test::why_absent(backend()); !reason.empty()) {
      GTEST_SKIP() << reason;
    }
  }
  [[nodiscard]] const Backend& backend() const { return test::find(GetParam()); }
};
INSTANTIATE_TEST_SUITE_P(Registry, BackendTest, testing::ValuesIn(test::backend_names()),
                         test::parameter_name);

void expect_scalars_bits(const Backend& backend, const std::vector<Way>& ways, const ExpectedBits& expected) {
  for (const Way& way : ways) {
    const auto session = backend.open(way.options);
    EXPECT_EQ(expected.differences(*session), "") << backend.name() << ", " << way.name;
  }
}

class SameBits : public testing::TestWithParam<std::tuple<std::string, Group>> {};

TEST_P(SameBits, AsScalar) {
  const auto& [name, group] = GetParam();
  const Backend& backend = test::find(name);
  if (const std::string reason = test::why_absent(backend); !reason.empty()) {
    GTEST_SKIP() << reason;
  }
  expect_scalars_bits(backend, ways_of(backend, group), ExpectedBits(cases_of(group)));
}

std::string name_of_test(const testing::TestParamInfo<SameBits::ParamType>& information) {
  const auto& [name, group] = information.param;
  return fmt::format("{}_{}", test::test_name(name), test::group_names.at(static_cast<std::size_t>(group)));
}
/// OSMesa makes contexts of a driver that EGL has, too: of what is asked of a driver, it is asked what shows
/// how an image is laid out.
bool has_driver_of_its_own(std::string_view name) {
  return name != "gl-fragment-osmesa";
}

std::vector<SameBits::ParamType> backends_and_groups() {
  std::vector<SameBits::ParamType> all;
  for (const std::string& name : test::backend_names()) {
    for (const Group group : test::all_groups) {
      if (name != "scalar" && (has_driver_of_its_own(name) || group >= Group::pyramids)) {
        all.emplace_back(name, group);
      }
    }
  }
  return all;
}
INSTANTIATE_TEST_SUITE_P(Registry, SameBits, testing::ValuesIn(backends_and_groups()), name_of_test);

void expect_elastic_bits(ElasticSession& session, std::string_view way) {
  for (const test::ElasticCase& one : test::elastic_cases()) {
    for (const test::Order order : {test::Order::one_by_one, test::Order::in_one_go}) {
      ASSERT_EQ(elastic_difference(session, one, order), "") << way;
    }
  }
}

/// Not only the one that this processor would choose.
TEST(OpenMpBackend, EveryInstructionSetGivesScalarsBits) {
  const ExpectedBits sizes(cases_of(Group::sizes));
  const ExpectedBits candidates(cases_of(Group::candidates));
  const ExpectedBits volumes(cases_of(Group::volumes));
  for (const openmp::InstructionSet& set : openmp::instruction_sets()) {
    const auto backend = make_openmp_with("openmp", programs_of(thesis_energy).rows.at(set.row), set.name);
    const auto session = backend->open({.device = {}, .threads = 1});
    EXPECT_EQ(sizes.differences(*session), "") << set.name;
    EXPECT_EQ(candidates.differences(*session), "") << set.name;
    EXPECT_EQ(volumes.differences(*session), "") << set.name;
    for (const int threads : {1, 3}) {
      expect_elastic_bits(*make_elastic_openmp(threads, *set.elastic_rows, 1), set.name);
    }
  }
}

std::atomic<std::int64_t> visited_sites{0};

std::int64_t recording_row(const openmp::RowPart& part) {
  visited_sites += static_cast<std::int64_t>(part.rows) * (part.last - part.first);
  return programs_of(thesis_energy).rows.front()(part);
}

TEST(OpenMpBackend, LeavesOutWhatIsAtRest) {
  const auto recording = make_openmp_with("recording", recording_row, "baseline");
  const Scene scene = load_scene("square", {.size = Extent{300, 300}});
  const LevelSequence levels(scene);
  std::array<std::int64_t, 2> visited{};
  for (const Work work : {Work::dense, Work::active}) {
    const auto session = recording->open({.device = {}, .threads = 2, .work = work});
    session->load(levels.pyramid().value());
    visited_sites = 0;
    session->solve();
    visited.at(static_cast<std::size_t>(work)) = visited_sites;
  }
  EXPECT_EQ(static_cast<double>(visited[0]), site_updates(scene));
  EXPECT_LT(visited[1] * 8, visited[0]);
}

// ---- Random levels

/// Cases of one batch differ in everything but what a shader is compiled for.
constexpr int batches = 100;
constexpr int batch_size = 100;
constexpr int usual_cases = 120;

std::optional<int> environment(const char* name) {
  const char* const value = std::getenv(name);
  return value == nullptr ? std::nullopt : std::optional(std::stoi(value));
}

/// Which cases to run: the first ones of every batch, and of fewer batches where there are few.
std::vector<int> case_numbers() {
  if (const auto one = environment("HDMBENCH_RANDOM_CASE")) {
    return {*one};
  }
  const int count = environment("HDMBENCH_RANDOM_CASES").value_or(usual_cases);
  const int used = count >= batches * batch_size ? batches : 12; // every rule with every order of sites
  std::vector<int> numbers;
  for (int i = 0; i < count; ++i) {
    numbers.push_back(i % used * batch_size + i / used);
  }
  std::ranges::sort(numbers);
  return numbers;
}

test::BitCase random_case(int number) {
  const int batch = number / batch_size;
  const Rule rule = test::all_rules[static_cast<std::size_t>(batch % 4)];
  const Update update = test::simultaneous_and_coloured[static_cast<std::size_t>(batch / 4 % 3)];
  const bool has_candidates = rule == Rule::steps || rule == Rule::annealing;
  const int candidates = has_candidates ? 1 + batch * 5 % StepSet::maximum_count : 1;
  std::mt19937_64 engine(static_cast<std::uint64_t>(number));
  const auto draw = [&](int low, int high) {
    return low + static_cast<int>(engine() % static_cast<std::uint64_t>(high - low + 1));
  };
  Extent extent{draw(1, 24), draw(1, 24)};
  const int thin = draw(0, 5);
  extent.width = thin == 0 ? 1 : extent.width;
  extent.height = thin == 1 ? 1 : extent.height;
  const auto texture = static_cast<Texture>(draw(0, 3));
  // On the texture's own grid, so that candidates tie; half of the sets begin with 0.
  const float unit = texture == Texture::dyadic ? 0.25F : texture == Texture::tie_rich ? 0.1F : 0.0123F;
  std::vector<float> steps;
  for (int i = 0; i < candidates; ++i) {
    const float step = unit * static_cast<float>(draw(-12, 12));
    steps.push_back(texture == Texture::extreme ? std::ldexp(step, draw(-30, 30)) : step);
  }
  steps.front() = draw(0, 1) == 0 ? 0.0F : steps.front();
  if (draw(0, 7) == 0) { // a volume
    extent = {draw(2, 10), draw(2, 10), draw(2, 10)};
  }
  test::BitCase result = test::random_bit_case(extent, texture, static_cast<std::uint64_t>(number),
                                               StepSet(steps), rule, update);
  result.calls = {1, 3};
  result.name += fmt::format("; repeat: HDMBENCH_RANDOM_CASE={}", number);
  return result;
}

TEST_P(BackendTest, RandomLevelsHaveTheBitsOfScalar) {
  if (!has_driver_of_its_own(GetParam())) {
    GTEST_SKIP() << "asked of the same driver with EGL";
  }
  std::vector<test::BitCase> cases;
  for (const int number : case_numbers()) {
    cases.push_back(random_case(number));
  }
  std::vector<Way> ways = ways_of(backend(), Group::sizes);
  std::erase_if(ways, [](const Way& way) { return way.options.work == Work::active; });
  expect_scalars_bits(backend(), ways, ExpectedBits(std::move(cases)));
}

class ElasticBits : public BackendTest {
protected:
  void SetUp() override {
    BackendTest::SetUp();
    if (!IsSkipped() && !backend().has_elastic()) {
      GTEST_SKIP() << GetParam() << " does not compute the elastic energy";
    }
  }
};
INSTANTIATE_TEST_SUITE_P(Registry, ElasticBits, testing::ValuesIn(test::backend_names()),
                         test::parameter_name);

TEST_P(ElasticBits, AsScalar) {
  expect_elastic_bits(*backend().open_elastic({}), GetParam());
}

TEST_P(ElasticBits, RandomLevelsHaveTheBitsOfScalar) {
  const auto session = backend().open_elastic({});
  const int count = environment("HDMBENCH_RANDOM_CASES").value_or(usual_cases) / 2;
  for (int seed = 1; seed <= count; ++seed) {
    const auto one = test::random_elastic_case(static_cast<std::uint64_t>(seed));
    ASSERT_EQ(elastic_difference(*session, one, test::Order::in_one_go), "");
  }
}

/// OpenGL and Vulkan leave it to the device whether numbers below FLT_MIN are kept.
TEST_P(BackendTest, SubnormalNumbersAreKeptOrTakenForZero) {
  const auto session = backend().open({});
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    for (const Rule rule : {Rule::steps, Rule::closed_form}) {
      const auto problem = test::random_problem({9, 8}, Texture::tiny, seed, {}, rule);
      test::begin(*session, problem);
      session->step(2);
      const FieldDifference difference = compare(test::swept(problem, 2), test::read(*session));
      EXPECT_EQ(difference.not_finite, 0);
      EXPECT_LT(difference.largest, 8.0 * double{std::numeric_limits<float>::min()}) << "seed " << seed;
    }
  }
}

// ---- What a session promises beside bits

TEST_P(BackendTest, SessionsDoNotDisturbEachOther) {
  const auto decoy = test::random_problem({12, 70}, Texture::smooth, 12);
  const auto other = backend().open({});
  const auto session = backend().open({});
  test::begin(*other, decoy);
  const ExpectedBits expected({test::random_bit_case({33, 44}, Texture::tie_rich, 11)});
  EXPECT_EQ(expected.differences(*session), "");
  other->step(3);
  EXPECT_EQ(compare(test::swept(decoy, 3), test::read(*other)).sites, 0);
}

/// A driver that is loaded again and again uses up what libraries get once in a process: NVIDIA's for Vulkan
/// could be loaded some 40 times.
TEST_P(BackendTest, DriversStayLoaded) {
  const auto loaded = [] {
    std::set<std::string> names;
    dl_iterate_phdr(
        [](dl_phdr_info* library, std::size_t /*size*/, void* into) {
          static_cast<std::set<std::string>*>(into)->insert(library->dlpi_name);
          return 0;
        },
        &names);
    return names;
  };
  auto session = backend().open({});
  const auto before = loaded();
  session.reset();
  EXPECT_THAT(loaded(), testing::IsSupersetOf(before));
}

TEST_P(BackendTest, CallsOutOfOrderAreRefused) {
  const auto session = backend().open({});
  VectorField field({4, 4});
  EXPECT_THROW(session->step(1), std::logic_error);
  EXPECT_THROW(session->write(field), std::logic_error);
  EXPECT_THROW(session->read(field), std::logic_error);
  EXPECT_THROW((void)session->changed(), std::logic_error);
  const auto problem = test::random_problem({4, 5}, Texture::smooth, 1);
  session->load(problem.level);
  EXPECT_THROW(session->step(1), std::logic_error) << "before write";
  EXPECT_THROW(session->write(field), std::logic_error) << "wrong size";
  session->write(problem.start);
  EXPECT_THROW(session->step(-1), std::logic_error);
  EXPECT_THROW(session->solve(), std::logic_error) << "no pyramid is loaded";
  session->load(Pyramid{.full = &problem.level, .levels = {{.extent = {4, 5}, .sweeps = 1}}});
  EXPECT_THROW(session->step(1), std::logic_error) << "no level is loaded";
  EXPECT_THROW(session->write(problem.start), std::logic_error) << "no level is loaded";
}

/// Golden hashes hold what sequential updates give.
TEST_P(BackendTest, UpdatesThatItDoesNotSupportAreRefused) {
  auto problem = test::random_problem({40, 40}, Texture::smooth, 16);
  problem.level.update = Update::sequential;
  const auto session = backend().open({});
  const std::string refusal = test::refusal<DeviceError>([&] { session->load(problem.level); });
  EXPECT_EQ(refusal == "accepted", backend().supports(Update::sequential)) << refusal;
}

TEST_P(BackendTest, WhatTheDeviceDoesNotHaveIsRefusedWithAList) {
  EXPECT_FALSE(backend().devices().front().name.empty());
  const std::string refusal =
      test::refusal<DeviceError>([&] { (void)backend().open({.device = "no such device"}); });
  EXPECT_THAT(refusal, testing::HasSubstr(backend().devices().front().name));
  EXPECT_EQ(backend().device({.device = "0"}).name, backend().devices().front().name);
}

TEST_P(BackendTest, AnImageBeyondTheDevicesLimitIsCutOrRefusedWhereItCannotBe) {
  if (backend().threads({}) > 0) {
    GTEST_SKIP() << "limited by memory only";
  }
  const auto session = backend().open({});
  // Longer than any texture or number of work groups today, small in memory.
  const Extent extent = GetParam().ends_with("compute") ? Extent{5, 70000} : Extent{70000, 5};
  try {
    session->load(test::random_problem(extent, Texture::smooth, 1, {}, Rule::annealing).level);
    GTEST_SKIP() << "this device takes 70000 sites in a line";
  } catch (const TooLarge& error) {
    EXPECT_THAT(error.what(), testing::AllOf(testing::HasSubstr("70000"), testing::HasSubstr("annealing")));
  }
  std::vector<test::BitCase> cases{
      test::random_bit_case({9, 9}, Texture::smooth, 14),
      test::random_bit_case(extent, Texture::tie_rich, 15),
      test::random_bit_case(extent, Texture::smooth, 16, {}, Rule::closed_form, Update::coloured),
      test::random_bit_case({9, 9}, Texture::smooth, 17)};
  if (extent.width > extent.height) { // rows are what annealing can be cut into
    cases.push_back(test::random_bit_case({5, 70000}, Texture::smooth, 13, {}, Rule::annealing));
  }
  std::ranges::for_each(cases, [](test::BitCase& one) { one.calls = {1, 1}; });
  EXPECT_EQ(ExpectedBits(std::move(cases)).differences(*session), "");
}

} // namespace
} // namespace hdmbench
