#pragma once

#include "harness/scene/sites.hpp"
#include "reference/finite_elements.hpp"
#include "test/random_level.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

/// Checks of finite elements as functions that return an error figure, so that each can be shown to fail on a
/// planted mistake.
namespace hdmbench::test {

struct Vector {
  double x = 0.0;
  double y = 0.0;
};
using Displacement = std::function<Vector(double x, double y)>;

inline ReferenceField sampled(Extent extent, const Displacement& displacement) {
  ReferenceField field(extent);
  for_each_site(extent, [&](int x, int y) {
    const Vector value = displacement(x, y);
    field.x[extent.index(x, y)] = value.x;
    field.y[extent.index(x, y)] = value.y;
  });
  return field;
}

/// The whole border prescribed.
inline ElasticProblem clamped_sheet(Extent extent, const Displacement& displacement, double modulus = 1.0) {
  ElasticProblem problem{.extent = extent,
                         .modulus = std::vector<double>(extent.sites(), modulus),
                         .fixed_x = std::vector<std::uint8_t>(extent.sites()),
                         .fixed_y = {},
                         .prescribed = sampled(extent, displacement),
                         .force = {}};
  for_each_site(extent, [&](int x, int y) {
    const bool border = x == 0 || y == 0 || x + 1 == extent.width || y + 1 == extent.height;
    problem.fixed_x[extent.index(x, y)] = border ? 1 : 0;
  });
  problem.fixed_y = problem.fixed_x;
  return problem;
}

inline double largest_difference(const ReferenceField& a, const ReferenceField& b) {
  double largest = 0.0;
  for (std::size_t i = 0; i < a.x.size(); ++i) {
    largest = std::max({largest, std::abs(a.x[i] - b.x[i]), std::abs(a.y[i] - b.y[i])});
  }
  return largest;
}

inline double root_mean_square(const ReferenceField& a, const ReferenceField& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.x.size(); ++i) {
    sum += (a.x[i] - b.x[i]) * (a.x[i] - b.x[i]) + (a.y[i] - b.y[i]) * (a.y[i] - b.y[i]);
  }
  return std::sqrt(sum / static_cast<double>(a.x.size()));
}

inline const std::vector<Displacement> affine_fields{
    [](double, double) {
      return Vector{3.0, -2.0};
    },
    [](double x, double y) {
      return Vector{0.1 * x, -0.2 * y};
    },
    [](double x, double y) {
      return Vector{0.3 * y, 0.3 * x};
    },
    [](double x, double y) {
      return Vector{1.0 - 0.2 * y, -4.0 + 0.2 * x};
    },
    [](double x, double y) {
      return Vector{0.5 - 0.7 * x + 0.2 * y, 1.0 + 0.4 * x + 0.9 * y};
    },
};

/// Patch test, pixels. `soft_pixel`: the modulus of one pixel amid 1.
inline double patch_error(const ElementRule& rule, double soft_pixel = 1.0) {
  double largest = 0.0;
  for (const Extent extent : {Extent{5, 5}, Extent{9, 4}, Extent{3, 11}}) {
    for (const Displacement& affine : affine_fields) {
      ElasticProblem problem = clamped_sheet(extent, affine);
      problem.modulus[extent.index(1, 1)] = soft_pixel;
      largest =
          std::max(largest, largest_difference(solve_finite_elements(problem, rule), problem.prescribed));
    }
  }
  return largest;
}

/// A smooth displacement, period 2 L in both directions, and the plane stress it causes.
struct Manufactured {
  double nu;
  double side; ///< L, pixels
  bool varying_modulus;

  [[nodiscard]] double modulus(double x, double y) const {
    return varying_modulus ? 20.0 * (1.0 + 0.5 * std::sin(3.0 * x / side) * std::cos(2.0 * y / side)) : 20.0;
  }
  [[nodiscard]] Vector displacement(double x, double y) const {
    const double a = std::numbers::pi * x / side;
    const double b = std::numbers::pi * y / side;
    return {std::sin(a) * std::cos(0.5 * b), std::cos(0.7 * a) * std::sin(1.3 * b)};
  }
  struct Stress {
    double xx;
    double yy;
    double xy;
  };
  [[nodiscard]] Stress stress(double x, double y) const {
    const double w = std::numbers::pi / side;
    const double a = w * x;
    const double b = w * y;
    const double strain_xx = w * std::cos(a) * std::cos(0.5 * b);
    const double strain_yy = 1.3 * w * std::cos(0.7 * a) * std::cos(1.3 * b);
    const double shear =
        -0.5 * w * std::sin(a) * std::sin(0.5 * b) - 0.7 * w * std::sin(0.7 * a) * std::sin(1.3 * b);
    const double plane = modulus(x, y) / (1.0 - nu * nu);
    return {plane * (strain_xx + nu * strain_yy), plane * (strain_yy + nu * strain_xx),
            modulus(x, y) / (2.0 * (1.0 + nu)) * shear};
  }
  /// Body force that holds the stress in balance, from central differences (error far below the mesh's).
  [[nodiscard]] Vector force(double x, double y) const {
    const double h = 1e-4 * side;
    const auto slope = [&](double Stress::*part, double dx, double dy) {
      return (stress(x + dx * h, y + dy * h).*part - stress(x - dx * h, y - dy * h).*part) / (2.0 * h);
    };
    return {-slope(&Stress::xx, 1, 0) - slope(&Stress::xy, 0, 1),
            -slope(&Stress::xy, 1, 0) - slope(&Stress::yy, 0, 1)};
  }
};

/// Root mean square error in pixels (amplitude 1) on n x n nodes.
inline double manufactured_error(const ElementRule& rule, double nu, int n, bool varying_modulus = false) {
  const Manufactured truth{.nu = nu, .side = n - 1.0, .varying_modulus = varying_modulus};
  const auto displacement = [&](double x, double y) { return truth.displacement(x, y); };
  ElasticProblem problem = clamped_sheet({n, n}, displacement);
  problem.force = sampled({n, n}, [&](double x, double y) { return truth.force(x, y); });
  for (int y = 0; y < n; ++y) {
    for (int x = 0; x < n; ++x) {
      problem.modulus[problem.extent.index(x, y)] = truth.modulus(x, y);
    }
  }
  return root_mean_square(solve_finite_elements(problem, rule), problem.prescribed);
}

/// The lowest order observed from mesh to finer mesh: 2 for bilinear elements.
inline double observed_order(const ElementRule& rule, double nu, bool varying_modulus = false) {
  double lowest = 10.0;
  double coarser = manufactured_error(rule, nu, 9, varying_modulus);
  for (const int n : {17, 33, 65}) {
    const double finer = manufactured_error(rule, nu, n, varying_modulus);
    lowest = std::min(lowest, std::log2(coarser / finer));
    coarser = finer;
  }
  return lowest;
}

/// Twice the energies of stretch, shear and bending of a sheet against their closed forms, relative.
inline double energy_error(const ElementRule& rule, double nu) {
  const double modulus = 7.0;
  const Extent extent{6, 4};
  const double area = 5.0 * 3.0;
  const double plane = modulus / (1.0 - nu * nu);
  const double shear = modulus / (2.0 * (1.0 + nu));
  struct Case {
    Displacement displacement;
    double expected;
  };
  // Bending in x * y: strain xx = y and shear x; the means of x^2 and y^2 over the sheet are 25/3 and 9/3.
  const std::vector<Case> cases{
      {[](double x, double) {
         return Vector{0.1 * x, 0.0};
       },
       plane * 0.01 * area},
      {[](double x, double y) {
         return Vector{0.1 * x, 0.2 * y};
       },
       plane * (0.01 + 0.04 + 2.0 * nu * 0.02) * area},
      {[](double, double y) {
         return Vector{0.1 * y, 0.0};
       },
       shear * 0.01 * area},
      {[](double x, double y) {
         return Vector{x * y, 0.0};
       },
       (plane * 9.0 / 3.0 + shear * 25.0 / 3.0) * area},
  };
  const ElasticProblem problem = clamped_sheet(extent, affine_fields[0], modulus);
  double largest = 0.0;
  for (const Case& c : cases) {
    const double energy = elastic_energy(problem, rule, sampled(extent, c.displacement));
    largest = std::max(largest, std::abs(energy / c.expected - 1.0));
  }
  return largest;
}

inline ElasticProblem random_sheet(Extent extent) {
  ElasticProblem problem = elastic_problem(random_problem(extent, Texture::smooth, 7).level);
  problem.fixed_x[0] = problem.fixed_y[0] = problem.fixed_x.back() = problem.fixed_y.back() = 1;
  return problem;
}

/// `from(x, y)` is the site of the old sheet that (x, y) of the new one shows.
template <typename Values, typename From>
std::vector<Values> rearranged(const std::vector<Values>& values, Extent old, Extent extent, From from) {
  std::vector<Values> result;
  for_each_site(extent, [&](int x, int y) {
    const auto [old_x, old_y] = from(x, y);
    result.push_back(values[old.index(old_x, old_y)]);
  });
  return result;
}

/// Difference between the mirror image of a solution and the solution of the mirror image, pixels.
inline double mirror_error(const ElementRule& rule) {
  const Extent extent{9, 6};
  const ElasticProblem problem = random_sheet(extent);
  const auto mirrored = [&](const auto& values) {
    return rearranged(values, extent, extent,
                      [&](int x, int y) { return std::pair(extent.width - 1 - x, y); });
  };
  const auto mirrored_field = [&](const ReferenceField& field) {
    ReferenceField result(extent);
    result.x = mirrored(field.x);
    result.y = mirrored(field.y);
    std::ranges::transform(result.x, result.x.begin(), std::negate{});
    return result;
  };
  ReferenceField mirrored_springs(extent);
  mirrored_springs.x = mirrored(problem.spring.x);
  mirrored_springs.y = mirrored(problem.spring.y);
  const ElasticProblem mirror{.extent = extent,
                              .modulus = mirrored(problem.modulus),
                              .fixed_x = mirrored(problem.fixed_x),
                              .fixed_y = mirrored(problem.fixed_y),
                              .prescribed = mirrored_field(problem.prescribed),
                              .force = {},
                              .spring = mirrored_springs};
  return largest_difference(solve_finite_elements(mirror, rule),
                            mirrored_field(solve_finite_elements(problem, rule)));
}

/// The same with rows and columns exchanged.
inline double transposition_error(const ElementRule& rule) {
  const Extent extent{9, 6};
  const Extent turned{6, 9};
  const ElasticProblem problem = random_sheet(extent);
  const auto transposed = [&](const auto& values) {
    return rearranged(values, extent, turned, [](int x, int y) { return std::pair(y, x); });
  };
  const auto transposed_field = [&](const ReferenceField& field) {
    ReferenceField result(turned);
    result.x = transposed(field.y);
    result.y = transposed(field.x);
    return result;
  };
  const ElasticProblem transpose{.extent = turned,
                                 .modulus = transposed(problem.modulus),
                                 .fixed_x = transposed(problem.fixed_y),
                                 .fixed_y = transposed(problem.fixed_x),
                                 .prescribed = transposed_field(problem.prescribed),
                                 .force = {},
                                 .spring = transposed_field(problem.spring)};
  return largest_difference(solve_finite_elements(transpose, rule),
                            transposed_field(solve_finite_elements(problem, rule)));
}

/// A bar of two materials pulled by 1 px: springs in series; the element between two pixels of different
/// modulus has half of each.
inline double bar_error(const ElementRule& rule) {
  const Extent extent{12, 3};
  const int first_of_second = 5;
  const auto modulus = [&](int x) { return x < first_of_second ? 40.0 : 5.0; };
  ElasticProblem problem{.extent = extent,
                         .modulus = {},
                         .fixed_x = std::vector<std::uint8_t>(extent.sites()),
                         .fixed_y = std::vector<std::uint8_t>(extent.sites()),
                         .prescribed = ReferenceField(extent),
                         .force = {}};
  std::vector<double> expected{0.0};
  for (int x = 0; x + 1 < extent.width; ++x) {
    expected.push_back(expected.back() + 2.0 / (modulus(x) + modulus(x + 1)));
  }
  for (int y = 0; y < extent.height; ++y) {
    for (int x = 0; x < extent.width; ++x) {
      problem.modulus.push_back(modulus(x));
    }
    problem.fixed_x[extent.index(0, y)] = 1;
    problem.fixed_x[extent.index(extent.width - 1, y)] = 1;
    problem.prescribed.x[extent.index(extent.width - 1, y)] = 1.0;
  }
  problem.fixed_y[0] = 1;
  const ReferenceField truth = sampled(extent, [&](double x, double) {
    return Vector{expected[static_cast<std::size_t>(x)] / expected.back(), 0.0};
  });
  return largest_difference(solve_finite_elements(problem, rule), truth);
}

} // namespace hdmbench::test
