#include "harness/measure/kernels.hpp"

#include "backends/shared/elastic_session.hpp"
#include "harness/measure/cost.hpp"
#include "harness/scene/method.hpp"
#include "harness/scene/scene.hpp"
#include "kernels/data/elastic/law_forces.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace hdmbench {

namespace {

constexpr std::array kind_names{"sweep", "sweep, unobserved", "sweep, uniform", "sweep, uniform, unobserved"};
constexpr int sweeps_together = 8; ///< that some backends take through their caches at once

/// All sites are of one kind; candidates of the scenes that are shipped.
Level level_of_kind(Extent extent, SiteKind kind) {
  Level level = load_scene(extent.axes() == 3 ? "cube" : "square", {.size = extent}).full;
  const bool is_uniform = kind == SiteKind::uniform || kind == SiteKind::uniform_unobserved;
  const bool is_observed = kind == SiteKind::general || kind == SiteKind::uniform;
  for (std::size_t i = 0; i < level.modulus.values.size(); ++i) {
    level.modulus.values[i] = is_uniform ? 1.0F : 1.0F + 0x1p-13F * static_cast<float>(i * 7919 % 8191);
  }
  set_inverse_modulus(level);
  for (std::vector<float>& component : level.confidence.planes) {
    std::ranges::fill(component, is_observed ? 0.5F : 0.0F);
  }
  return level;
}

/// Displacements that differ from site to site, by `unit` times 0 ... 1020.
VectorField any_field(Extent extent, float unit = 0x1p-10F) {
  VectorField field(extent);
  for (std::size_t axis = 0; axis < extent.axes(); ++axis) {
    for (std::size_t i = 0; i < extent.sites(); ++i) {
      field[axis][i] = unit * static_cast<float>((i + axis) * 7919 % 1021);
    }
  }
  return field;
}

/// All that the methods take on the image and the level below, each where it can be.
std::vector<MethodStep> elastic_kernels() {
  using Kind = MethodStep::Kind;
  using enum ElasticField;
  return {{.kind = Kind::relax, .level = 0, .to = displacement},
          {.kind = Kind::relax, .level = 0, .to = correction},
          {.kind = Kind::relax, .level = 1, .to = correction},
          {.kind = Kind::relax_from_zero, .level = 1, .to = correction},
          {.kind = Kind::forces, .level = 0, .to = image, .from = direction},
          {.kind = Kind::restrict_residual, .level = 0, .to = load, .from = displacement},
          {.kind = Kind::restrict_residual, .level = 0, .to = load, .from = correction},
          {.kind = Kind::restrict_load, .level = 0, .to = load},
          {.kind = Kind::interpolate, .level = 0, .to = correction},
          {.kind = Kind::correct, .level = 0, .to = displacement},
          {.kind = Kind::advance, .level = 0, .to = load, .from = load, .direction = image, .factor = 0.0F}};
}

} // namespace

struct Kernels::Open {
  std::unique_ptr<Session> sites{};
  std::size_t loaded = site_kinds; ///< the kind of the level that `sites` has; site_kinds: none
  std::unique_ptr<ElasticSession> cells{};
  Scene scene{}; ///< of the elastic energy
  int coarsest = 0;
  std::optional<LawForces> tissues{}; ///< of the scene
  VectorField strained{};             ///< a displacement that turns no cell over
  VectorField force{};
};

Kernels::Kernels(const Backend& backend, SessionOptions session, bool elastic, Extent extent)
    : backend_(backend), session_(std::move(session)), elastic_(elastic), extent_(extent) {
  const std::size_t axes = extent.axes();
  if (!elastic) {
    for (std::size_t i = 0; i < site_kinds; ++i) {
      const auto kind = static_cast<SiteKind>(i);
      const Level level{.extent = extent};
      const auto cost = update_cost(thesis_energy, backend, kind, axes, level.steps.count(), sweeps_together);
      all_.push_back({.name = kind_names.at(i),
                      .sites = extent,
                      .cost = cost ? StepCost{cost->operations, cost->bytes} : StepCost{}});
    }
    return;
  }
  const auto half = [](int side) { return side > 1 ? (side + 2) / 2 : 1; };
  const Extent below{half(extent.width), half(extent.height), half(extent.depth)};
  steps_ = elastic_kernels();
  for (const MethodStep& step : steps_) {
    const bool has_load =
        step.from == ElasticField::correction && (step.kind == MethodStep::Kind::relax || step.restricts());
    all_.push_back({.name = fmt::format("{}{}", step.name(), has_load ? ", with load" : ""),
                    .level = step.level,
                    .sites = step.level == 0 ? extent : below,
                    .cost = step_cost(step, axes)});
  }
  all_.push_back({.name = "dot", .sites = extent, .cost = dot_cost(axes)});
  law_forces_ = all_.size();
  all_.push_back({.name = "forces of laws", .sites = extent});
  all_.push_back({.name = "set-up: hierarchy", .sites = extent, .is_on_host = true});
}

Kernels::~Kernels() = default;

void Kernels::close() {
  open_.reset();
}

void Kernels::prepare(std::size_t kernel) {
  if (!open_) {
    open_ = std::make_unique<Open>();
  }
  if (!elastic_) {
    if (!open_->sites) {
      open_->sites = backend_.open(session_);
    }
    if (open_->loaded != kernel) {
      open_->sites->load(level_of_kind(extent_, static_cast<SiteKind>(kernel)));
      open_->sites->write(any_field(extent_));
      open_->loaded = kernel;
    }
    return;
  }
  if (!open_->cells) {
    open_->scene = load_scene(
        extent_.axes() == 3 ? "cube" : "square",
        {.size = extent_, .law = "neo-hookean", .energy = &energy_near(ReferenceSolution::finite_elements)});
    open_->tissues.emplace(open_->scene.full, open_->scene.elastic);
    open_->strained = any_field(extent_, 0x1p-14F);
    open_->cells = backend_.open_elastic(session_);
    const std::vector<ElasticLevel> outline = outline_of(extent_, open_->scene.full.sides).levels;
    open_->coarsest = static_cast<int>(outline.size()) - 1;
    const Extent below = outline.at(1).grid.sites;
    open_->cells->load(ElasticBody{open_->scene.full, open_->scene.elastic});
    const VectorField field = any_field(extent_);
    for (std::size_t i = 0; i < elastic_fields; ++i) {
      open_->cells->write(0, static_cast<ElasticField>(i), field);
    }
    open_->cells->write(1, ElasticField::correction, any_field(below));
    open_->cells->write(1, ElasticField::load, any_field(below));
  }
}

std::optional<double> Kernels::device_seconds() {
  return elastic_ ? open_->cells->device_seconds() : open_->sites->device_seconds();
}

void Kernels::run(std::size_t kernel, int times) {
  if (!elastic_) {
    open_->sites->step(times);
    return;
  }
  for (int i = 0; i < times; ++i) {
    if (all_[kernel].is_on_host) {
      (void)make_elastic_hierarchy({open_->scene.full, open_->scene.elastic});
    } else if (kernel == law_forces_) {
      if (!open_->cells->law_forces(*open_->tissues, open_->strained, open_->force)) {
        (void)(*open_->tissues)(open_->strained, open_->force);
      }
    } else if (kernel < steps_.size()) {
      open_->cells->take(steps_[kernel]);
    } else {
      (void)open_->cells->dot(ElasticField::load, ElasticField::image);
    }
  }
  VectorField few;
  open_->cells->read(open_->coarsest, ElasticField::correction, few); // waits for what was begun
}

} // namespace hdmbench
