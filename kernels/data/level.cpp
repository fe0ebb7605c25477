#include "kernels/data/level.hpp"

#include "kernels/data/input_error.hpp"
#include "kernels/specification/hdm/energy.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace hdmbench {

namespace energies::Hdm {
extern const EnergyOnHost on_host;
}

// Operations of a site, counted in the texts.
const Energy thesis_energy{.name = "hdm",
                           .inputs = HdmInFloat::input_count,
                           .couples = HdmInFloat::couples,
                           .coloured_sets = HdmInFloat::coloured_sets,
                           .costs = {{{109, 18}, {103, 8}, {78, 16}, {72, 6}}},
                           .host = &energies::Hdm::on_host,
                           .programs = nullptr,
                           .proofs = nullptr};

namespace {

void require_size(std::size_t values, Extent found, Extent extent, const char* what) {
  if (found != extent || values != extent.sites()) {
    throw InputError(
        fmt::format("{} is {} with {} values, the scene is {}", what, found.text(), values, extent.text()));
  }
}

/// The first site that breaks `holds` is named in the error.
template <typename Predicate>
void require(const std::vector<float>& values, Extent extent, const char* what, const char* rule,
             Predicate holds) {
  const auto found = std::ranges::find_if_not(values, holds);
  if (found != values.end()) {
    throw InputError(fmt::format("{} at {} is {}, it must be {}", what,
                                 extent.place(static_cast<std::size_t>(found - values.begin())), *found,
                                 rule));
  }
}

void require_strengths(const Level& level) {
  const bool anneals = level.rule == Rule::annealing;
  if (level.strengths.empty()) {
    throw InputError("this rule needs a strength per sweep, none is given");
  }
  for (const float strength : level.strengths) {
    if (!(anneals ? strength >= 0.0F : strength > 0.0F && strength < 2.0F) || !std::isfinite(strength)) {
      throw InputError(anneals
                           ? fmt::format("an inverse temperature is {}, it must be finite and >= 0", strength)
                           : fmt::format("a relaxation is {}, it must be above 0 and below 2", strength));
    }
  }
}

bool is_finite(float value) {
  return std::isfinite(value);
}

} // namespace

void require_sides(Extent extent) {
  if (extent.axes() > 2 && std::min({extent.width, extent.height, extent.depth}) < 2) {
    throw InputError(fmt::format("the volume is {} voxels, each side must be at least 2", extent.text()));
  }
  if (extent.width < 1 || extent.height < 1 || extent.depth < 1) {
    throw InputError(fmt::format("the image is {} pixels, each must be at least 1", extent.text()));
  }
}

Level without_fields(const Level& level) {
  // A new member has to be named here, or this does not compile: it is kept below unless it is an array.
  const auto& [extent, energy, target, confidence, modulus, inverse_modulus, inputs, penalty, steps, update,
               rule, inverse_curvature, strengths, seed, sides, force, law, law_parameter, fibre,
               fibre_compression, springs, walls, has_walls] = level;
  return {.extent = extent,
          .energy = energy,
          .penalty = penalty,
          .steps = steps,
          .update = update,
          .rule = rule,
          .strengths = strengths,
          .seed = seed,
          .sides = sides,
          .law = law,
          .has_walls = has_walls};
}

bool changes_spread_by_contact(const Level& level) {
  return level.rule == Rule::steps && level.update == Update::simultaneous;
}

void set_inverse_modulus(Level& level) {
  level.inverse_modulus = ScalarField(level.modulus.extent);
  std::ranges::transform(level.modulus.values, level.inverse_modulus.values.begin(),
                         [](float modulus) { return 1.0F / modulus; });
}

void set_inverse_curvature(Level& level) {
  const Extent extent = level.extent;
  level.inverse_curvature.extent = extent;
  for (std::size_t axis = 0; axis < extent.axes(); ++axis) {
    level.inverse_curvature[axis].resize(extent.sites());
  }
#pragma omp parallel for if (extent.sites() > sites_worth_threads)
  for (int row = 0; row < extent.rows(); ++row) {
    level.energy->host->set_inverse_curvature(level, row % extent.height, row / extent.height);
  }
}

double mean_energy(const Level& level, const VectorField& displacement) {
  const Extent extent = level.extent;
  std::vector<double> of_rows(static_cast<std::size_t>(extent.rows())); // as threads share them out
#pragma omp parallel for if (extent.sites() > sites_worth_threads)
  for (int row = 0; row < extent.rows(); ++row) {
    for (int x = 0; x < extent.width; ++x) {
      of_rows[static_cast<std::size_t>(row)] += static_cast<double>(
          level.energy->host->site_energy(level, displacement, x, row % extent.height, row / extent.height));
    }
  }
  return std::accumulate(of_rows.begin(), of_rows.end(), 0.0) / static_cast<double>(extent.sites());
}

Undetermined find_undetermined(int thickness, std::span<const float> confidence) {
  const auto is_free = [](float value) { return !(value > 0.0F); };
  const auto count = static_cast<std::size_t>(std::ranges::count_if(confidence, is_free));
  if (count == 0 || (thickness > 1 && count < confidence.size())) {
    return {};
  }
  return {.sites = count,
          .first = static_cast<std::size_t>(std::ranges::find_if(confidence, is_free) - confidence.begin())};
}

void validate(const VectorField& field, Extent extent, const char* what) {
  for (std::size_t axis = 0; axis < extent.axes(); ++axis) {
    require_size(field[axis].size(), field.extent, extent, what);
    require(field[axis], extent, what, "finite", is_finite);
  }
}

void validate(const Level& level) {
  require_sides(level.extent);
  if (!(level.penalty > 0.0F) || !std::isfinite(level.penalty)) {
    throw InputError(fmt::format("the penalty K is {}, it must be positive and finite", level.penalty));
  }
  validate(level.target, level.extent, "the target displacement");
  validate(level.confidence, level.extent, "the confidence");
  if (has_forces(level)) {
    validate(level.force, level.extent, "the load");
  }
  if (has_laws(level)) {
    require_size(level.law_parameter.values.size(), level.law_parameter.extent, level.extent,
                 "the law's parameter");
    require(level.law_parameter.values, level.extent, "the law's parameter", "finite", is_finite);
  }
  if (has_fibres(level)) {
    validate(level.fibre, level.extent, "the fibre");
    require_size(level.fibre_compression.values.size(), level.fibre_compression.extent, level.extent,
                 "the compression of fibres");
  }
  for (const auto* const by_direction : {&level.springs, &level.walls}) {
    for (const std::vector<float>& entry : *by_direction) {
      require_size(entry.size(), level.extent, level.extent, "a field of springs");
      require(entry, level.extent, "a spring", "finite", is_finite);
    }
  }
  const auto in_unit_interval = [](float value) { return value >= 0.0F && value <= 1.0F; };
  for (std::size_t axis = 0; axis < level.extent.axes(); ++axis) {
    const std::string what = fmt::format("the confidence in {}", "xyz"[axis]);
    require(level.confidence[axis], level.extent, what.c_str(), "within 0 ... 1", in_unit_interval);
  }
  require_size(level.modulus.values.size(), level.modulus.extent, level.extent, "the modulus");
  require(level.modulus.values, level.extent, "the modulus (MPa)",
          "positive and finite, and so must its inverse as a 32-bit float",
          [](float value) { return value > 0.0F && std::isfinite(value) && std::isfinite(1.0F / value); });
  require_size(level.inverse_modulus.values.size(), level.inverse_modulus.extent, level.extent,
               "the inverse modulus");
  if (level.inputs.size() != static_cast<std::size_t>(level.energy->inputs)) {
    throw InputError(fmt::format("the energy {} reads {} numbers of its own per site, {} are given",
                                 level.energy->name, level.energy->inputs, level.inputs.size()));
  }
  for (const ScalarField& input : level.inputs) {
    require_size(input.values.size(), input.extent, level.extent, "an input of the energy");
    require(input.values, level.extent, "an input of the energy", "finite", is_finite);
  }
  if (needs_inverse_curvature(level.rule)) {
    validate(level.inverse_curvature, level.extent, "the inverse curvature");
  }
  if (level.rule != Rule::steps) {
    require_strengths(level);
  }
  for (const double side : level.sides) {
    if (!(side >= 1.0 && side <= most_oblong)) {
      throw InputError(fmt::format(
          "a side of the pixels is {:g} times the shortest one, it must be 1 ... {:g}", side, most_oblong));
    }
  }
  if (level.seed < 0 || level.seed > 4092) {
    throw InputError(fmt::format("the seed is {}, it must be 0 ... 4092", level.seed));
  }
}

} // namespace hdmbench
