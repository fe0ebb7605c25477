#include "kernels/data/pyramid.hpp"

#include "backends/cpu/cpu.hpp"
#include "backends/shared/energy_programs.hpp"
#include "harness/measure/memory_use.hpp"
#include "harness/scene/sites.hpp"
#include "kernels/data/gather.hpp"
#include "test/counted_operations.hpp"
#include "test/scenes.hpp"
#include "test/sessions.hpp"

#include <gtest/gtest.h>
#include <malloc.h>

#include <algorithm>
#include <array>
#include <bit>
#include <limits>
#include <utility>

namespace hdmbench {

namespace {

using counted::Knowledge;

/// Operations of an update of one site, as they stand in the texts of an energy with the scalar
/// counted::real.
template <typename Counted>
int counted_operations(SiteKind kind, int candidates) {
  counted::graph = {};
  int next = 0;
  const auto given = [&](Knowledge knowledge) { return counted::real::given(next++, knowledge); };
  const auto neighbours = [&](Knowledge knowledge) {
    return typename Counted::Neighbours{given(knowledge), given(knowledge), given(knowledge),
                                        given(knowledge), given(knowledge), given(knowledge),
                                        given(knowledge), given(knowledge), given(knowledge)};
  };
  const bool uniform = kind == SiteKind::uniform || kind == SiteKind::uniform_unobserved;
  const bool observed = kind == SiteKind::general || kind == SiteKind::uniform;
  typename Counted::Site site{};
  site.dx = neighbours(Knowledge::varying);
  site.dy = neighbours(Knowledge::varying);
  if (uniform) {
    const counted::real inverse = given(Knowledge::invariant);
    site.inverse_modulus = {inverse, inverse, inverse, inverse, inverse, inverse, inverse, inverse, inverse};
    site.modulus = given(Knowledge::invariant);
  } else {
    site.inverse_modulus = neighbours(Knowledge::varying);
    site.modulus = given(Knowledge::varying);
  }
  site.target_x = given(Knowledge::varying);
  site.target_y = given(Knowledge::varying);
  site.confidence_x = observed ? given(Knowledge::varying) : counted::real(0);
  site.confidence_y = observed ? given(Knowledge::varying) : counted::real(0);
  site.penalty = given(Knowledge::invariant);
  counted::real steps[16];
  for (counted::real& step : steps) {
    step = given(Knowledge::invariant);
  }
  Counted::set_inputs(site, [&](int) { return neighbours(Knowledge::varying); });
  const auto moved =
      Counted::moved_displacement(Counted::rule_steps, observed, site, {}, {}, steps, candidates);
  counted::graph.need(moved.x.node());
  counted::graph.need(moved.y.node());
  return counted::graph.operations();
}

} // namespace

TEST(Cost, OperationsAreThoseOfEnergyInc) {
  for (std::size_t i = 0; i < site_kinds; ++i) {
    const auto kind = static_cast<SiteKind>(i);
    for (int candidates = 2; candidates <= StepSet::maximum_count; ++candidates) {
      EXPECT_EQ(thesis_energy.costs[i].operations(candidates),
                counted_operations<Hdm<counted::real>>(kind, candidates))
          << "kind " << i << ", " << candidates << " candidates";
    }
  }
}

TEST(Cost, KindsAreThoseThatAKernelSees) {
  Scene scene = test::plain_scene({37, 23});
  test::know_column(scene, 5, 1.0F);
  scene.full.confidence.y[scene.extent().index(30, 11)] = 0.5F;
  for (int y = 0; y < 23; ++y) {
    for (int x = 12; x < 20; ++x) {
      scene.full.modulus.values[scene.extent().index(x, y)] = 2.0F;
    }
  }
  scene.full.modulus.values[scene.extent().index(36, 22)] = 3.0F;
  scene.full.modulus.values[scene.extent().index(6, 0)] = 3.0F;
  set_inverse_modulus(scene.full);
  for (const Alignment alignment : {Alignment::corner, Alignment::center}) {
    for (const Extent extent : {Extent{37, 23}, Extent{16, 16}, Extent{4, 1}, Extent{1, 1}}) {
      const Level level = sample_level(scene.full, extent, alignment);
      SiteCounts expected{};
      for_each_site(extent, [&](int x, int y) {
        const HdmInFloat::Site site = gather<HdmInFloat>(level, VectorField(extent), x, y);
        const HdmInFloat::Neighbours& m = site.inverse_modulus;
        const std::array all{m.north_west, m.north,      m.north_east, m.west,      m.centre,
                             m.east,       m.south_west, m.south,      m.south_east};
        const bool uniform = std::ranges::count(all, m.centre) == 9;
        const bool observed = site.confidence_x != 0.0F || site.confidence_y != 0.0F;
        const SiteKind kind = uniform ? (observed ? SiteKind::uniform : SiteKind::uniform_unobserved)
                                      : (observed ? SiteKind::general : SiteKind::unobserved);
        ++expected[static_cast<std::size_t>(kind)];
      });
      EXPECT_EQ(count_site_kinds(scene.full, extent, alignment), expected)
          << extent.width << " x " << extent.height;
    }
  }
}

namespace {

/// One sweep of 96 x 64 sites, all of them but those at the border of a kind, with one confidence at all.
class KindOfSites {
public:
  explicit KindOfSites(SiteKind kind) {
    for (std::size_t i = 0; i < scene.extent().sites(); ++i) {
      const float varying = 1.0F + static_cast<float>(i % 7);
      if (kind == SiteKind::general || kind == SiteKind::unobserved) {
        scene.full.modulus.values[i] = varying;
      }
      if (kind == SiteKind::general || kind == SiteKind::uniform) {
        scene.full.confidence.x[i] = scene.full.confidence.y[i] = 0.5F;
      }
      scene.full.target.x[i] = scene.full.target.y[i] = varying;
      start.x[i] = start.y[i] = 3.0F * varying;
    }
    set_inverse_modulus(scene.full);
  }

  [[nodiscard]] VectorField swept(const Backend& backend) const {
    const auto session = backend.open({.device = {}, .threads = 1});
    test::begin(*session, scene.full, start);
    session->step(1);
    return test::read(*session);
  }

  Scene scene = test::plain_scene({96, 64});
  VectorField start{scene.extent()};
};

/// In tiles that do not reach the border.
bool differ_inside(const VectorField& a, const VectorField& b) {
  for (int y = 16; y < 48; ++y) {
    for (int x = 32; x < 64; ++x) {
      const std::size_t i = a.extent.index(x, y);
      if (std::bit_cast<std::uint32_t>(a.x[i]) != std::bit_cast<std::uint32_t>(b.x[i]) ||
          std::bit_cast<std::uint32_t>(a.y[i]) != std::bit_cast<std::uint32_t>(b.y[i])) {
        return true;
      }
    }
  }
  return false;
}

/// Which array the row kernel gets as no numbers; none: as it is.
const float* openmp::RowPart::*spoiled = nullptr;

std::int64_t sweep_spoiled_row(const openmp::RowPart& part) {
  static const std::vector<float> nothing(std::size_t{3} * 96 * 64, std::numeric_limits<float>::quiet_NaN());
  openmp::RowPart other = part;
  if (spoiled != nullptr) {
    other.*spoiled = nothing.data() + nothing.size() / 3;
  }
  return programs_of(thesis_energy).rows.front()(other);
}

constexpr std::array all_kinds{SiteKind::general, SiteKind::unobserved, SiteKind::uniform,
                               SiteKind::uniform_unobserved};
constexpr int bytes_written = 8;

} // namespace

// An array is read where the result is another one without it.
TEST(Bytes, OfOpenMpAreThoseOfTheArraysThatItsRowsRead) {
  using Part = openmp::RowPart;
  const Backend& openmp = test::find("openmp");
  const auto spoiling = make_openmp_with("spoiling", sweep_spoiled_row, "baseline");
  for (const SiteKind kind : all_kinds) {
    const KindOfSites sites(kind);
    const VectorField sound = sites.swept(*spoiling);
    int bytes = bytes_written;
    for (const float* Part::*const array :
         {&Part::dx, &Part::dy, &Part::modulus, &Part::inverse_modulus, &Part::target_x, &Part::target_y,
          &Part::confidence_x, &Part::confidence_y}) {
      spoiled = array;
      bytes += differ_inside(sound, sites.swept(*spoiling)) ? 4 : 0;
      spoiled = nullptr;
    }
    EXPECT_EQ(openmp.bytes_per_update(kind, 1), bytes) << "kind " << static_cast<int>(kind);
    EXPECT_EQ(openmp.bytes_per_update(kind, 100), bytes / 8.0) << "8 sweeps pass together";
  }
}

TEST(Bytes, OfScalarAreThoseOfTheArraysOfALevel) {
  const Backend& scalar = test::scalar();
  for (const SiteKind kind : all_kinds) {
    KindOfSites sites(kind);
    const VectorField sound = sites.swept(scalar);
    int bytes = bytes_written;
    Level& level = sites.scene.full;
    for (std::vector<float>* const array :
         {&sites.start.x, &sites.start.y, &level.modulus.values, &level.inverse_modulus.values,
          &level.target.x, &level.target.y, &level.confidence.x, &level.confidence.y}) {
      std::vector<float> kept(array->size(), std::numeric_limits<float>::quiet_NaN());
      std::swap(*array, kept);
      bytes += differ_inside(sound, sites.swept(scalar)) ? 4 : 0;
      std::swap(*array, kept);
    }
    EXPECT_EQ(scalar.bytes_per_update(kind, 1), bytes) << "kind " << static_cast<int>(kind);
  }
}

class BytesTest : public testing::TestWithParam<std::string> {};

// On a device that shares the process's memory, what a large level adds is the arrays that its sweeps read
// and write, and what a backend keeps beside them to upload and count.
TEST_P(BytesTest, DeclaredAreThoseOfTheArraysThatAreThere) {
  const Backend& backend = test::find(GetParam());
  std::unique_ptr<Session> session;
  try {
    if (!backend.device({}).is_software && backend.threads({}) == 0) {
      GTEST_SKIP() << "the arrays are in the device's own memory";
    }
    session = backend.open({});
  } catch (const DeviceError& error) {
    GTEST_SKIP() << error.what();
  }
  const auto run = [&](const Level& level, const VectorField& start) {
    test::begin(*session, level, start);
    session->step(2);
  };
  Scene small = test::plain_scene({128, 128}); // has tiles of every kind
  run(small.full, small.start_field());        // compiles
  Scene large = test::plain_scene({1200, 1100});
  for (std::size_t i = 0; i < large.extent().sites(); ++i) { // all sites are general: none may go without
    large.full.modulus.values[i] = 1.0F + static_cast<float>(i % 7);
    large.full.confidence.x[i] = 0.5F;
    large.full.confidence.y[i] = 0.5F;
  }
  set_inverse_modulus(large.full);
  const VectorField large_start = large.start_field();
  malloc_trim(0); // what other tests have freed would be used again, unseen
  const std::size_t before = resident_bytes();
  run(large.full, large_start);
  const double added = (static_cast<double>(resident_bytes()) - static_cast<double>(before)) /
                       static_cast<double>(large.extent().sites());
  const double declared = backend.bytes_per_update(SiteKind::general, 1);
  // openmp has room for the confidences, which it does not read where a tile has one.
  constexpr double confidences = 8.0;
  constexpr double staging = 28.0; // four floats, a count, an array
  EXPECT_GT(added, 0.9 * declared);
  EXPECT_LT(added, 1.1 * declared + (backend.threads({}) == 0 ? staging : backend.skips() ? confidences : 0));
}

INSTANTIATE_TEST_SUITE_P(Backends, BytesTest, testing::ValuesIn(test::backend_names()), test::parameter_name);

} // namespace hdmbench
