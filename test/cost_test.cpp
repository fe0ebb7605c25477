#include "kernels/cost.hpp"

#include "backends/registry.hpp"
#include "harness/memory_use.hpp"
#include "kernels/gather.hpp"
#include "test/counted_operations.hpp"
#include "test/plain_scene.hpp"

#include <gtest/gtest.h>
#include <malloc.h>

#include <algorithm>
#include <array>

namespace hdmbench {

namespace {

using counted::Knowledge;

/// Operations of an update of one site, as they stand in energy.inc.
int counted_operations(SiteKind kind, int candidates) {
  counted::graph = {};
  int next = 0;
  const auto given = [&](Knowledge knowledge) { return counted::real::given(next++, knowledge); };
  const auto neighbours = [&](Knowledge knowledge) {
    return counted::Neighbours{given(knowledge), given(knowledge), given(knowledge),
                               given(knowledge), given(knowledge), given(knowledge),
                               given(knowledge), given(knowledge), given(knowledge)};
  };
  const bool uniform = kind == SiteKind::uniform || kind == SiteKind::uniform_unobserved;
  const bool observed = kind == SiteKind::general || kind == SiteKind::uniform;
  counted::Site site;
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
  const counted::Displacement moved = counted::improved_displacement(site, steps, candidates);
  counted::graph.need(moved.x.node());
  counted::graph.need(moved.y.node());
  return counted::graph.operations();
}

} // namespace

TEST(Cost, OperationsAreThoseOfEnergyInc) {
  for (std::size_t i = 0; i < site_kinds; ++i) {
    const auto kind = static_cast<SiteKind>(i);
    for (int candidates = 2; candidates <= StepSet::maximum_count; ++candidates) {
      EXPECT_EQ(site_cost(kind).operations(candidates), counted_operations(kind, candidates))
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
      for (int y = 0; y < extent.height; ++y) {
        for (int x = 0; x < extent.width; ++x) {
          const energy::Site site = energy::gather(level, VectorField(extent), x, y);
          const energy::Neighbours& m = site.inverse_modulus;
          const std::array all{m.north_west, m.north,      m.north_east, m.west,      m.centre,
                               m.east,       m.south_west, m.south,      m.south_east};
          const bool uniform = std::ranges::count(all, m.centre) == 9;
          const bool observed = site.confidence_x != 0.0F || site.confidence_y != 0.0F;
          const SiteKind kind = uniform ? (observed ? SiteKind::uniform : SiteKind::uniform_unobserved)
                                        : (observed ? SiteKind::general : SiteKind::unobserved);
          ++expected[static_cast<std::size_t>(kind)];
        }
      }
      EXPECT_EQ(count_site_kinds(scene.full, extent, alignment), expected)
          << extent.width << " x " << extent.height;
    }
  }
}

class BytesTest : public testing::TestWithParam<std::string> {};

// On a device that shares the process's memory, what a large level adds is the arrays that its sweeps read
// and write, and what a backend keeps beside them to upload and count.
TEST_P(BytesTest, DeclaredAreThoseOfTheArraysThatAreThere) {
  const auto backends = make_backends();
  const Backend& backend = find_backend(backends, GetParam());
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
    session->load(level);
    session->write(start);
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
  constexpr double staging = 28.0; // four floats, a count, an array
  EXPECT_GT(added, 0.9 * declared);
  EXPECT_LT(added, 1.1 * declared + (backend.threads({}) > 0 ? 0.0 : staging));
}

std::vector<std::string> backend_names() {
  std::vector<std::string> all;
  for (const auto& backend : make_backends()) {
    all.emplace_back(backend->name());
  }
  return all;
}

INSTANTIATE_TEST_SUITE_P(Backends, BytesTest, testing::ValuesIn(backend_names()), [](const auto& instance) {
  std::string name = instance.param;
  std::ranges::replace(name, '-', '_');
  return name;
});

} // namespace hdmbench
