#include "harness/applications/spread.hpp"

#include "harness/scene/images/pixels.hpp"
#include "harness/scene/method.hpp"
#include "harness/scene/points.hpp"
#include "harness/solve/methods/law_solver.hpp"
#include "kernels/data/elastic/conditions.hpp"
#include "kernels/data/elastic/set_up.hpp"
#include "kernels/data/elastic/springs.hpp"
#include "kernels/data/input_error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <span>
#include <utility>
#include <vector>

namespace hdmbench {

namespace {

constexpr double enough =
    0.01; ///< of a drawn field: what its solution may lack, far below what few draws leave
/// Where tissue lies in void, steps estimate far too much to end by themselves: a brain's deviations were
/// 1.3 % from those of 400 steps.
constexpr int most_steps = 40;

/// The tissue that a point stands for (point_reach) over a voxel, or a pixel.
double point_over_voxel(const Scene& scene) {
  double ratio = 1.0;
  for (std::size_t axis = 0; axis < scene.extent().axes(); ++axis) {
    ratio *= point_reach / (scene.full.sides[axis] * scene.spacing);
  }
  return ratio;
}

/// Forces at random on the corners of a cell, whose covariance is the stiffness of the cell with the squares
/// of its moduli: a draw for every stress, of the whole cell where it is one tissue, else of each of its
/// Gauss points, which are as many as its corners and have their moduli.
class CellForces {
public:
  CellForces(const Level& full, const ElasticModel& model) : size_(full.extent.axes() << full.extent.axes()) {
    constexpr double rounding_of_float = 1e-4; // far below the share of the weakest stress
    const std::size_t corners = std::size_t{1} << full.extent.axes();
    const std::vector<double> whole = stiffness(full, model, corners);
    whole_ = factors_of(whole, 1e-12);
    for (std::size_t corner = 0; corner < corners; ++corner) {
      std::vector<double> more = stiffness(full, model, corner); // the sum of all, and this one again
      std::ranges::transform(more, whole, more.begin(), std::minus<>());
      of_point_.push_back(factors_of(std::move(more), rounding_of_float));
    }
  }

  /// Draws the component `axis` of corner c at axes * c + axis; bit a of a corner is its end along axis a.
  void operator()(std::span<const float> moduli, NormalDraws& random, std::array<double, 24>& forces) const {
    forces.fill(0.0);
    if (std::ranges::adjacent_find(moduli, std::not_equal_to<>()) == moduli.end()) {
      draw(whole_, moduli[0], random, forces);
      return;
    }
    for (std::size_t corner = 0; corner < moduli.size(); ++corner) {
      draw(of_point_[corner], moduli[corner], random, forces);
    }
  }

private:
  using Factors = std::vector<std::vector<double>>;

  /// Returns Cholesky's factor, column by column, without those of motions that have no force.
  [[nodiscard]] Factors factors_of(std::vector<double> matrix, double least) const {
    Factors factors;
    double largest = 0.0;
    for (std::size_t row = 0; row < size_; ++row) {
      largest = std::max(largest, matrix[row * size_ + row]);
    }
    for (std::size_t column = 0; column < size_; ++column) {
      const double pivot = matrix[column * size_ + column];
      if (pivot <= least * largest) {
        continue; // what is before it says already how it moves
      }
      std::vector<double>& factor = factors.emplace_back(size_, 0.0);
      for (std::size_t row = column; row < size_; ++row) {
        factor[row] = matrix[row * size_ + column] / std::sqrt(pivot);
      }
      for (std::size_t row = column; row < size_; ++row) {
        for (std::size_t other = column; other < size_; ++other) {
          matrix[row * size_ + other] -= factor[row] * factor[other];
        }
      }
    }
    return factors;
  }

  void draw(const Factors& factors, double modulus, NormalDraws& random,
            std::array<double, 24>& forces) const {
    for (const std::vector<double>& factor : factors) {
      const double drawn = modulus * random();
      for (std::size_t row = 0; row < size_; ++row) {
        forces[row] += drawn * factor[row];
      }
    }
  }

  /// Returns the stiffness of a cell of modulus 1, of `twice` 2, row by row, over its area or volume.
  [[nodiscard]] static std::vector<double> stiffness(const Level& full, const ElasticModel& model,
                                                     std::size_t twice) {
    Level cell;
    cell.extent = {2, 2, full.extent.axes() == 3 ? 2 : 1};
    cell.sides = full.sides;
    cell.confidence = VectorField(cell.extent);
    cell.modulus = ScalarField(cell.extent, 1.0F);
    if (twice < cell.modulus.values.size()) {
      cell.modulus.values[twice] = 2.0F;
    }
    const ElasticHierarchy hierarchy = make_elastic_hierarchy({cell, model, Springs::none});
    const ElasticLevel& image = hierarchy.levels.front();
    const CellMatrix matrix = cell_matrix(image, image.grid.index(0, 0));
    const double unit = force_unit(cell, model.poisson);
    std::vector<double> values(matrix.components * matrix.components);
    std::transform(matrix.values.begin(), matrix.values.begin() + static_cast<std::ptrdiff_t>(values.size()),
                   values.begin(), [unit](double value) { return value / unit; });
    return values;
  }

  std::size_t size_; ///< components of all corners
  Factors whole_;
  std::vector<Factors> of_point_;
};

/// Sums of the ways that are drawn, pixels, and of their squares, by component.
class SumsOfDraws {
public:
  explicit SumsOfDraws(Extent extent) : sum_(extent), squares_(extent) {}

  void add(const VectorField& way) {
    ++count_;
    for (std::size_t axis = 0; axis < way.extent.axes(); ++axis) {
      for (std::size_t site = 0; site < way.extent.sites(); ++site) {
        const double value = way[axis][site];
        sum_[axis][site] += value;
        squares_[axis][site] += value * value;
      }
    }
  }

  [[nodiscard]] VectorField mean_from(const VectorField& start) const {
    VectorField mean = start;
    for (std::size_t axis = 0; axis < mean.extent.axes(); ++axis) {
      for (std::size_t site = 0; site < mean.extent.sites(); ++site) {
        mean[axis][site] = static_cast<float>(start[axis][site] + sum_[axis][site] / count_);
      }
    }
    return mean;
  }

  [[nodiscard]] VectorField deviation() const {
    VectorField field(sum_.extent);
    for (std::size_t axis = 0; axis < field.extent.axes(); ++axis) {
      for (std::size_t site = 0; site < field.extent.sites(); ++site) {
        const double sum = sum_[axis][site];
        const double variance = (squares_[axis][site] - sum * sum / count_) / (count_ - 1);
        field[axis][site] = static_cast<float>(std::sqrt(std::max(variance, 0.0)));
      }
    }
    return field;
  }

private:
  DoubleField sum_;
  DoubleField squares_;
  int count_ = 0;
};

/// Averages the variance over blocks: its largest value at a site is the noise of few draws.
LeastCertain least_certain(const Scene& scene, const VectorField& deviation) {
  const Extent extent = scene.extent();
  const std::array<int, 3> sides = extent.sides();
  const int block = std::max(2, *std::ranges::max_element(sides) / 16);
  const auto blocks = [&](std::size_t axis) { return (sides[axis] + block - 1) / block; };
  const Extent grid{blocks(0), blocks(1), blocks(2)};
  struct Sum {
    double variance = 0.0;
    int tissue = 0;
    int sites = 0;
  };
  std::vector<Sum> sums(grid.sites());
  const bool has_outside = std::ranges::any_of(scene.labels.values, [](int label) { return label != 0; });
  const float least = void_modulus(scene.full);
  for_each_site(extent, [&](int x, int y, int z) {
    Sum& sum = sums[grid.index(x / block, y / block, z / block)];
    const std::size_t site = extent.index(x, y, z);
    ++sum.sites;
    if ((has_outside && scene.labels.values[site] == 0) || scene.full.modulus.values[site] < least) {
      // nobody can measure there
      return;
    }
    ++sum.tissue;
    for (std::size_t axis = 0; axis < extent.axes(); ++axis) {
      sum.variance += std::pow(double{deviation[axis][site]}, 2);
    }
  });
  LeastCertain found;
  for_each_site(grid, [&](int x, int y, int z) {
    const Sum& sum = sums[grid.index(x, y, z)];
    const double here = 2 * sum.tissue >= sum.sites ? std::sqrt(sum.variance / sum.tissue) : 0.0;
    if (here > found.deviation) {
      const std::array<int, 3> at{x, y, z};
      found.deviation = here;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const int last = std::min(sides[axis], (at[axis] + 1) * block) - 1;
        found.at[axis] = 0.5 * (at[axis] * block + last);
      }
    }
  });
  return found;
}

/// The level without its springs and loads; none where conditions do not hold it then, so that nobody can say
/// how far forces would move it.
std::optional<Level> without_springs(const Level& level) {
  Level bare = level;
  bare.force = {};
  bare.springs.clear();
  for (std::vector<float>& component : bare.confidence.planes) {
    std::ranges::replace_if(component, is_spring, 0.0F);
  }
  try {
    require_held(bare);
  } catch (const InputError&) {
    return std::nullopt;
  }
  return bare;
}

/// The scene's level, whose springs are at rest there; what loads do is part of the solution already.
Level resting_at(const Level& level, const VectorField& rest) {
  Level drawn = level;
  drawn.target = rest;
  drawn.force = {};
  return drawn;
}

void add_to(VectorField& field, const VectorField& other, float sign) {
  for (std::size_t axis = 0; axis < field.extent.axes(); ++axis) {
    std::ranges::transform(field[axis], other[axis], field[axis].begin(),
                           [&](float one, float more) { return one + sign * more; });
  }
}

/// Calls `use` for every share of a point in a spring, in an order that is always the same.
void for_each_share(const Scene& scene, const auto& use) {
  for (const KnownPoint& point : scene.points) {
    if (point.deviation > 0.0) {
      for (const PointSpring& spring :
           point_springs(point, scene.extent(), scene.full.sides, scene.spacing)) {
        use(point, scene.extent().index(spring.at[0], spring.at[1], spring.at[2]), spring.weight);
      }
    }
  }
}

} // namespace

Scene with_drawn_moduli(const Scene& scene, double deviation, NormalDraws& random) {
  std::map<int, double> factors;
  for (const int label : scene.labels.values) {
    factors.emplace(label, 1.0);
  }
  for (auto& [label, factor] : factors) { // in the order of labels
    factor = portable_exp(deviation * random());
  }
  Scene drawn = scene;
  const auto draw = [&](Level& level) {
    const float least = void_modulus(level);
    for (std::size_t site = 0; site < scene.labels.values.size(); ++site) {
      if (float& modulus = level.modulus.values[site]; modulus >= least) {
        modulus = static_cast<float>(modulus * factors.at(scene.labels.values[site]));
      }
    }
    keep_void(least, level);
  };
  draw(drawn.full);
  if (drawn.before) {
    draw(*drawn.before);
  }
  return drawn;
}

namespace {

/// Returns forces whose covariance is that of the elastic prior: the stiffness of each cell, times its
/// modulus and the tissue that a point stands for (point_reach). A body of one modulus that only they move,
/// has a displacement with the probability exp(-energy / (modulus * 15.6 mm^3)), of an image 6.25 mm^2. In
/// MPa * thickness or voxel, pixels of area or volume 1.
VectorField prior_forces(const Scene& scene, const CellForces& draw, NormalDraws& random) {
  const Level& full = scene.full;
  const Extent extent = full.extent;
  const std::size_t axes = extent.axes();
  const std::size_t corners = std::size_t{1} << axes;
  const double size = std::sqrt(point_over_voxel(scene));
  DoubleField force;
  force.extent = extent;
  for (std::size_t axis = 0; axis < axes; ++axis) {
    force[axis].assign(extent.sites(), 0.0);
  }
  const auto bit = [](std::size_t corner, std::size_t axis) { return static_cast<int>(corner >> axis & 1U); };
  for_each_site({extent.width - 1, extent.height - 1, std::max(extent.depth - 1, 1)},
                [&](int x, int y, int z) {
                  std::array<std::size_t, 8> sites{};
                  std::array<float, 8> moduli{};
                  for (std::size_t corner = 0; corner < corners; ++corner) {
                    sites[corner] = extent.index(x + bit(corner, 0), y + bit(corner, 1), z + bit(corner, 2));
                    moduli[corner] = full.modulus.values[sites[corner]];
                  }
                  std::array<double, 24> forces{};
                  draw(std::span(moduli).first(corners), random, forces);
                  for (std::size_t corner = 0; corner < corners; ++corner) {
                    for (std::size_t axis = 0; axis < axes; ++axis) {
                      force[axis][sites[corner]] += size * forces[axes * corner + axis];
                    }
                  }
                });
  return force.to_float();
}

/// How far each site that a point with a deviation pulls moves beyond the point itself, pixels: by points,
/// then by their springs.
using Gaps = std::vector<std::array<double, 3>>;
/// Returns them for a displacement of the tissue.
Gaps gaps_of(const Scene& scene, const VectorField& way) {
  Gaps gaps;
  for_each_share(scene, [&](const KnownPoint& point, std::size_t site, double) {
    std::array<double, 3>& gap = gaps.emplace_back();
    for (std::size_t axis = 0; axis < scene.extent().axes(); ++axis) {
      gap[axis] = way[axis][site] -
                  images::linear_at(way[axis], scene.extent(), point.at[0], point.at[1], point.at[2]);
    }
  });
  return gaps;
}

/// Returns a draw whose covariance is the springs by direction of a site, over its modulus: their factor of
/// Cholesky's times draws of 1, where a direction without a spring has none.
std::array<double, 3> drawn_pull(const Level& level, std::size_t site, NormalDraws& random) {
  const std::size_t axes = level.extent.axes();
  std::array<std::array<double, 3>, 3> rest{};
  double trace = 0.0;
  for (std::size_t a = 0; a < axes; ++a) {
    for (std::size_t b = 0; b < axes; ++b) {
      rest[a][b] = double{level.springs[symmetric_entry(axes, a, b)][site]};
    }
    trace += rest[a][a];
  }
  constexpr double rounding = 1e-6; // of entries that are floats
  std::array<double, 3> pull{};
  for (std::size_t pivot = 0; pivot < axes && trace > 0.0; ++pivot) {
    const double draw = random();
    const double whole = rest[pivot][pivot];
    for (std::size_t row = pivot; row < axes && whole > rounding * trace; ++row) {
      const double factor = rest[row][pivot] / whole;
      pull[row] += factor * std::sqrt(whole) * draw;
      for (std::size_t column = pivot + 1; column < axes; ++column) {
        rest[row][column] -= row == pivot ? 0.0 : factor * rest[pivot][column];
      }
    }
  }
  return pull;
}

/// Adds what springs by direction do to where a site is at rest: a wall keeps it, and a target has an error.
void set_rest_by_direction(const Level& level, std::size_t site, VectorField& rest, NormalDraws& random) {
  std::array<double, 3> pull{};
  if (!level.springs.empty()) {
    pull = drawn_pull(level, site, random);
  }
  std::array<double, 3> otherwise{};
  for (std::size_t axis = 0; axis < level.extent.axes(); ++axis) {
    otherwise[axis] = double{rest[axis][site]};
    pull[axis] += weight_of_confidence(level.confidence[axis][site]) * otherwise[axis];
  }
  const std::array<double, 3> at_rest = rest_of_springs(level, site, pull, otherwise);
  for (std::size_t axis = 0; axis < level.extent.axes(); ++axis) {
    rest[axis][site] = static_cast<float>(at_rest[axis]);
  }
}

/// Returns prior_forces(), and where springs are at rest by errors of what they hold: one for every point
/// with a deviation, and what its springs have in common with the point though the tissue there moves
/// otherwise (`gaps`, of the way that the same forces make without springs; empty: none); one for every
/// component of every other site with a confidence below 1.
Disturbance draw_disturbance(const Scene& scene, const CellForces& forces, const Gaps& gaps,
                             NormalDraws& random) {
  const Level& full = scene.full;
  const Extent extent = full.extent;
  Disturbance drawn{VectorField(extent), prior_forces(scene, forces, random)};
  if (!has_springs(full)) {
    return drawn;
  }
  ScalarField of_points(extent); // weights
  DoubleField pulls(drawn.rest); // weights times errors
  const KnownPoint* last = nullptr;
  std::array<double, 3> error{}; // of that point
  std::size_t share = 0;
  for_each_share(scene, [&](const KnownPoint& point, std::size_t site, double weight) {
    if (&point != last) {
      const double deviation = point.deviation / std::sqrt(point.share.value_or(1.0));
      std::ranges::generate(error, [&] { return deviation * random(); });
      last = &point;
    }
    const std::array<double, 3> gap = share < gaps.size() ? gaps[share] : std::array<double, 3>{};
    ++share;
    of_points.values[site] += static_cast<float>(weight);
    for (std::size_t axis = 0; axis < extent.axes(); ++axis) {
      pulls[axis][site] += weight * (error[axis] + gap[axis]);
    }
  });
  constexpr double rounding = 1e-5; // of a weight that went through a confidence
  for (std::size_t axis = 0; axis < extent.axes(); ++axis) {
    for (std::size_t site = 0; site < extent.sites(); ++site) {
      if (const double weight = weight_of_confidence(full.confidence[axis][site]); weight > 0.0) {
        const double others = weight - double{of_points.values[site]};
        const double pull = others > rounding * weight ? std::sqrt(others) * random() : 0.0;
        drawn.rest[axis][site] = static_cast<float>((pulls[axis][site] + pull) / weight);
      }
    }
  }
  for (std::size_t site = 0; has_springs_by_direction(full) && site < extent.sites(); ++site) {
    set_rest_by_direction(full, site, drawn.rest, random);
  }
  return drawn;
}

/// Returns for every stream the gaps_of() what its prior_forces() do to the tissue without springs; no gaps
/// where there are no such points, or no condition holds the tissue without them.
std::vector<Gaps> gaps_of_draws(const Scene& scene, const CellForces& forces,
                                std::vector<NormalDraws> streams, ElasticSession& session,
                                Progress& progress) {
  std::vector<Gaps> gaps(streams.size());
  const bool has_points = std::ranges::any_of(scene.points, &KnownPoint::deviation);
  const std::optional<Level> bare = has_points ? without_springs(scene.full) : std::nullopt;
  if (!bare) {
    return gaps;
  }
  ElasticSolver elastic(*bare, scene.elastic, session);
  for (std::size_t number = 0; number < streams.size(); ++number) {
    if (streams.size() > 1) {
      progress.describe(
          fmt::format("{}: how far may tissue move? {} of {}", scene.name, number + 1, streams.size()));
    }
    elastic.disturb(*bare, scene.elastic.poisson,
                    {VectorField(scene.extent()), prior_forces(scene, forces, streams[number])});
    gaps[number] = gaps_of(
        scene, solve_to_share(enough, most_steps, resting_at(*bare, VectorField(scene.extent())), elastic)
                   .displacement);
  }
  return gaps;
}

} // namespace

void require_spread(const Scene& scene, const SpreadRequest& request) {
  if (!scene.energy->is_of_cells()) {
    throw InputError(
        "--uncertainty is for the elastic energy, whose field follows from deviations and moduli; "
        "give --energy elastic");
  }
  if (has_laws(scene.full)) {
    throw InputError(
        "--uncertainty draws from the linear energy, and some tissue has a law of large strains: "
        "leave one of the two out");
  }
  if (request.moduli > 0.0 && scene.labels.values.empty()) {
    throw InputError(fmt::format(
        "--uncertain-moduli draws one factor for each label, and {} has none (an image of moduli, "
        "or more than 4096 x 4096 sites)",
        scene.name));
  }
}

Spread spread_of(const Scene& scene, const VectorField& solution, const SpreadRequest& request,
                 Solver& solver, Progress& progress) {
  require_spread(scene, request);
  if (const std::optional<Scene> scaled = with_safe_moduli(scene)) {
    return spread_of(*scaled, solution, request, solver, progress);
  }
  ElasticSession& session = solver.elastic();
  SumsOfDraws moments(scene.extent());
  const CellForces forces(scene.full, scene.elastic);
  const auto stream = [&](int number) {
    return NormalDraws(request.seed, static_cast<std::uint32_t>(number));
  };
  progress.set_total(0.0); // the number of the draw says how far it is
  const auto tell = [&](int number) {
    progress.describe(fmt::format("{}: how sure is it? {} of {}", scene.name, number + 1, request.draws));
  };
  if (request.moduli > 0.0) {
    for (int number = 0; number < request.draws; ++number) {
      tell(number);
      NormalDraws random = stream(number);
      const Scene drawn = with_drawn_moduli(scene, request.moduli, random);
      const std::vector<Gaps> gaps = gaps_of_draws(drawn, forces, {random}, session, progress);
      ElasticSolver elastic(drawn.full, drawn.elastic, session);
      VectorField way = solve_to_share(0.1 * enough, most_steps, drawn.full, elastic).displacement;
      add_to(way, solution, -1.0F);
      const Disturbance by = draw_disturbance(drawn, forces, gaps.front(), random);
      elastic.disturb(drawn.full, drawn.elastic.poisson, by);
      add_to(way, solve_to_share(enough, most_steps, resting_at(drawn.full, by.rest), elastic).displacement,
             1.0F);
      moments.add(way);
    }
  } else {
    std::vector<NormalDraws> streams;
    for (int number = 0; number < request.draws; ++number) {
      streams.push_back(stream(number));
    }
    const std::vector<Gaps> gaps = gaps_of_draws(scene, forces, streams, session, progress);
    ElasticSolver elastic(scene.full, scene.elastic, session);
    for (int number = 0; number < request.draws; ++number) {
      tell(number);
      const auto at = static_cast<std::size_t>(number);
      const Disturbance by = draw_disturbance(scene, forces, gaps[at], streams[at]);
      elastic.disturb(scene.full, scene.elastic.poisson, by);
      moments.add(solve_to_share(enough, most_steps, resting_at(scene.full, by.rest), elastic).displacement);
    }
  }
  Spread spread{.mean = moments.mean_from(solution), .deviation = moments.deviation()};
  spread.least_certain = least_certain(scene, spread.deviation);
  spread.moved = root_mean_square_of_tissue(scene.full, spread.mean);
  spread.typical = root_mean_square_of_tissue(scene.full, spread.deviation);
  return spread;
}

} // namespace hdmbench
