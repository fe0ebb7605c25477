#include "harness/applications/registration.hpp"

#include "harness/applications/picture.hpp"
#include "harness/scene/method.hpp"
#include "harness/solve/methods/elastic.hpp"
#include "kernels/data/elastic/conditions.hpp"
#include "kernels/data/input_error.hpp"

#include <Eigen/Cholesky>
#include <fmt/format.h>

#include <cmath>

namespace hdmbench {

namespace {

constexpr int smallest_side = 24;    // pixels, of a level
constexpr double longest_step = 4.0; // pixels of a level: beyond, the gradients know nothing
/// Weaker ones, over the tissue's modulus, are left out of a volume: the noise of pictures that show nothing
/// makes them, and each takes a matrix.
constexpr float weakest_spring = 0.1F;
constexpr int bytes_per_voxel = 540; // by the peak of `register` with the scene head
constexpr double least_noise = 0.01; // of the contrast: what interpolation and halving cost
constexpr double outlier = 3.0;      // standard deviations
/// What happened in a region that is not looked at drives the rest, a growth or a resection: it does not
/// resist as tissue does, and is one tissue.
constexpr float unseen_softness = 0.05F;
/// The region drives where its forces take away so much of the elastic energy.
constexpr double driving_share = 0.5;
constexpr double resistance_to_driving = 0.01; // of the energy that the forces put in: less is no information
constexpr double largest_spring = 1e3;         // times the modulus of the site: no more than float can bear
/// Gray values from one pixel to the next, all axes together: less shows nothing.
constexpr float least_structure = 2.0F;
/// The modulus that IteratedOptions::stiffness was chosen with. A site's evidence is weighed against its own
/// tissue, so that neither the unit of moduli counts nor how stiff a skull is beside a brain.
constexpr double usual_modulus = 20.0;
/// What void is taken for, over the median of what is shown: it shows noise, which would move it far if it
/// did not resist.
constexpr float void_stiffness = 0.5F;

/// One level of the pictures.
struct PictureLevel {
  ScalarField source;
  ScalarField target;
  ScalarField modulus; ///< MPa, at every pixel, or in a volume at every second one along each axis
  ScalarField unseen;  ///< empty: none
  ScalarField still;   ///< what is not tissue; empty: not known
};

/// Of a region, the same everywhere.
struct Strain {
  float xx;
  float yy;
  float xy;
};

/// What the pictures say about the next step, per site of the sheet.
struct Evidence {
  SiteSprings structure;   ///< weighted gradient times gradient
  VectorField pull;        ///< weighted gradient times difference
  double difference = 0.0; ///< gray values
  double outliers = 0.0;
};

/// Returns value(site) of all that are seen and have structure.
template <typename Value>
std::vector<float> where_seen(const VectorField& slope, const ScalarField& unseen, const Value& value) {
  std::vector<float> values;
  for (std::size_t site = 0; site < slope.extent.sites(); ++site) {
    float steepness = 0.0F;
    for (std::size_t axis = 0; axis < slope.extent.axes(); ++axis) {
      steepness += std::abs(slope[axis][site]);
    }
    if (is_seen(unseen, site) && steepness > least_structure) {
      values.push_back(value(site));
    }
  }
  return values;
}

/// Of the differences; 0 where nothing has structure.
double robust_deviation(const ScalarField& differences, const VectorField& slope, const ScalarField& unseen) {
  std::vector<float> magnitudes =
      where_seen(slope, unseen, [&](std::size_t site) { return std::abs(differences.values[site]); });
  return magnitudes.empty() ? 0.0 : static_cast<double>(median_of(magnitudes)) / 0.6745;
}

/// Returns the scene's moduli, void as stiff as one cycle an iteration can take. What has label 0 is no
/// tissue.
ScalarField moduli_without_void(const ScalarField& source, const Scene& scene, const ScalarField& unseen) {
  ScalarField modulus = scene.full.modulus;
  const float least = void_modulus(scene.full);
  std::vector<float> shown = where_seen(gradient(source), unseen, [&](std::size_t site) {
    return scene.labels.values.empty() || scene.labels.values[site] > 0 ? modulus.values[site] : 0.0F;
  });
  std::erase_if(shown, [least](float value) { return value < least; });
  const float filling = shown.empty() ? least : void_stiffness * median_of(shown);
  std::ranges::replace_if(
      modulus.values, [least](float value) { return value < least; }, filling);
  return modulus;
}

/// What a Gaussian leaves of white noise.
double noise_after_blur(double sigma, std::size_t axes) {
  const double square = sigma > 0.0 ? std::min(1.0, 1.0 / (2.0 * std::sqrt(M_PI) * sigma)) : 1.0;
  return axes == 3 ? std::pow(square, 1.5) : square;
}

class LevelRegistration {
public:
  LevelRegistration(const PictureLevel& pictures, double poisson, const IteratedOptions& options, int level,
                    ElasticSession& session)
      : pictures_(pictures), poisson_(poisson), options_(options), level_(level), session_(session),
        every_(pictures.source.extent == pictures.modulus.extent ? 1 : 2),
        source_(blurred(pictures.source, options.blur)), target_(blurred(pictures.target, options.blur)),
        source_slope_(gradient(source_)), target_slope_(gradient(target_)) {
    sheet_.extent = pictures.modulus.extent;
    sheet_.modulus = pictures.modulus;
    sheet_.confidence = VectorField(sheet_.extent);
    if (options.gaussian == 0.0) {
      set_drives();
    }
    const auto [low, high] = std::ranges::minmax(pictures.source.values);
    noise_ = std::max(noise_after_blur(options.blur, sheet_.extent.axes()) *
                          std::hypot(noise_of(pictures.source), noise_of(pictures.target)),
                      least_noise * static_cast<double>(high - low));
  }

  /// One iteration.
  RegistrationIteration improve(VectorField& displacement, int number) {
    const Evidence evidence = look(displacement, number);
    const Extent extent = sheet_.extent;
    const VectorField solution = regularised(displacement, evidence);
    const float longest = static_cast<float>(longest_step) / static_cast<float>(every_);
    double square = 0.0;
    for (std::size_t site = 0; site < extent.sites(); ++site) {
      float length = 0.0F;
      for (std::size_t axis = 0; axis < extent.axes(); ++axis) {
        length = std::hypot(length, solution[axis][site] - displacement[axis][site]);
      }
      const float share = length > longest ? longest / length : 1.0F;
      for (std::size_t axis = 0; axis < extent.axes(); ++axis) {
        displacement[axis][site] += share * (solution[axis][site] - displacement[axis][site]);
      }
      square += static_cast<double>(share * length) * static_cast<double>(share * length);
    }
    return {.level = level_,
            .extent = pictures_.source.extent,
            .difference = evidence.difference,
            .outliers = evidence.outliers,
            .step = std::sqrt(square / static_cast<double>(extent.sites())) * (every_ << level_)};
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
    const ElasticHierarchy free = make_elastic_hierarchy({sheet_, poisson_, Springs::none});
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
          evidence.structure.entries[0][site] * way_x + evidence.structure.entries[1][site] * way_y;
      force[1][site] -=
          evidence.structure.entries[1][site] * way_x + evidence.structure.entries[2][site] * way_y;
    }
    return product(force, solution);
  }

  /// Each site's own step, held as the elastic energy would by its modulus, then a Gaussian over all.
  [[nodiscard]] VectorField made_smooth(const VectorField& displacement, const Evidence& evidence) const {
    VectorField result = displacement;
    for (std::size_t site = 0; site < sheet_.extent.sites(); ++site) {
      const float xx = evidence.structure.entries[0][site] + sheet_.modulus.values[site];
      const float xy = evidence.structure.entries[1][site];
      const float yy = evidence.structure.entries[2][site] + sheet_.modulus.values[site];
      const float determinant = xx * yy - xy * xy;
      result[0][site] += (yy * evidence.pull[0][site] - xy * evidence.pull[1][site]) / determinant;
      result[1][site] += (xx * evidence.pull[1][site] - xy * evidence.pull[0][site]) / determinant;
    }
    return blurred(result, options_.gaussian);
  }

  /// What the pictures are by this displacement, site by site of theirs.
  struct Sight {
    ScalarField differences; ///< source, in gray values of the target, minus target
    VectorField slope;       ///< of both, their mean
  };

  [[nodiscard]] Sight sight_of(const VectorField& displacement) const {
    const Extent extent = displacement.extent;
    const ScalarField seen = pulled_back(target_, displacement);
    const ScalarField expected = with_values_of(source_, seen, pictures_.unseen);
    Sight sight{ScalarField(extent), VectorField(extent)};
#pragma omp parallel for
    for (int row = 0; row < extent.rows(); ++row) {
      for (int x = 0; x < extent.width; ++x) {
        const std::size_t site = extent.index(x, row);
        sight.differences.values[site] = expected.values[site] - seen.values[site];
        const auto [at_x, at_y, at_z] = end_of(displacement, x, row);
        for (std::size_t axis = 0; axis < extent.axes(); ++axis) {
          const float there = sample(target_slope_[axis], extent, at_x, at_y, at_z);
          sight.slope[axis][site] = 0.5F * (source_slope_[axis][site] + there);
        }
      }
    }
    return sight;
  }

  [[nodiscard]] Evidence look(const VectorField& displacement, int number) const {
    const Extent extent = pictures_.source.extent;
    const Sight sight = sight_of(every_ == 1 ? displacement : doubled(displacement, extent));
    Evidence evidence{SiteSprings(sheet_.extent), VectorField(sheet_.extent)};
    // Early on what does not match has not been moved yet; later it is another thing.
    const double deviation =
        std::max(robust_deviation(sight.differences, sight.slope, pictures_.unseen), noise_);
    const double octaves = level_ + (number < 2 ? 1.0 : 0.0);
    const auto scale = static_cast<float>(outlier * deviation * std::exp2(octaves));
    const double stiffness = (extent.axes() == 3 ? 0.5 : 1.0) * options_.stiffness;
    const auto unit = static_cast<float>(1.0 / (stiffness * usual_modulus * noise_ * noise_));
    ScalarField weight(extent); // of a difference, squared, over a modulus; 0 where nobody looks
    double robust = 0.0;
    double weights = 0.0;
    double outliers = 0.0;
    for (std::size_t site = 0; site < extent.sites(); ++site) {
      const float difference = sight.differences.values[site];
      const float ratio = difference / scale;
      const float match = 1.0F / ((1.0F + ratio * ratio) * (1.0F + ratio * ratio));
      robust += static_cast<double>(match * difference * difference);
      weights += static_cast<double>(match);
      outliers += match < 0.5F ? 1.0 : 0.0;
      weight.values[site] = is_seen(pictures_.unseen, site) ? unit * match : 0.0F;
    }
    evidence.difference = std::sqrt(robust / weights);
    evidence.outliers = outliers / static_cast<double>(extent.sites());
#pragma omp parallel for if (sheet_.extent.sites() > sites_worth_threads)
    for (int row = 0; row < sheet_.extent.rows(); ++row) {
      for (int x = 0; x < sheet_.extent.width; ++x) {
        gather(sight, weight, {x, row % sheet_.extent.height, row / sheet_.extent.height}, evidence);
      }
    }
    return evidence;
  }

  /// call(pixel, share) for what a site of the sheet stands for: its pixel, or where it has every second one
  /// those around, with the share that linear interpolation between sites gives it.
  template <typename Call>
  void for_each_pixel(const std::array<int, 3>& at, const Call& call) const {
    const Extent extent = pictures_.source.extent;
    if (every_ == 1) {
      call(extent.index(at[0], at[1], at[2]), 1.0F);
      return;
    }
    for (int number = 0; number < 27; ++number) {
      const std::array<int, 3> off{number % 3 - 1, number / 3 % 3 - 1, number / 9 - 1};
      std::array<int, 3> to{};
      float share = 1.0F;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        to[axis] = every_ * at[axis] + off[axis];
        const bool is_there = to[axis] >= 0 && to[axis] < extent.sides()[axis];
        share *= !is_there ? 0.0F : off[axis] == 0 ? 1.0F : 0.5F;
      }
      if (share > 0.0F) {
        call(extent.index(to[0], to[1], to[2]), share);
      }
    }
  }

  /// Sets the evidence of a site of the sheet. `weight`: of each pixel's squared difference, over a modulus.
  void gather(const Sight& sight, const ScalarField& weight, const std::array<int, 3>& at,
              Evidence& evidence) const {
    const std::size_t axes = sheet_.extent.axes();
    const std::size_t own = sheet_.extent.index(at[0], at[1], at[2]);
    const float own_modulus = sheet_.modulus.values[own];
    const float most = static_cast<float>(largest_spring) * own_modulus;
    std::array<float, 6> structure{};
    std::array<float, 3> pull{};
    for_each_pixel(at, [&](std::size_t pixel, float share) {
      float steep = 0.0F;
      for (std::size_t axis = 0; axis < axes; ++axis) {
        steep += sight.slope[axis][pixel] * sight.slope[axis][pixel];
      }
      const float full = share * std::min(own_modulus * weight.values[pixel], most / std::max(steep, 1e-6F));
      for (std::size_t axis = 0; axis < axes; ++axis) {
        const float pulls = full * sight.slope[axis][pixel];
        pull[axis] += pulls * sight.differences.values[pixel];
        for (std::size_t other = axis; other < axes; ++other) {
          structure[symmetric_entry(axes, axis, other)] += pulls * sight.slope[other][pixel];
        }
      }
    });
    // In steps of the sheet, over the volume of its cells.
    const auto step = static_cast<float>(every_);
    const float content = every_ == 1 ? 1.0F : step * step * step;
    float trace = 0.0F;
    for (std::size_t axis = 0; axis < axes; ++axis) {
      trace += structure[symmetric_entry(axes, axis, axis)] * (step * step / content);
    }
    if (every_ > 1 && trace < weakest_spring * own_modulus) {
      return;
    }
    for (std::size_t axis = 0; axis < axes; ++axis) {
      evidence.pull[axis][own] = pull[axis] * (step / content);
    }
    for (std::size_t entry = 0; entry < evidence.structure.entries.size(); ++entry) {
      evidence.structure.entries[entry][own] = structure[entry] * (step * step / content);
    }
  }

  const PictureLevel& pictures_;
  double poisson_;
  const IteratedOptions& options_;
  int level_;
  ElasticSession& session_;
  int every_;          ///< pixels from a site of the sheet to the next
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
  ScalarField modulus = moduli_without_void(source, scene, unseen);
  std::vector<PictureLevel> levels{{source, target,
                                    source.extent.depth > 1 ? halved_mean(modulus) : std::move(modulus),
                                    unseen, std::move(still)}};
  const auto shortest = [](Extent extent) {
    const std::array<int, 3> sides = extent.sides();
    return *std::min_element(sides.begin(), sides.begin() + static_cast<std::ptrdiff_t>(extent.axes()));
  };
  while (static_cast<int>(levels.size()) < most &&
         shortest(levels.back().source.extent) >= 2 * smallest_side) {
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
  if (source.extent.axes() == 3) {
    if (!unseen.values.empty()) {
      throw InputError("registration of volumes knows no region of interest: leave it out");
    }
    if (options.gaussian > 0.0) {
      throw InputError("a Gaussian in place of the elastic energy is for images only");
    }
    RegisteredEnergy with_matrices = *scene.energy;
    with_matrices.bytes_per_voxel = bytes_per_voxel;
    require_memory(source.extent, with_matrices);
  }
  if (scene.full.sides != Level{}.sides) {
    throw InputError(
        "registration takes square pixels and cubes alone: resample the pictures and the labels");
  }
  require_conditions_alone(scene.full, "registration that looks again");
  const auto start = std::chrono::steady_clock::now();
  const std::vector<PictureLevel> levels = picture_levels(source, target, scene, unseen, options.levels);
  IteratedRegistration result;
  VectorField displacement(levels.back().modulus.extent);
  for (int level = static_cast<int>(levels.size()) - 1; level >= 0; --level) {
    const PictureLevel& pictures = levels[static_cast<std::size_t>(level)];
    if (displacement.extent != pictures.modulus.extent) {
      displacement = doubled(displacement, pictures.modulus.extent);
    }
    LevelRegistration registration(pictures, scene.elastic.poisson, options, level, session);
    result.converged = false;
    for (int iteration = 0; iteration < options.iterations && !result.converged; ++iteration) {
      progress.describe(
          fmt::format("register: {}, iteration {}", pictures.source.extent.text(), iteration + 1));
      result.iterations.push_back(registration.improve(displacement, iteration));
      result.converged =
          iteration >= 2 && result.iterations.back().step < options.smallest_step * (1 << level);
      progress.advance(static_cast<double>(displacement.extent.sites()));
    }
    result.noise = registration.noise();
  }
  result.displacement =
      displacement.extent == source.extent ? std::move(displacement) : doubled(displacement, source.extent);
  result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return result;
}

} // namespace hdmbench
