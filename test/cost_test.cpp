#include "kernels/cost.hpp"
#include "test/counted_operations.hpp"

#include <gtest/gtest.h>

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

} // namespace hdmbench
