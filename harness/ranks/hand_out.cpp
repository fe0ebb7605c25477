#include "harness/ranks/hand_out.hpp"

#include "harness/ranks/elastic_share.hpp"
#include "harness/ranks/redistribution.hpp"

#include <utility>

namespace hdmbench {

namespace {

std::vector<float> hand_out(Ranks& ranks, Extent extent, std::span<const Rectangle> wanted,
                            const std::vector<float>* whole) {
  return redistribute(ranks, static_cast<std::size_t>(ranks.rank()), all_on_first(extent, ranks.size()),
                      wanted, whole != nullptr ? std::span<const float>(*whole) : std::span<const float>());
}

} // namespace

VectorField hand_out(Ranks& ranks, Extent extent, std::span<const Rectangle> wanted,
                     const VectorField* whole) {
  VectorField part;
  part.extent = wanted[static_cast<std::size_t>(ranks.rank())].extent();
  part.x = hand_out(ranks, extent, wanted, whole != nullptr ? &whole->x : nullptr);
  part.y = hand_out(ranks, extent, wanted, whole != nullptr ? &whole->y : nullptr);
  return part;
}

void collect(Ranks& ranks, Extent extent, std::span<const Rectangle> held, const VectorField& own,
             VectorField* whole) {
  VectorField all = redistribute(ranks, static_cast<std::size_t>(ranks.rank()), held,
                                 all_on_first(extent, ranks.size()), own);
  if (whole != nullptr) {
    *whole = std::move(all);
  }
}

void hand_out(Ranks& ranks, Extent extent, std::span<const Rectangle> wanted, const Level* whole,
              bool curvature, std::size_t inputs, Level& part) {
  part.extent = wanted[static_cast<std::size_t>(ranks.rank())].extent();
  const auto scalar = [&](const ScalarField* from, ScalarField& to) {
    to.extent = part.extent;
    to.values = hand_out(ranks, extent, wanted, from != nullptr ? &from->values : nullptr);
  };
  const auto vector = [&](const VectorField* from, VectorField& to) {
    to = hand_out(ranks, extent, wanted, from);
  };
  vector(whole != nullptr ? &whole->target : nullptr, part.target);
  vector(whole != nullptr ? &whole->confidence : nullptr, part.confidence);
  scalar(whole != nullptr ? &whole->modulus : nullptr, part.modulus);
  scalar(whole != nullptr ? &whole->inverse_modulus : nullptr, part.inverse_modulus);
  for (std::size_t i = 0; i < inputs; ++i) {
    scalar(whole != nullptr ? &whole->inputs[i] : nullptr, part.inputs.emplace_back());
  }
  if (curvature) {
    vector(whole != nullptr ? &whole->inverse_curvature : nullptr, part.inverse_curvature);
  }
}

} // namespace hdmbench
