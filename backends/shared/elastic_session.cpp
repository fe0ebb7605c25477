#include "backends/shared/elastic_session.hpp"

#include "backends/shared/stopwatch.hpp"

#include <array>

namespace hdmbench {

std::string_view MethodStep::name() const {
  constexpr std::array<std::string_view, 10> names{
      "write",         "sweep",      "sweep from zero",   "forces", "restricted residual", "restricted load",
      "interpolation", "correction", "coarsest solution", "advance"};
  return names.at(static_cast<std::size_t>(kind));
}

double ElasticSession::do_load_body(const ElasticBody& body) {
  double seconds = 0.0;
  load(timed(seconds, [&] { return make_elastic_hierarchy(body); }));
  return seconds;
}

ScalarField ElasticSession::dot_squares(ElasticField first, ElasticField second, int height) const {
  VectorField a;
  VectorField b;
  read(0, first, a);
  read(0, second, b);
  ScalarField sums(a.extent);
  for (std::size_t at = 0; at < sums.values.size(); ++at) {
    float& product = sums.values[at];
    product = ElasticInFloat::site_product(a[0][at], b[0][at], a[1][at], b[1][at]);
    product = a.extent.axes() == 2 ? product : ElasticInFloat::with_term(product, a[2][at], b[2][at]);
  }
  for (int done = 0; done < height; ++done) {
    sums = square_sums(sums, a.extent.axes());
  }
  return sums;
}

ScalarField square_sums(const ScalarField& sums, std::size_t axes) {
  const Extent extent = sums.extent;
  const auto value = [&](int x, int y, int z) {
    return x < extent.width && y < extent.height && z < extent.depth ? sums.values[extent.index(x, y, z)]
                                                                     : 0.0F;
  };
  const auto square = [&](int x, int y, int z) {
    return ElasticInFloat::square_sum(value(x, y, z), value(x + 1, y, z), value(x, y + 1, z),
                                      value(x + 1, y + 1, z));
  };
  ScalarField next(Extent{(extent.width + 1) / 2, (extent.height + 1) / 2, (extent.depth + 1) / 2});
  for_each_site(next.extent, [&](int x, int y, int z) {
    const float near = square(2 * x, 2 * y, 2 * z);
    next.values[next.extent.index(x, y, z)] =
        axes == 2 ? near : ElasticInFloat::corrected_by_one(near, square(2 * x, 2 * y, 2 * z + 1));
  });
  return next;
}

} // namespace hdmbench
