#include "harness/scene/sites.hpp"
#include "harness/solve/methods/elastic.hpp"
#include "harness/solve/stopwatch.hpp"
#include "kernels/data/elastic/springs.hpp"

#include <Eigen/Cholesky>

#include <algorithm>
#include <cmath>
#include <functional>

namespace hdmbench {

double ElasticSolver::settle(const Level& full, const std::vector<RigidMotion>& motions) {
  if (!sprung_ || motions.empty()) {
    return 0.0;
  }
  const Stopwatch watch(timings_.compute);
  const auto field_of = [&](const auto& x_at, const auto& y_at) {
    VectorField field(full.extent);
    for_each_site(full.extent, [&](int x, int y) {
      const std::size_t at = full.extent.index(x, y);
      field.x[at] = static_cast<float>(x_at(at, y));
      field.y[at] = static_cast<float>(y_at(at, x));
    });
    return field;
  };
  const auto stiffness = [&](float confidence, std::size_t at) {
    return is_spring(confidence) ? spring_stiffness(full.modulus.values[at], confidence) : 0.0;
  };
  const auto pulled = [&](const std::vector<float>& way_x, const std::vector<float>& way_y) {
    return field_of([&](std::size_t at, int) { return stiffness(full.confidence.x[at], at) * way_x[at]; },
                    [&](std::size_t at, int) { return stiffness(full.confidence.y[at], at) * way_y[at]; });
  };
  const auto product = [&](const VectorField& force, const VectorField& way) {
    session_.write(0, ElasticField::image, force);
    session_.write(0, ElasticField::direction, way);
    return static_cast<double>(session_.dot(ElasticField::image, ElasticField::direction));
  };
  const VectorField field = displacement();
  VectorField missing = full.target;
  std::ranges::transform(missing.x, field.x, missing.x.begin(), std::minus<>());
  std::ranges::transform(missing.y, field.y, missing.y.begin(), std::minus<>());
  const VectorField pull = pulled(missing.x, missing.y);
  const auto count = static_cast<Eigen::Index>(motions.size());
  Eigen::MatrixXd matrix(count, count);
  Eigen::VectorXd forces(count);
  std::vector<VectorField> ways;
  for (const RigidMotion& motion : motions) {
    ways.push_back(field_of([&](std::size_t, int row) { return motion.x_at(row); },
                            [&](std::size_t, int column) { return motion.y_at(column); }));
  }
  for (Eigen::Index i = 0; i < count; ++i) {
    const VectorField& way = ways[static_cast<std::size_t>(i)];
    forces[i] = product(pull, way);
    const VectorField resistance = pulled(way.x, way.y);
    for (Eigen::Index j = 0; j < count; ++j) {
      matrix(i, j) = product(resistance, ways[static_cast<std::size_t>(j)]);
    }
  }
  const Eigen::VectorXd amounts = matrix.ldlt().solve(forces);
  if (!amounts.allFinite()) {
    return 0.0;
  }
  const auto sum_of = [&](const auto& component) {
    double sum = 0.0;
    for (Eigen::Index i = 0; i < count; ++i) {
      sum += amounts[i] * component(motions[static_cast<std::size_t>(i)]);
    }
    return sum;
  };
  const VectorField moved = field_of(
      [&](std::size_t, int row) { return sum_of([&](const RigidMotion& of) { return of.x_at(row); }); },
      [&](std::size_t, int column) {
        return sum_of([&](const RigidMotion& of) { return of.y_at(column); });
      });
  std::ranges::transform(start_.x, moved.x, start_.x.begin(), std::plus<>());
  std::ranges::transform(start_.y, moved.y, start_.y.begin(), std::plus<>());
  session_.write(0, ElasticField::direction, moved);
  return std::sqrt(2.0) * root_mean_square(session_.dot(ElasticField::direction, ElasticField::direction));
}

} // namespace hdmbench
