#include "backends/shared/elastic_session.hpp"

#include <array>

namespace hdmbench {

std::string_view MethodStep::name() const {
  constexpr std::array<std::string_view, 10> names{
      "write",         "sweep",      "sweep from zero",   "forces", "restricted residual", "restricted load",
      "interpolation", "correction", "coarsest solution", "advance"};
  return names.at(static_cast<std::size_t>(kind));
}

ScalarField ElasticSession::dot_squares(ElasticField first, ElasticField second, int height) const {
  VectorField a;
  VectorField b;
  read(0, first, a);
  read(0, second, b);
  ScalarField sums(a.extent);
  for (std::size_t at = 0; at < sums.values.size(); ++at) {
    sums.values[at] = ElasticInFloat::site_product(a[0][at], b[0][at], a[1][at], b[1][at]);
  }
  for (int done = 0; done < height; ++done) {
    sums = square_sums(sums);
  }
  return sums;
}

ScalarField square_sums(const ScalarField& sums) {
  const Extent extent = sums.extent;
  const auto value = [&](int x, int y) {
    return x < extent.width && y < extent.height ? sums.values[extent.index(x, y)] : 0.0F;
  };
  ScalarField next(Extent{(extent.width + 1) / 2, (extent.height + 1) / 2});
  for_each_site(next.extent, [&](int x, int y) {
    next.values[next.extent.index(x, y)] = ElasticInFloat::square_sum(
        value(2 * x, 2 * y), value(2 * x + 1, 2 * y), value(2 * x, 2 * y + 1), value(2 * x + 1, 2 * y + 1));
  });
  return next;
}

} // namespace hdmbench
