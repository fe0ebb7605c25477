#include "test/bit_cases.hpp"

#include "harness/check/cases.hpp"
#include "harness/check/compare.hpp"
#include "harness/scene/level_sequence.hpp"
#include "harness/scene/scene.hpp"
#include "test/coupled/coupled.hpp"
#include "test/sessions.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace hdmbench::test {
namespace {

using Cases = std::vector<BitCase>;

constexpr std::array grid_textures{Texture::smooth, Texture::tie_rich, Texture::dyadic};

BitCase with_calls(BitCase bit_case, std::vector<int> calls) {
  bit_case.calls = std::move(calls);
  return bit_case;
}

/// Rows of every length up to some vectors, by the four paths that a row of the openmp backend can take.
Cases rows_of_every_length() {
  Cases cases;
  for (int width = 3; width <= 66; ++width) {
    const int kind = (width + width / 16) % 4;
    BitCase one = random_bit_case({width, 6}, Texture::smooth, static_cast<std::uint64_t>(width));
    Level& level = one.problem.level;
    if (kind % 2 == 1) {
      const float modulus = level.modulus.values.front(); // m * (1 / m) is not always 1
      std::ranges::fill(level.modulus.values, modulus);
      set_inverse_modulus(level);
    }
    std::ranges::fill(level.confidence[0], kind < 2 ? 0.0F : 0.625F);
    std::ranges::fill(level.confidence[1], kind < 2 ? 0.0F : 1.0F);
    one.name += fmt::format(", {} modulus, {}", kind % 2 == 1 ? "one" : "any",
                            kind < 2 ? "unobserved" : "observed alike");
    cases.push_back(std::move(one));
  }
  return cases;
}

Cases sizes() {
  Cases cases = rows_of_every_length();
  std::uint64_t seed = 100;
  for (const Extent extent :
       {Extent{1, 1},    {1, 7},    {5, 1},   {70, 1},  {1, 300}, {2, 2},   {2, 3},    {3, 3},
        Extent{15, 17},  {16, 16},  {31, 33}, {64, 3},  {64, 8},  {64, 16}, {65, 17},  {127, 5},
        Extent{128, 32}, {129, 34}, {255, 9}, {256, 5}, {7, 300}, {300, 7}, {131, 97}, {257, 130}}) {
    ++seed;
    cases.push_back(random_bit_case(extent, grid_textures[seed % 3], seed));
  }
  cases.push_back(with_calls(random_bit_case({90, 70}, Texture::smooth, 9), {0, 1, 2, 7, 300}));
  cases.push_back(
      with_calls(random_bit_case({200, 200}, Texture::tie_rich, 10), {1, 2, 3, 1, 1, 8, 20, 1, 1}));
  return cases;
}

Cases rules() {
  Cases cases;
  std::uint64_t seed = 200;
  for (const bool coupled : {false, true}) {
    for (const Rule rule : all_rules) {
      for (const Update update : simultaneous_and_coloured) {
        for (const Extent extent : {Extent{1, 1}, {1, 6}, {2, 3}, {7, 1}, {66, 17}, {129, 34}}) {
          ++seed;
          const Texture texture = grid_textures[(seed + seed / 6) % 3]; // another one for each order
          BitCase one = random_bit_case(extent, texture, seed, {}, rule, update);
          one.calls = {1, 3, 2, 9};
          if (coupled) {
            couple(one.problem.level);
            one.name += ", coupled";
          }
          cases.push_back(std::move(one));
        }
      }
    }
  }
  // Large enough for eight threads, whose bands have seams that sweeps pass together.
  for (const auto& [rule, update] :
       {std::pair{Rule::closed_form, Update::coloured}, {Rule::annealing, Update::four_coloured}}) {
    cases.push_back(
        with_calls(random_bit_case({257, 140}, Texture::tie_rich, 15, {}, rule, update), {1, 2, 5}));
  }
  return cases;
}

Cases candidates() {
  Cases cases;
  std::vector<float> steps;
  for (int count = 1; count <= StepSet::maximum_count; ++count) {
    steps.push_back(count % 2 == 0 ? 0.1F * static_cast<float>(count)
                                   : -0.3F * static_cast<float>(count - 1));
    cases.push_back(random_bit_case({40, 30}, Texture::tie_rich, 7, StepSet(steps)));
  }
  for (const char* ties : {"0,-1,-0.25,1,0.25", "1,-1,0.5,-0.5", "0.25,-0.25,0"}) {
    cases.push_back(
        with_calls(random_bit_case({70, 50}, Texture::dyadic, 17, StepSet::parse(ties)), {1, 2, 17}));
  }
  cases.push_back(
      with_calls(random_bit_case({50, 50}, Texture::tie_rich, 8, StepSet::parse("thesis")), {1, 2, 27}));
  for (const char* drawn : {"0", "1,-1", "fine", "0,1,2,3,4,5,6,7,8,9,-1,-2,-3,-4,-5,-6"}) {
    cases.push_back(random_bit_case({40, 30}, Texture::smooth, 20, StepSet::parse(drawn), Rule::annealing,
                                    Update::four_coloured));
  }
  return cases;
}

/// Tiles are told apart by what they and their rims have. Those that begin at 64, 32 are 16 to 128 sites wide
/// and 5 to 64 high.
Cases tiles() {
  constexpr Extent extent{200, 140};
  const VectorField start = random_problem(extent, Texture::smooth, 31).start;
  Cases cases;
  for (const int x : {62, 63, 64, 100, 127, 128}) {
    for (const int y : {30, 31, 32, 47, 48, 64}) {
      const std::size_t site = extent.index(x, y);
      Problem problem{.level = plain_level(extent, 7.0F), .start = start};
      problem.level.confidence[1][site] = 0.5F;
      problem.level.target[1][site] = 9.0F;
      cases.push_back(
          {.name = fmt::format("observation at {}, {}", x, y), .problem = problem, .calls = {1, 1}});
      problem.level = plain_level(extent, 7.0F);
      problem.level.modulus.values[site] = 1.5F;
      set_inverse_modulus(problem.level);
      cases.push_back({.name = fmt::format("modulus at {}, {}", x, y), .problem = problem, .calls = {1, 1}});
    }
  }
  return cases;
}

BitCase from_scene(const Scene& scene, std::vector<int> calls) {
  return {.name = scene.name,
          .problem = {.level = scene.full, .start = scene.start_field()},
          .calls = std::move(calls)};
}

/// One site pulls at a level that is otherwise at rest, where tiles of many shapes have a corner.
BitCase pulled(Extent extent, int x, int y, std::vector<int> calls) {
  Level level = random_problem(extent, Texture::tie_rich, 7).level;
  level.penalty = 1000.0F;
  level.confidence = VectorField(extent);
  const std::size_t site = extent.index(x, y);
  level.confidence[0][site] = level.confidence[1][site] = 1.0F;
  level.target[0][site] = 60.0F;
  level.target[1][site] = -60.0F;
  return {.name = fmt::format("pulled at {}, {}", x, y),
          .problem = {.level = std::move(level), .start = VectorField(extent)},
          .calls = std::move(calls)};
}

Cases waking() {
  Cases cases;
  const std::vector<int> calls{1, 2, 3, 60};
  for (const auto& [x, y] : {std::pair{127, 31}, {128, 32}, {64, 16}, {95, 24}}) {
    cases.push_back(pulled({256, 97}, x, y, calls));
  }
  cases.push_back(pulled({201, 140}, 64, 63, {25}));
  couple(cases.back().problem.level);
  cases.back().name += ", coupled";

  // A spike spreads by one site per sweep, through corners, sides and seams between the threads' shares.
  constexpr Extent extent{103, 75};
  for (const int x : {13, 16, 24, 63}) {
    for (const int y : {21, 24, 32}) {
      VectorField start(extent);
      start[0][extent.index(x, y)] = 300.0F;
      start[1][extent.index(x, y)] = -300.0F;
      cases.push_back({.name = fmt::format("spike at {}, {}", x, y),
                       .problem = {.level = plain_level(extent, 7.0F), .start = start},
                       .calls = {1, 1, 1, 1, 1, 1, 1, 1, 4, 4, 14}});
    }
  }
  // All tiles fall asleep; what is written wakes them.
  cases.push_back({.name = "at rest, then a random field",
                   .problem = {.level = plain_level({192, 48}, 7.0F), .start = VectorField({192, 48})},
                   .calls = {4, 5},
                   .again = random_problem({192, 48}, Texture::tie_rich, 8).start});
  // A front that runs through a field at rest; then a site far from it, where larger tiles sleep too.
  const Scene square = load_scene("square", {.size = Extent{200, 200}});
  cases.push_back(from_scene(square, {1, 1, 1, 1, 5, 1, 1, 20, 1, 1, 60, 1, 1}));
  VectorField shifted = square.start_field();
  shifted[0][square.extent().index(110, 80)] += 3.0F;
  cases.push_back(from_scene(square, {30}));
  cases.back().again = std::move(shifted);
  return cases;
}

/// `sweeps` on the full image and one more on each level that is coarser.
BitCase pyramid_of(BitCase one, int sweeps, Alignment alignment = Alignment::corner) {
  for (const Extent extent : pyramid_extents(one.problem.level.extent)) {
    one.levels.insert(one.levels.begin(),
                      {.extent = extent, .sweeps = sweeps++, .strengths = one.problem.level.strengths});
  }
  one.alignment = alignment;
  one.name += alignment == Alignment::corner ? ", pyramid" : ", centred pyramid";
  return one;
}

BitCase pyramid_of(const Scene& scene) {
  BitCase one = from_scene(scene, {});
  const LevelSequence levels(scene);
  one.levels = levels.pyramid().value().levels;
  one.alignment = scene.schedule.alignment;
  one.name += ", pyramid";
  return one;
}

Cases coarse_levels() {
  Cases cases;
  std::uint64_t seed = 300;
  for (const Extent extent : {Extent{1, 1}, {1, 1025}, {33, 33}, {90, 7}, {129, 70}}) {
    for (const Alignment alignment : {Alignment::corner, Alignment::center}) {
      const Texture texture = ++seed % 2 == 0 ? Texture::smooth : Texture::tie_rich;
      cases.push_back(pyramid_of(random_bit_case(extent, texture, seed), 2, alignment));
    }
  }
  cases.push_back(random_bit_case({40, 50}, Texture::smooth, 5));
  cases.back().name += ", without sweeps and twice of one extent";
  cases.back().levels = {{.extent = {3, 5}, .sweeps = 0},
                         {.extent = {3, 5}, .sweeps = 4},
                         {.extent = {20, 20}, .sweeps = 3},
                         {.extent = {20, 20}, .sweeps = 2},
                         {.extent = {40, 50}, .sweeps = 1}};
  Scene square = load_scene("square", {.size = Extent{70, 70}});
  square.schedule.iterations = 40; // from a null field the coarsest levels rest long before
  cases.push_back(pyramid_of(square));
  return cases;
}

/// As much as one dispatch may do, on a scene that takes long to rest: rasterizers end long loops early.
Cases long_dispatches() {
  const Scene scene = load_scene("square-modified", {.size = Extent{64, 64}});
  Cases cases;
  for (const auto& [across, sites_each] : {std::pair{1, 1}, {2, 1}, {32, 128}}) {
    BitCase one = from_scene(scene, {});
    one.name += fmt::format(", {} across, as many sweeps as one dispatch may do", across);
    one.levels = {{.extent = {across, across}, .sweeps = 59'900 / (3 * sites_each + 4) - 2},
                  {.extent = {64, 64}, .sweeps = 1}};
    cases.push_back(std::move(one));
  }
  return cases;
}

Cases pyramids() {
  Cases cases = coarse_levels();
  std::ranges::move(long_dispatches(), std::back_inserter(cases));
  std::uint64_t seed = 400;
  for (const Extent extent : {Extent{1, 7}, {70, 1}, {2, 3}, {64, 8}, {65, 33}, {257, 130}}) {
    for (const Alignment alignment : {Alignment::corner, Alignment::center}) {
      cases.push_back(pyramid_of(random_bit_case(extent, Texture::smooth, ++seed), 3, alignment));
    }
    cases.push_back(random_bit_case(extent, Texture::smooth, ++seed)); // a level between pyramids
  }
  for (const Rule rule : {Rule::steps, Rule::annealing}) {
    for (const Update update : simultaneous_and_coloured) {
      cases.push_back(pyramid_of(random_bit_case({90, 41}, Texture::smooth, 31, {}, rule, update), 4));
      cases.push_back(cases.back());
      couple(cases.back().problem.level);
      cases.back().name += ", coupled";
    }
  }
  for (const char* name : {"square", "circular", "circular-radial", "square-modified"}) {
    Scene scene = load_scene(name, {.size = Extent{150, 150}});
    scene.schedule.iterations = 15;
    cases.push_back(pyramid_of(scene));
  }
  return cases;
}

Cases volumes() {
  Cases cases;
  std::uint64_t seed = 800;
  // Each rule with each order of sites is by itself, as a pyramid and coupled in two volumes.
  for (std::size_t kind = 0; const Extent extent : odd_volumes()) {
    for (const Rule rule : all_rules) {
      for (const Update update : simultaneous_and_coloured) {
        ++seed;
        BitCase one = random_bit_case(extent, grid_textures[(seed + kind) % 3], seed, {}, rule, update);
        if (kind % 3 == 1 && rule != Rule::closed_form) {
          one = pyramid_of(one, 2, kind % 2 == 0 ? Alignment::corner : Alignment::center);
        } else if (kind % 3 == 2) {
          couple(one.problem.level);
          one.name += ", coupled";
        }
        cases.push_back(std::move(one));
      }
    }
    ++kind;
  }
  // Half of it without an observation; one modulus, or one but at one site, whose neighbours are in other
  // slices.
  for (const bool same : {true, false}) {
    BitCase one = random_bit_case({70, 21, 9}, Texture::smooth, ++seed);
    Level& level = one.problem.level;
    std::ranges::fill(level.modulus.values, 7.0F);
    level.modulus.values[level.extent.index(40, 10, 4)] = same ? 7.0F : 2.0F;
    set_inverse_modulus(level);
    for (std::vector<float>& plane : level.confidence.planes) {
      std::fill_n(plane.begin(), plane.size() / 2, 0.0F);
    }
    one.name += same ? ", one modulus" : ", one modulus but at one site";
    one.calls = {1, 2, 9};
    cases.push_back(std::move(one));
  }
  for (const char* steps : {"0", "1,-1", "fine", "0,1,2,3,4,5,6,7,8,9,-1,-2,-3,-4,-5,-6"}) {
    for (const Rule rule : {Rule::steps, Rule::annealing}) {
      cases.push_back(random_bit_case({18, 9, 5}, Texture::tie_rich, ++seed, StepSet::parse(steps), rule));
    }
  }
  return cases;
}

Cases layouts() {
  Cases cases;
  const std::vector<int> calls{1, 2, 5};
  for (const Extent extent :
       {Extent{5, 3}, {131, 70}, {300, 97}}) { // smaller than a tile; tiles that are cut off
    cases.push_back(with_calls(random_bit_case(extent, Texture::tie_rich, 700), calls));
  }
  cases.push_back(pulled({256, 97}, 127, 31, {1, 2, 3, 60}));
  cases.push_back(pulled({256, 97}, 128, 32, {1, 2, 3, 60}));
  cases.push_back(with_calls(
      random_bit_case({257, 140}, Texture::smooth, 31, {}, Rule::annealing, Update::coloured), calls));
  cases.push_back(pyramid_of(random_bit_case({257, 130}, Texture::tie_rich, 33), 3));
  return cases;
}

} // namespace

BitCase random_bit_case(Extent extent, Texture texture, std::uint64_t seed, std::optional<StepSet> steps,
                        Rule rule, Update update) {
  return {.name = fmt::format("random_problem({{{}, {}, {}}}, Texture({}), {}, {}, Rule({}), Update({}))",
                              extent.width, extent.height, extent.depth, static_cast<int>(texture), seed,
                              steps ? fmt::format("StepSet::parse(\"{}\")", steps->text()) : "{}",
                              static_cast<int>(rule), static_cast<int>(update)),
          .problem = random_problem(extent, texture, seed, steps, rule, update)};
}

std::vector<BitCase> cases_of(Group group) {
  static constexpr std::array makers{sizes, rules, candidates, tiles, waking, pyramids, volumes, layouts};
  return makers.at(static_cast<std::size_t>(group))();
}

/// Does a case; returns the states to be compared, in order. `one_by_one`: a call for each sweep.
static std::vector<State> do_case(Session& session, const BitCase& bit_case, bool one_by_one = false) {
  std::vector<State> states;
  const auto look = [&] { states.push_back({.field = read(session), .changed = session.changed()}); };
  if (!bit_case.levels.empty()) {
    session.load(
        Pyramid{.full = &bit_case.problem.level, .alignment = bit_case.alignment, .levels = bit_case.levels});
    for (int time = 0; time < 2; ++time) {
      session.solve();
      look();
    }
    return states;
  }
  const auto step = [&](int sweeps) {
    for (; one_by_one && sweeps > 1; --sweeps) {
      session.step(1);
    }
    session.step(sweeps);
    look();
  };
  begin(session, bit_case.problem);
  look();
  std::ranges::for_each(bit_case.calls, step);
  session.write(bit_case.again.value_or(bit_case.problem.start));
  look();
  const auto first = std::ranges::find_if(bit_case.calls, [](int sweeps) { return sweeps > 0; });
  step(first == bit_case.calls.end() ? 1 : *first);
  return states;
}

ExpectedBits::ExpectedBits(std::vector<BitCase> cases) : cases_(std::move(cases)) {
  const auto session = scalar().open({});
  for (const BitCase& bit_case : cases_) {
    expected_.push_back(do_case(*session, bit_case, true));
  }
}

std::string ExpectedBits::differences(Session& session, int* refused) const {
  std::string text;
  int wrong = 0;
  for (std::size_t i = 0; i < cases_.size(); ++i) {
    std::vector<State> found;
    try {
      found = do_case(session, cases_[i]);
    } catch (const TooLarge&) {
      if (refused == nullptr) {
        throw;
      }
      ++*refused;
      continue;
    }
    for (std::size_t at = 0; at < found.size(); ++at) {
      const State& expected = expected_[i][at];
      const FieldDifference difference = compare(expected.field, found[at].field);
      if (difference.sites > 0 || difference.not_finite > 0 || found[at].changed != expected.changed) {
        text +=
            fmt::format("{}: state {} has {} other sites, the first at index {}; {} sites changed, not {}\n",
                        cases_[i].name, at, difference.sites, difference.first.value_or(0), found[at].changed,
                        expected.changed);
        if (++wrong == 3) {
          return text;
        }
        break;
      }
    }
  }
  return text;
}

std::vector<Way> ways_of(const Backend& backend, Group group) {
  const bool has_threads = backend.threads({.device = {}, .threads = 2}) == 2;
  std::vector<Way> ways;
  for (const int threads : !has_threads              ? std::vector{1}
                           : group == Group::layouts ? std::vector{3, 4, 6, 7, 8}
                                                     : std::vector{1, 2, 5}) {
    for (const Work work : {Work::dense, Work::active}) {
      ways.push_back({fmt::format("{}, {} threads", work_names[static_cast<std::size_t>(work)], threads),
                      {.device = {}, .threads = threads, .work = work}});
    }
  }
  return ways;
}

} // namespace hdmbench::test
