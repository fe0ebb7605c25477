#pragma once

#include "backends/shared/elastic_session.hpp"

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

/// The table of levels of the elastic energy on which every session's steps must have scalar's bits.
namespace hdmbench::test {

/// Levels on which a session does every step of its methods.
struct ElasticCase {
  std::string name; ///< says how it is made
  Level level;
  ElasticModel model;
  std::optional<SiteSprings> springs{}; ///< in place of those of the level

  [[nodiscard]] ElasticBody body() const {
    return {.level = level, .model = model, .site_springs = springs ? &*springs : nullptr};
  }
};
/// Every size with every way to hold it.
[[nodiscard]] std::vector<ElasticCase> elastic_cases();
[[nodiscard]] ElasticCase random_elastic_case(std::uint64_t seed);
/// The steps one after the other, compared after each; or in a random order, some twice, with nothing read in
/// between: what a device does together.
enum class Order { one_by_one, in_one_go };
/// Says which step left which field other than scalar's; empty where none did.
[[nodiscard]] std::string elastic_difference(ElasticSession& session, const ElasticCase& one, Order order);

} // namespace hdmbench::test
