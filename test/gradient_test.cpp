// Derivatives of a number of the displacement, against differences of finite elements in double.

#include "harness/applications/gradient.hpp"
#include "harness/scene/method.hpp"
#include "kernels/data/elastic/springs.hpp"
#include "reference/finite_elements.hpp"
#include "test/files.hpp"
#include "test/scenes.hpp"
#include "test/sessions.hpp"

namespace hdmbench {
namespace {

using test::elastic_level;
using test::Held;
using test::Tissue;
using testing::HasSubstr;

Scene scene_of(Level level, double poisson) {
  Scene scene;
  scene.name = "level";
  scene.full = std::move(level);
  scene.energy = &find_energy("elastic");
  scene.elastic.poisson = poisson;
  return scene;
}

SceneGradient gradient_on(const Backend& backend, const Scene& scene, const VectorField& displacement,
                          const VectorField& by_displacement) {
  Solver solver(backend, {});
  return gradient_of(scene, displacement, by_displacement, solver, test::silent());
}

/// J is the sum of all components, each so many times.
double number_of(const VectorField& weights, const ReferenceField& displacement) {
  double sum = 0.0;
  for (std::size_t axis = 0; axis < weights.extent.axes(); ++axis) {
    for (std::size_t site = 0; site < weights.extent.sites(); ++site) {
      sum += double{weights[axis][site]} * displacement[axis][site];
    }
  }
  return sum;
}

/// A level with its finite elements, and J of them.
class Differences {
public:
  Differences(const Level& level, double poisson, const VectorField& weights)
      : problem_(elastic_problem(level)), rule_(ElementRule::of(level.extent, poisson)), weights_(weights),
        displacement_(solve_finite_elements(problem_, rule_)), number_(number_of(weights, displacement_)) {}

  [[nodiscard]] const ReferenceField& displacement() const { return displacement_; }
  /// By the modulus of a site, by which its springs go, too.
  [[nodiscard]] double by_modulus(std::size_t site) const {
    const double step = 1e-4 * problem_.modulus[site];
    const auto moved = [&](double sign) {
      ElasticProblem other = problem_;
      other.modulus[site] += sign * step;
      for (std::vector<double>& spring : other.spring.planes) {
        if (!spring.empty()) {
          spring[site] *= other.modulus[site] / problem_.modulus[site];
        }
      }
      return number_of(weights_, solve_finite_elements(other, rule_));
    };
    return (moved(1.0) - moved(-1.0)) / (2.0 * step);
  }
  /// J is linear in targets and forces.
  [[nodiscard]] double by_target(std::size_t axis, std::size_t site) const {
    ElasticProblem other = problem_;
    other.prescribed[axis][site] += 1.0;
    return number_of(weights_, solve_finite_elements(other, rule_)) - number_;
  }
  [[nodiscard]] double by_force(std::size_t axis, std::size_t site) const {
    ElasticProblem other = problem_;
    other.force[axis][site] += 1.0;
    return number_of(weights_, solve_finite_elements(other, rule_)) - number_;
  }

private:
  ElasticProblem problem_;
  ElementRule rule_;
  const VectorField& weights_;
  ReferenceField displacement_;
  double number_;
};

double largest(const std::vector<float>& values) {
  double most = 0.0;
  for (const float value : values) {
    most = std::max(most, std::abs(double{value}));
  }
  return most;
}

/// What one gradient differs by from differences at some sites, over its own largest number.
double worst_difference(const Level& level, double poisson, const VectorField& weights) {
  const Differences differences(level, poisson, weights);
  const SceneGradient gradient = gradient_on(test::find("openmp"), scene_of(level, poisson),
                                             differences.displacement().to_float(), weights);
  EXPECT_TRUE(gradient.converged);
  const double of_moduli = largest(gradient.modulus.values);
  const double of_forces = largest_component(gradient.force);
  const double of_targets = largest_component(gradient.target);
  EXPECT_GT(of_moduli, 0.0);
  test::Uniform uniform(3);
  double worst = 0.0;
  const auto compare = [&](double found, double expected, double most) {
    worst = std::max(worst, std::abs(found - expected) / most);
  };
  const auto random_site = [&] {
    return static_cast<std::size_t>(uniform() * static_cast<double>(level.extent.sites()));
  };
  const auto spring = std::ranges::find_if(level.confidence[0], is_spring);
  const auto first = spring == level.confidence[0].end()
                         ? random_site()
                         : static_cast<std::size_t>(spring - level.confidence[0].begin());
  for (const std::size_t site : {first, random_site()}) {
    compare(double{gradient.modulus.values[site]}, differences.by_modulus(site), of_moduli);
    for (std::size_t axis = 0; axis < level.extent.axes(); ++axis) {
      compare(double{gradient.force[axis][site]}, differences.by_force(axis, site), of_forces);
    }
  }
  int targets = 0;
  while (targets < 3) {
    const std::size_t site = random_site();
    const std::size_t axis = site % level.extent.axes();
    if (level.confidence[axis][site] > 0.0F) {
      compare(double{gradient.target[axis][site]}, differences.by_target(axis, site), of_targets);
      ++targets;
    }
  }
  return worst;
}

TEST(Gradient, IsThatOfFiniteElements) {
  double worst = 0.0;
  for (const auto& [extent, sides] : {std::pair{Extent{25, 18}, std::array{1.0, 1.0, 1.0}},
                                      {Extent{13, 21}, {1.0, 2.5, 1.0}},
                                      {Extent{7, 8, 9}, {1.0, 1.0, 1.0}},
                                      {Extent{8, 9, 7}, {1.5, 1.0, 3.0}}}) {
    for (const Held held : {Held::border, Held::scattered, Held::springs}) {
      for (const double contrast : {10.0, 1000.0}) {
        Level level = elastic_level(extent, Tissue::inclusion, held, contrast, 8);
        level.sides = sides;
        level.force = test::random_field(extent, 77);
        const VectorField weights = test::random_field(extent, 5);
        for (const double poisson : {0.0, 0.4}) {
          const double found = worst_difference(level, poisson, weights);
          worst = std::max(worst, found);
          EXPECT_LT(found, 1e-4) << extent.text() << ", held " << static_cast<int>(held) << ", contrast "
                                 << contrast << ", Poisson's ratio " << poisson;
        }
      }
    }
  }
  fmt::print("worst difference of 48 scenes, of the largest derivative: {:.2g}\n", worst);
}

TEST(Gradient, HasTheSameBitsOnEveryBackend) {
  Level level = elastic_level({19, 22}, Tissue::inclusion, Held::springs, 100.0, 8);
  const Scene scene = scene_of(level, 0.3);
  const VectorField displacement = test::random_field(level.extent, 4);
  const VectorField weights = test::random_field(level.extent, 5);
  const SceneGradient expected = gradient_on(test::scalar(), scene, displacement, weights);
  for (const Backend* const backend : test::present_backends()) {
    const SceneGradient found = gradient_on(*backend, scene, displacement, weights);
    EXPECT_EQ(found.modulus.values, expected.modulus.values) << backend->name();
    EXPECT_EQ(found.target.planes, expected.target.planes) << backend->name();
    EXPECT_EQ(found.force.planes, expected.force.planes) << backend->name();
  }
}

/// A number that is very small or large, or 0, of very stiff or soft tissue.
TEST(Gradient, GoesByTheScaleOfTheNumber) {
  Level level = elastic_level({15, 12}, Tissue::inclusion, Held::border, 10.0, 8);
  const Scene scene = scene_of(level, 0.3);
  const VectorField displacement = test::random_field(level.extent, 4);
  VectorField weights = test::random_field(level.extent, 5);
  const SceneGradient expected = gradient_on(test::scalar(), scene, displacement, weights);
  for (const float power : {0x1p-60F, 0x1p40F}) {
    VectorField scaled = weights;
    for (std::vector<float>& component : scaled.planes) {
      std::ranges::for_each(component, [power](float& value) { value *= power; });
    }
    const SceneGradient found = gradient_on(test::scalar(), scene, displacement, scaled);
    EXPECT_EQ(found.modulus.values[50] / power, expected.modulus.values[50]);
    EXPECT_EQ(found.force[0][50] / power, expected.force[0][50]);
  }
  const SceneGradient none = gradient_on(test::scalar(), scene, displacement, VectorField(level.extent));
  EXPECT_EQ(largest(none.modulus.values), 0.0);
  for (const float power : {0x1p-80F, 0x1p80F}) { // beyond what float holds products of
    Level scaled = level;
    std::ranges::for_each(scaled.modulus.values, [power](float& modulus) { modulus *= power; });
    set_inverse_modulus(scaled);
    const SceneGradient found = gradient_on(test::scalar(), scene_of(scaled, 0.3), displacement, weights);
    EXPECT_EQ(found.modulus.values[50] * power, expected.modulus.values[50]);
    EXPECT_EQ(found.target[0][3], expected.target[0][3]);
    EXPECT_EQ(found.force[0][50] * power, expected.force[0][50]);
  }
}

TEST(Gradient, IsRefusedWhereThereIsNone) {
  const Level level = elastic_level({9, 8, 7}, Tissue::inclusion, Held::border, 10.0, 8);
  const VectorField field = test::random_field(level.extent, 4);
  const auto refusal = [&](const Scene& scene, const VectorField& weights) -> std::string {
    try {
      (void)gradient_on(test::scalar(), scene, field, weights);
      return "";
    } catch (const InputError& error) {
      return error.what();
    }
  };
  Scene thesis = scene_of(level, 0.3);
  thesis.energy = &usual_energy();
  EXPECT_THAT(refusal(thesis, field), HasSubstr("gradients are those of the elastic energy"));
  Scene selective = scene_of(level, 0.3);
  selective.elastic.integration = Integration::selective_reduced;
  EXPECT_THAT(refusal(selective, field), HasSubstr("integrated in full"));
  Scene law = scene_of(level, 0.3);
  law.full.law_parameter = ScalarField(level.extent, 0.0F);
  EXPECT_THAT(refusal(law, field), HasSubstr("law of large strains"));
  Scene walls = scene_of(level, 0.3);
  walls.full.has_walls = true;
  walls.full.walls.assign(6, std::vector<float>(level.extent.sites(), 1.0F));
  EXPECT_THAT(refusal(walls, field), HasSubstr("walls to slide along"));
  VectorField broken = field;
  broken[1][7] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THAT(refusal(scene_of(level, 0.3), broken), HasSubstr("the derivative by the displacement"));
}

} // namespace
} // namespace hdmbench
