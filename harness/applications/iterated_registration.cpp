#include "harness/applications/registration.hpp"

#include "harness/applications/picture.hpp"
#include "harness/solve/methods/elastic.hpp"

#include <Eigen/Cholesky>
#include <fmt/format.h>

#include <cmath>

namespace hdmbench {

namespace {

constexpr int smallest_side = 24;    // pixels, of a level
constexpr double longest_step = 4.0; // pixels of a level: beyond, the gradients know nothing
constexpr double least_noise = 0.01; // of the contrast: what interpolation and halving cost
constexpr double outlier = 3.0;      // standard deviations
/// What happened in a region that is not looked at drives the rest, a growth or a resection: it does not
/// resist as tissue does, and is one tissue.
constexpr float unseen_softness = 0.05F;
/// The region drives where its forces take away so much of the elastic energy.
constexpr double driving_share = 0.5;
constexpr double resistance_to_driving = 0.01; // of the energy that the forces put in: less is no information
constexpr double largest_spring = 1e3;         // times the modulus of the site: no more than float can bear

/// One level of the pictures.
struct PictureLevel {
  ScalarField source;
  ScalarField target;
  ScalarField modulus;
  ScalarField unseen; ///< empty: none
  ScalarField still;  ///< what is not tissue; empty: not known
};

/// Of a region, the same everywhere.
struct Strain {
  float xx;
  float yy;
  float xy;
};

/// What the pictures say about the next step, per site.
struct Evidence {
  SiteSprings structure;   ///< weighted gradient times gradient
  VectorField pull;        ///< weighted gradient times difference
  double difference = 0.0; ///< gray values
  double outliers = 0.0;
};

/// Of the magnitudes of those that are seen and have structure; 0 without any.
double robust_deviation(const ScalarField& differences, const VectorField& slope, const ScalarField& unseen) {
  std::vector<float> magnitudes;
  for (std::size_t site = 0; site < differences.values.size(); ++site) {
    if (is_seen(unseen, site) && std::abs(slope[0][site]) + std::abs(slope[1][site]) > 2.0F) {
      magnitudes.push_back(std::abs(differences.values[site]));
    }
  }
  return magnitudes.empty() ? 0.0 : static_cast<double>(median_of(magnitudes)) / 0.6745;
}

/// What a Gaussian leaves of white noise.
double noise_after_blur(double sigma) {
  return sigma > 0.0 ? std::min(1.0, 1.0 / (2.0 * std::sqrt(M_PI) * sigma)) : 1.0;
}

class LevelRegistration {
public:
  LevelRegistration(const PictureLevel& pictures, double poisson, const IteratedOptions& options, int level,
                    ElasticSession& session)
      : pictures_(pictures), poisson_(poisson), options_(options), level_(level), session_(session),
        source_(blurred(pictures.source, options.blur)), target_(blurred(pictures.target, options.blur)),
        source_slope_(gradient(source_)), target_slope_(gradient(target_)) {
    sheet_.extent = pictures.source.extent;
    sheet_.modulus = pictures.modulus;
    sheet_.confidence = VectorField(sheet_.extent);
    if (options.gaussian == 0.0) {
      set_drives();
    }
    const auto [low, high] = std::ranges::minmax(pictures.source.values);
    noise_ = std::max(noise_after_blur(options.blur) *
                          std::hypot(noise_of(pictures.source), noise_of(pictures.target)),
                      least_noise * static_cast<double>(high - low));
  }

  /// One iteration.
  RegistrationIteration improve(VectorField& displacement, int number) {
    const Evidence evidence = look(displacement, number);
    const Extent extent = sheet_.extent;
    const VectorField solution = regularised(displacement, evidence);
    double square = 0.0;
    for (std::size_t site = 0; site < extent.sites(); ++site) {
      const float step_x = solution[0][site] - displacement[0][site];
      const float step_y = solution[1][site] - displacement[1][site];
      const float length = std::hypot(step_x, step_y);
      const float share = length > longest_step ? static_cast<float>(longest_step) / length : 1.0F;
      displacement[0][site] += share * step_x;
      displacement[1][site] += share * step_y;
      square += static_cast<double>(share * length) * static_cast<double>(share * length);
    }
    return {.level = level_,
            .extent = extent,
            .difference = evidence.difference,
            .outliers = evidence.outliers,
            .step = std::sqrt(square / static_cast<double>(extent.sites())) * (1 << level_)};
  }

  [[nodiscard]] double noise() const { return noise_; }

private:
  /// What becomes of the tissue around when the region is strained about its middle, while what is not tissue
  /// and the border of the image stay, and the forces that do it.
  struct Drive {
    VectorField displacement;
    VectorField force; ///< MPa * pixel * thickness
  };

  void set_drives() {
    if (std::ranges::none_of(pictures_.unseen.values, [](float value) { return value > 0.0F; })) {
      return;
    }
    blend_moduli(sheet_.modulus, pictures_.unseen, unseen_softness);
    const Extent extent = sheet_.extent;
    const auto is_inside = [&](std::size_t site) { return pictures_.unseen.values[site] > 0.5F; };
    Level held = sheet_;
    double sum_x = 0.0;
    double sum_y = 0.0;
    double sites = 0.0;
    for_each_site(extent, [&](int x, int y) {
      const std::size_t site = extent.index(x, y);
      const bool at_border = x == 0 || y == 0 || x == extent.width - 1 || y == extent.height - 1;
      const bool is_still = !pictures_.still.values.empty() && pictures_.still.values[site] > 0.5F;
      if (is_inside(site)) {
        sum_x += x;
        sum_y += y;
        sites += 1.0;
      }
      if (is_inside(site) || at_border || is_still) {
        held.confidence[0][site] = held.confidence[1][site] = 1.0F;
      }
    });
    const auto middle_x = static_cast<float>(sum_x / std::max(sites, 1.0));
    const auto middle_y = static_cast<float>(sum_y / std::max(sites, 1.0));
    const SiteSprings none;
    const VectorField no_force(extent);
    ElasticSolver solver(held, poisson_, none, session_);
    for (const Strain& strain :
         {Strain{1.0F, 0.0F, 0.0F}, Strain{0.0F, 1.0F, 0.0F}, Strain{0.0F, 0.0F, 1.0F}}) {
      VectorField strained(extent);
      for_each_site(extent, [&](int x, int y) {
        const std::size_t site = extent.index(x, y);
        const float from_x = is_inside(site) ? static_cast<float>(x) - middle_x : 0.0F;
        const float from_y = is_inside(site) ? static_cast<float>(y) - middle_y : 0.0F;
        strained[0][site] = strain.xx * from_x + strain.xy * from_y;
        strained[1][site] = strain.xy * from_x + strain.yy * from_y;
      });
      solver.pull(std::move(strained), no_force);
      solver.full_multigrid();
      drives_.push_back({solver.displacement(), {}});
    }
    // What pulls back where the sheet is free is minus what does it.
    const ElasticHierarchy free = make_elastic_hierarchy(sheet_, poisson_, Springs::none);
    session_.load(free);
    const auto unit = static_cast<float>(-force_unit(sheet_, poisson_));
    for (Drive& drive : drives_) {
      session_.write(0, ElasticField::displacement, drive.displacement);
      session_.forces(ElasticField::displacement, ElasticField::load);
      session_.read(0, ElasticField::load, drive.force);
      for (std::vector<float>& component : drive.force.planes) {
        std::ranges::for_each(component, [&](float& force) { force /= unit; });
      }
    }
  }

  /// The displacement that neighbours agree on.
  [[nodiscard]] VectorField regularised(const VectorField& displacement, const Evidence& evidence) const {
    if (options_.gaussian > 0.0) {
      return made_smooth(displacement, evidence);
    }
    ElasticSolver solver(sheet_, poisson_, evidence.structure, session_);
    solver.pull(displacement, evidence.pull);
    solver.full_multigrid();
    VectorField solution = solver.displacement();
    if (!drives_.empty()) {
      drive(solution, displacement, evidence, solver);
    }
    return solution;
  }

  /// The elastic energy of what the region does to the tissue around it is no reason to do less of it. With
  /// U the displacements by the drives' forces F alone, energy counts from U a instead of from 0:
  ///     minimise  1/2 (d - U a)' A (d - U a) + springs(d)  over d and a,
  /// so d(a) = d(0) + W a with (A + springs) W = F, and F'(U - W) a = F' d(0).
  void drive(VectorField& solution, const VectorField& start, const Evidence& evidence,
             ElasticSolver& solver) const {
    std::array<VectorField, drive_count> responses;
    Eigen::Matrix<double, drive_count, drive_count> matrix;
    Eigen::Vector<double, drive_count> wanted;
    for (std::size_t i = 0; i < drive_count; ++i) {
      solver.pull(VectorField(sheet_.extent), drives_[i].force);
      solver.full_multigrid();
      responses[i] = solver.displacement();
    }
    for (std::size_t i = 0; i < drive_count; ++i) {
      const auto row = static_cast<Eigen::Index>(i);
      const VectorField& force = drives_[i].force;
      wanted[row] = product(force, solution);
      for (std::size_t j = 0; j < drive_count; ++j) {
        matrix(row, static_cast<Eigen::Index>(j)) =
            product(force, drives_[j].displacement) - product(force, responses[j]);
      }
      matrix(row, row) += resistance_to_driving * product(force, drives_[i].displacement);
    }
    matrix = (0.5 * (matrix + matrix.transpose())).eval();
    const Eigen::Vector<double, drive_count> amounts = matrix.ldlt().solve(wanted);
    if (!(wanted.dot(amounts) >= driving_share * twice_energy(solution, start, evidence))) {
      return;
    }
    for (std::size_t i = 0; i < drive_count; ++i) {
      add(solution, static_cast<float>(amounts[static_cast<Eigen::Index>(i)]), responses[i]);
    }
  }

  /// Of the sheet: what pull and springs do, which A d balances.
  [[nodiscard]] static double twice_energy(const VectorField& solution, const VectorField& start,
                                           const Evidence& evidence) {
    VectorField force = evidence.pull;
    for (std::size_t site = 0; site < force[0].size(); ++site) {
      const float way_x = solution[0][site] - start[0][site];
      const float way_y = solution[1][site] - start[1][site];
      force[0][site] -=
          evidence.structure.xx.values[site] * way_x + evidence.structure.xy.values[site] * way_y;
      force[1][site] -=
          evidence.structure.xy.values[site] * way_x + evidence.structure.yy.values[site] * way_y;
    }
    return product(force, solution);
  }

  /// Each site's own step, held as the elastic energy would by its modulus, then a Gaussian over all.
  [[nodiscard]] VectorField made_smooth(const VectorField& displacement, const Evidence& evidence) const {
    VectorField result = displacement;
    for (std::size_t site = 0; site < sheet_.extent.sites(); ++site) {
      const float xx = evidence.structure.xx.values[site] + sheet_.modulus.values[site];
      const float xy = evidence.structure.xy.values[site];
      const float yy = evidence.structure.yy.values[site] + sheet_.modulus.values[site];
      const float determinant = xx * yy - xy * xy;
      result[0][site] += (yy * evidence.pull[0][site] - xy * evidence.pull[1][site]) / determinant;
      result[1][site] += (xx * evidence.pull[1][site] - xy * evidence.pull[0][site]) / determinant;
    }
    return blurred(result, options_.gaussian);
  }

  [[nodiscard]] Evidence look(const VectorField& displacement, int number) const {
    const Extent extent = sheet_.extent;
    const ScalarField seen = pulled_back(target_, displacement);
    const ScalarField expected = with_values_of(source_, seen, pictures_.unseen);
    ScalarField differences(extent);
    VectorField slope(extent);
#pragma omp parallel for
    for (int y = 0; y < extent.height; ++y) {
      for (int x = 0; x < extent.width; ++x) {
        const std::size_t site = extent.index(x, y);
        differences.values[site] = expected.values[site] - seen.values[site];
        for (std::size_t axis = 0; axis < extent.axes(); ++axis) {
          const float there =
              sample(target_slope_[axis], extent, static_cast<float>(x) + displacement[0][site],
                     static_cast<float>(y) + displacement[1][site]);
          slope[axis][site] = 0.5F * (source_slope_[axis][site] + there);
        }
      }
    }
    Evidence evidence{{ScalarField(extent), ScalarField(extent), ScalarField(extent)}, VectorField(extent)};
    // Early on what does not match has not been moved yet; later it is another thing.
    const double deviation = std::max(robust_deviation(differences, slope, pictures_.unseen), noise_);
    const double octaves = level_ + (number < 2 ? 1.0 : 0.0);
    const auto scale = static_cast<float>(outlier * deviation * std::exp2(octaves));
    const auto unit = static_cast<float>(1.0 / (options_.stiffness * noise_ * noise_));
    double robust = 0.0;
    double weights = 0.0;
    double outliers = 0.0;
    for (std::size_t site = 0; site < extent.sites(); ++site) {
      const float ratio = differences.values[site] / scale;
      const float match = 1.0F / ((1.0F + ratio * ratio) * (1.0F + ratio * ratio));
      robust += static_cast<double>(match * differences.values[site] * differences.values[site]);
      weights += static_cast<double>(match);
      outliers += match < 0.5F ? 1.0 : 0.0;
      if (!is_seen(pictures_.unseen, site)) {
        continue;
      }
      const float slope_x = slope[0][site];
      const float slope_y = slope[1][site];
      const float most = static_cast<float>(largest_spring) * sheet_.modulus.values[site];
      const float full = unit * match;
      const float weight = std::min(full, most / std::max(slope_x * slope_x + slope_y * slope_y, 1e-6F));
      evidence.structure.xx.values[site] = weight * slope_x * slope_x;
      evidence.structure.xy.values[site] = weight * slope_x * slope_y;
      evidence.structure.yy.values[site] = weight * slope_y * slope_y;
      evidence.pull[0][site] = weight * slope_x * differences.values[site];
      evidence.pull[1][site] = weight * slope_y * differences.values[site];
    }
    evidence.difference = std::sqrt(robust / weights);
    evidence.outliers = outliers / static_cast<double>(extent.sites());
    return evidence;
  }

  const PictureLevel& pictures_;
  double poisson_;
  const IteratedOptions& options_;
  int level_;
  ElasticSession& session_;
  ScalarField source_; ///< blurred, as target_
  ScalarField target_;
  VectorField source_slope_;
  VectorField target_slope_;
  Level sheet_; ///< moduli without conditions
  static constexpr std::size_t drive_count = 3;
  std::vector<Drive> drives_; ///< none without a region
  double noise_ = 0.0;
};

std::vector<PictureLevel> picture_levels(const ScalarField& source, const ScalarField& target,
                                         const Scene& scene, const ScalarField& unseen, int most) {
  ScalarField still;
  if (!scene.labels.values.empty()) {
    still = ScalarField(source.extent);
    std::ranges::transform(scene.labels.values, still.values.begin(),
                           [](int label) { return label > 0 ? 0.0F : 1.0F; });
  }
  std::vector<PictureLevel> levels{{source, target, scene.full.modulus, unseen, std::move(still)}};
  while (static_cast<int>(levels.size()) < most &&
         std::min(levels.back().source.extent.width, levels.back().source.extent.height) >=
             2 * smallest_side) {
    const PictureLevel& fine = levels.back();
    levels.push_back({halved(fine.source), halved(fine.target), halved_mean(fine.modulus),
                      halved_mean(fine.unseen), halved_mean(fine.still)});
  }
  return levels;
}

} // namespace

IteratedRegistration register_iteratively(const ScalarField& source, const ScalarField& target,
                                          const Scene& scene, const ScalarField& unseen,
                                          const IteratedOptions& options, ElasticSession& session,
                                          Progress& progress) {
  require_pair(source, target);
  require_conditions_alone(scene.full, "registration that looks again");
  const auto start = std::chrono::steady_clock::now();
  const std::vector<PictureLevel> levels = picture_levels(source, target, scene, unseen, options.levels);
  IteratedRegistration result;
  VectorField displacement(levels.back().source.extent);
  for (int level = static_cast<int>(levels.size()) - 1; level >= 0; --level) {
    const PictureLevel& pictures = levels[static_cast<std::size_t>(level)];
    if (displacement.extent != pictures.source.extent) {
      displacement = doubled(displacement, pictures.source.extent);
    }
    LevelRegistration registration(pictures, scene.elastic.poisson, options, level, session);
    result.converged = false;
    for (int iteration = 0; iteration < options.iterations && !result.converged; ++iteration) {
      progress.describe(fmt::format("register: {}, iteration {}", displacement.extent.text(), iteration + 1));
      result.iterations.push_back(registration.improve(displacement, iteration));
      result.converged =
          iteration >= 2 && result.iterations.back().step < options.smallest_step * (1 << level);
      progress.advance(static_cast<double>(displacement.extent.sites()));
    }
    result.noise = registration.noise();
  }
  result.displacement = std::move(displacement);
  result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return result;
}

} // namespace hdmbench
