// Targets that are more certain in one direction than in another: from an image to the sites, and what they
// do there.

#include "harness/applications/gradient.hpp"
#include "harness/applications/spread.hpp"
#include "harness/judge/truths.hpp"
#include "harness/scene/scene.hpp"
#include "harness/scene/walls.hpp"
#include "harness/solve/methods/laws.hpp"
#include "harness/solve/methods/solver.hpp"
#include "kernels/data/elastic/springs.hpp"
#include "reference/finite_elements.hpp"
#include "reference/large_strains.hpp"
#include "test/files.hpp"
#include "test/scenes.hpp"
#include "test/sessions.hpp"

namespace hdmbench {
namespace {

using testing::HasSubstr;

using Matrix = std::array<std::array<double, 3>, 3>;

/// Columns are orthonormal: a turn about no axis of the pixels, of an image about the third.
Matrix turn_of(std::size_t axes) {
  const double c = std::cos(0.5);
  const double s = std::sin(0.5);
  const Matrix about_z{{{c, -s, 0.0}, {s, c, 0.0}, {0.0, 0.0, 1.0}}};
  const Matrix about_x{{{1.0, 0.0, 0.0}, {0.0, 0.8, -0.6}, {0.0, 0.6, 0.8}}};
  Matrix turn{};
  for (std::size_t row = 0; row < 3; ++row) {
    for (std::size_t column = 0; column < 3; ++column) {
      for (std::size_t i = 0; i < 3; ++i) {
        turn[row][column] += about_z[row][i] * (axes == 3 ? about_x[i][column] : i == column ? 1.0 : 0.0);
      }
    }
  }
  return turn;
}

class PrecisionImage : public ImageFiles, public testing::WithParamInterface<Extent> {
protected:
  [[nodiscard]] static Extent extent() { return GetParam(); }
  [[nodiscard]] static std::size_t axes() { return extent().axes(); }

  /// Values of so many components at a site; of all others `fill`.
  using Sites = std::map<std::size_t, std::vector<double>>;
  void write_values(const char* name, std::size_t components, double fill, const Sites& others,
                    const std::string& header = "") const {
    std::string values;
    for (std::size_t site = 0; site < extent().sites(); ++site) {
      const auto other = others.find(site);
      for (std::size_t i = 0; i < components; ++i) {
        values += fmt::format("{:.9g} ", other == others.end() ? fill : other->second.at(i));
      }
    }
    write_nrrd(name, "float", fmt::format("{} {}", components, extent().text(" ")), values,
               header.empty()
                   ? axes() == 3 ? "kinds: list domain domain domain\n" : "kinds: list domain domain\n"
                   : header);
  }
  void write_labels(const std::string& header = "") const {
    std::string values;
    for (std::size_t site = 0; site < extent().sites(); ++site) {
      values += site % 7 < 3 ? "1 " : "2 ";
    }
    write_nrrd("labels.nrrd", "short", extent().text(" "), values, header);
  }

  [[nodiscard]] Scene load(const std::string& image, const std::string& more = "",
                           const SceneOptions& options = {}) const {
    const auto file = write(
        "scene.toml", fmt::format("energy = \"elastic\"\n[[tissue]]\nlabel = 1\nmodulus = 3.0\n[[tissue]]\n"
                                  "label = 2\nmodulus = 30.0\n[[condition]]\nwhere = \"left\"\ndx = 0\n"
                                  "dy = 0\n{}{}[image]\nlabels = \"labels.nrrd\"\n{}",
                                  axes() == 3 ? "dz = 0\n" : "", more, image));
    return load_scene(file.string(), options);
  }

  [[nodiscard]] static std::size_t site(int x, int y) { return extent().index(x, y, axes() == 3 ? 2 : 0); }
  /// The upper triangle of what has these eigenvalues along the columns of `turn`.
  [[nodiscard]] static std::vector<double> matrix_of(const std::array<double, 3>& eigenvalues,
                                                     const Matrix& turn, std::size_t dimensions) {
    std::vector<double> entries;
    for (std::size_t row = 0; row < dimensions; ++row) {
      for (std::size_t column = row; column < dimensions; ++column) {
        double sum = 0.0;
        for (std::size_t i = 0; i < dimensions; ++i) {
          sum += turn[row][i] * eigenvalues[i] * turn[column][i];
        }
        entries.push_back(sum);
      }
    }
    return entries;
  }
  [[nodiscard]] static std::size_t entries() { return axes() * (axes() + 1) / 2; }
  static constexpr Matrix no_turn{{{1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}}};
  static constexpr const char* images = "target = \"target.nrrd\"\nprecision = \"precision.nrrd\"\n";
};

VectorField solved(const Scene& scene) {
  return test::converged(scene.full, scene.elastic);
}

double largest_difference(const VectorField& one, const VectorField& other) {
  double largest = 0.0;
  for (std::size_t axis = 0; axis < one.extent.axes(); ++axis) {
    for (std::size_t at = 0; at < one.extent.sites(); ++at) {
      largest = std::max(largest, std::abs(double{one[axis][at]} - double{other[axis][at]}));
    }
  }
  return largest;
}

/// Along the pixels it is what deviations of the components say.
TEST_P(PrecisionImage, OfADiagonalIsDeviations) {
  write_labels();
  write_values("target.nrrd", axes(), 0.0, {{site(3, 3), {1.0, -0.5, 0.25}}, {site(6, 4), {-1.0, 0.5, 0.5}}});
  const double none = std::numeric_limits<double>::infinity();
  write_values("deviation.nrrd", axes(), none,
               {{site(3, 3), {0.5, 2.0, none}}, {site(6, 4), {none, 0.3, 1.0}}});
  write_values("precision.nrrd", entries(), 0.0,
               {{site(3, 3), matrix_of({4.0, 0.25, 0.0}, no_turn, axes())},
                {site(6, 4), matrix_of({0.0, 1.0 / 0.09, 1.0}, no_turn, axes())}});
  const Scene expected = load("target = \"target.nrrd\"\ndeviation = \"deviation.nrrd\"\n");
  const Scene found = load(images);
  EXPECT_LT(largest_difference(solved(found), solved(expected)), 2e-5);
  EXPECT_GT(largest_difference(solved(found), VectorField(extent())), 0.1);
  ASSERT_TRUE(found.observed);
  EXPECT_EQ(found.observed->given, 2U);
  EXPECT_EQ(found.observed->acting, 2U);
}

/// The shift of an edge is known across it: what a target says along it does not matter.
TEST_P(PrecisionImage, SaysNothingWhereItsEigenvalueIsNone) {
  write_labels();
  const Matrix turn = turn_of(axes());
  write_values("precision.nrrd", entries(), 0.0, {{site(4, 3), matrix_of({9.0, 0.0, 0.0}, turn, axes())}});
  std::vector<VectorField> found;
  for (const double along : {0.0, 5.0}) {
    std::vector<double> target;
    for (std::size_t axis = 0; axis < axes(); ++axis) {
      target.push_back(1.5 * turn[axis][0] + along * turn[axis][1]);
    }
    write_values("target.nrrd", axes(), 0.0, {{site(4, 3), target}});
    found.push_back(solved(load(images)));
  }
  EXPECT_LT(largest_difference(found[0], found[1]), 1e-4);
  double across = 0.0;
  for (std::size_t axis = 0; axis < axes(); ++axis) {
    across += turn[axis][0] * double{found[0][axis][site(4, 3)]};
  }
  EXPECT_GT(across, 0.9);
  EXPECT_LT(across, 1.5);
}

/// An image that lies obliquely, with targets in millimetres, is the same observation.
TEST_P(PrecisionImage, TurnsWithTheSpace) {
  const Matrix turn = turn_of(axes());
  constexpr double side = 2.5; // mm
  const auto header = [&](bool is_vector) {
    std::string directions;
    for (std::size_t axis = 0; axis < axes(); ++axis) {
      std::vector<double> direction;
      for (std::size_t i = 0; i < axes(); ++i) {
        direction.push_back(side * turn[i][axis]);
      }
      directions += fmt::format(" ({:.12g})", fmt::join(direction, ","));
    }
    return fmt::format("space dimension: {}\nspace directions:{}{}\n{}", axes(), is_vector ? " none" : "",
                       directions,
                       !is_vector    ? ""
                       : axes() == 3 ? "kinds: list domain domain domain\n"
                                     : "kinds: list domain domain\n");
  };
  write_labels(header(false));
  const std::array<double, 3> eigenvalues{9.0, 0.5, 0.0}; // along the pixels
  const std::array<double, 3> target{1.0, -0.5, 0.75};    // pixels
  std::vector<double> physical;
  for (std::size_t i = 0; i < axes(); ++i) {
    double sum = 0.0;
    for (std::size_t axis = 0; axis < axes(); ++axis) {
      sum += turn[i][axis] * target[axis] * side;
    }
    physical.push_back(sum);
  }
  const std::size_t at = site(4, 3);
  write_values("target.nrrd", axes(), 0.0, {{at, {target.begin(), target.end()}}}, header(true));
  write_values("precision.nrrd", entries(), 0.0, {{at, matrix_of(eigenvalues, no_turn, axes())}},
               header(true));
  const Scene of_pixels = load(images);
  write_values("target.nrrd", axes(), 0.0, {{at, physical}}, header(true));
  std::vector<double> turned = matrix_of(eigenvalues, turn, axes());
  std::ranges::for_each(turned, [&](double& entry) { entry /= side * side; });
  write_values("precision.nrrd", entries(), 0.0, {{at, turned}}, header(true));
  const Scene of_space = load(images + std::string("target_unit = \"mm\"\n"));
  for (std::size_t entry = 0; entry < entries(); ++entry) {
    EXPECT_NEAR(of_space.full.springs[entry][at], of_pixels.full.springs[entry][at], 1e-5) << entry;
  }
  EXPECT_LT(largest_difference(solved(of_space), solved(of_pixels)), 2e-5);
}

/// With a condition beside it a site has both: their matrices and their pulls add up.
TEST_P(PrecisionImage, ActsBesideConditions) {
  write_labels();
  const std::string soft = "[[condition]]\nwhere = \"labels\"\nlabels = [1]\ndx = 0.5\ndeviation = 2.0\n";
  const Matrix turn = turn_of(axes());
  const std::size_t at = site(2, 2); // of either label
  const std::array<double, 3> target{1.5, -1.0, 0.25};
  write_values("target.nrrd", axes(), 0.0, {{at, {target.begin(), target.end()}}});
  const std::vector<double> matrix = matrix_of({4.0, 0.5, 0.0}, turn, axes());
  write_values("precision.nrrd", entries(), 0.0, {{at, matrix}});
  const Scene scene = load(images, soft);
  const Level& level = scene.full;
  const double weight = weight_of_confidence(level.confidence[0][at]);
  const double of_label = level.modulus.values[at] < 10.0F ? 0.25 : 0.0;
  EXPECT_NEAR(weight, of_label, 1e-6);
  for (std::size_t row = 0; row < axes(); ++row) { // of what is at rest: (P + C) rest = P target + C 0.5
    double pull = row == 0 ? weight * (0.5 - double{level.target[0][at]}) : 0.0;
    for (std::size_t column = 0; column < axes(); ++column) {
      pull +=
          matrix[symmetric_entry(axes(), row, column)] * (target[column] - double{level.target[column][at]});
    }
    EXPECT_NEAR(pull, 0.0, 2e-5) << "row " << row;
  }
  const Scene held = load(images, "[[condition]]\nwhere = \"border\"\noutward = 0.0\n[[condition]]\nwhere = "
                                  "\"labels\"\nlabels = [1, 2]\ndx = 0.125\n");
  for (std::size_t row = 1; row < axes(); ++row) { // the others are pulled as is likely beside that
    double pull = 0.0;
    for (std::size_t column = 0; column < axes(); ++column) {
      pull += matrix[symmetric_entry(axes(), row, column)] *
              (target[column] - double{held.full.target[column][at]});
    }
    EXPECT_NEAR(pull, 0.0, 2e-5) << "row " << row;
  }
  const VectorField found = solved(held);
  EXPECT_EQ(found[0][at], 0.125F) << "what is prescribed stays";
  EXPECT_GT(found[1][at] / held.full.target[1][at], 0.05F);
}

/// Along a wall what is observed pulls, and a wall gives way to nothing that is observed across it.
TEST_P(PrecisionImage, ActsBesideWalls) {
  std::string labels;
  for_each_site(extent(),
                [&](int /*x*/, int y, int /*z*/) { labels += y + 2 < extent().height ? "1 " : "2 "; });
  write_nrrd("labels.nrrd", "short", extent().text(" "), labels, "");
  const std::string slides = "[[condition]]\nwhere = \"labels\"\nlabels = [2]\nslide = true\n";
  const std::size_t beside = site(6, extent().height - 3);
  const std::size_t inside = site(5, 2);
  const std::vector<double> target{0.6, -0.4, 0.25};
  write_values("target.nrrd", axes(), 0.0, {{beside, target}, {inside, target}});
  const double none = std::numeric_limits<double>::infinity();
  write_values("deviation.nrrd", axes(), none, {{beside, {0.5, 0.4, 1.0}}, {inside, {none, 0.3, 1.0}}});
  write_values("precision.nrrd", entries(), 0.0,
               {{beside, matrix_of({4.0, 6.25, 1.0}, no_turn, axes())},
                {inside, matrix_of({0.0, 1.0 / 0.09, 1.0}, no_turn, axes())}});
  const Scene by_components = load("target = \"target.nrrd\"\ndeviation = \"deviation.nrrd\"\n", slides);
  const Scene by_direction = load(images, slides);
  ASSERT_TRUE(is_on_wall(by_direction.full, beside));
  ASSERT_FALSE(is_on_wall(by_direction.full, inside));
  EXPECT_LT(largest_difference(solved(by_direction), solved(by_components)), 2e-5);

  const Matrix turn = turn_of(axes());
  const std::vector<double> matrix = matrix_of({9.0, 0.5, 0.1}, turn, axes());
  write_values("precision.nrrd", entries(), 0.0, {{beside, matrix}, {inside, matrix}});
  Scene oblique = load(images, slides);
  const Level& level = oblique.full;
  for (std::size_t row = 0; row < axes(); ++row) { // (P + wall) rest = P target
    double pull = row == 1 ? -double{stiffness_of_walls} * double{level.target[1][beside]} : 0.0;
    for (std::size_t column = 0; column < axes(); ++column) {
      pull += matrix[symmetric_entry(axes(), row, column)] *
              (target[column] - double{level.target[column][beside]});
    }
    EXPECT_NEAR(pull, 0.0, 2e-4) << "row " << row;
  }
  const VectorField found = solved(oblique);
  EXPECT_GT(std::abs(found[0][beside]), 0.1F);
  EXPECT_LT(std::abs(found[1][beside]), 0.05F) << "through the wall";
  EXPECT_GT(walls_under(level, found).sites, 0U);
  EXPECT_LT(rmsd(ReferenceField(found),
                 solve_finite_elements(elastic_problem(level), ElementRule::of(extent(), oblique.elastic))),
            1e-5);
  const Scene neo_hookean = load(images, slides, {.law = "neo-hookean"});
  const auto session = test::find("openmp").open_elastic({.device = {}, .threads = 1});
  const Solution by_law =
      solve_by_laws(neo_hookean.full, neo_hookean.elastic, *session, 1e-4, [](const LawStep& /*step*/) {});
  const std::vector<float>& parameter = neo_hookean.full.law_parameter.values;
  const ReferenceField truth =
      solve_large_strains(elastic_problem(neo_hookean.full), {parameter.begin(), parameter.end()}, 0.3, 2);
  EXPECT_EQ(by_law.failure + doubt_about(by_law), "");
  EXPECT_LT(rmsd(ReferenceField(by_law.displacement), truth, test::sites_of_tissue(neo_hookean.full)), 1e-4);
}

/// A draw of what is observed across an edge leaves the way along it as uncertain as it was.
TEST_P(PrecisionImage, MakesTheFieldCertainInItsDirection) {
  write_labels();
  const std::size_t at = site(6, 4);
  write_values("target.nrrd", axes(), 0.0, {});
  const auto deviation_with = [&](double eigenvalue) {
    write_values("precision.nrrd", entries(), 0.0,
                 {{at, matrix_of({0.0, eigenvalue, 0.0}, no_turn, axes())},
                  {site(1, 1), matrix_of({1e-6, 0.0, 0.0}, no_turn, axes())}});
    const Scene scene = load(images);
    Solver solver(test::scalar(), {});
    const Spread spread = spread_of(scene, solver.solve(scene, test::silent()).displacement,
                                    {.draws = 60, .seed = 7}, solver, test::silent());
    return std::array{spread.deviation[0][at], spread.deviation[1][at]};
  };
  const auto before = deviation_with(1e-6);
  const auto after = deviation_with(1e4); // a deviation of a hundredth of a pixel
  fmt::print("{}: x {:.3f} -> {:.3f} px, y {:.3f} -> {:.4f} px\n", extent().text(), before[0], after[0],
             before[1], after[1]);
  EXPECT_NEAR(after[1], 0.01, 0.004);
  EXPECT_GT(before[1], 0.1);
  EXPECT_GT(after[0], 0.5F * before[0]);
}

TEST_P(PrecisionImage, IsRefusedWhereItCannotBe) {
  write_labels();
  write_values("target.nrrd", axes(), 0.0, {});
  write_values("precision.nrrd", entries(), 0.0, {});
  EXPECT_NO_THROW((void)load(images));
  expect_refusal([&] { (void)load(std::string(images) + "confidence = \"target.nrrd\"\n"); },
                 "[image] precision cannot stand beside confidence");
  expect_refusal([&] { (void)load("precision = \"precision.nrrd\"\n"); },
                 "[image] target and confidence (or");
  expect_refusal(
      [&] {
        (void)load(images, "", {.size = axes() == 3 ? Extent{18, 14, 12} : Extent{18, 16}});
      },
      "[image] precision takes the file's own pixels");
  const auto file =
      write("thesis.toml", fmt::format("[[tissue]]\nlabel = 1\nmodulus = 3.0\n[[tissue]]\n"
                                       "label = 2\nmodulus = 30.0\n[image]\nlabels = \"labels.nrrd\"\n{}",
                                       images));
  expect_refusal([&] { (void)load_scene(file.string()); }, "precision has no effect in this scene");
  for (const std::array<double, 3>& eigenvalues :
       {std::array{1.0, -0.1, 0.0}, std::array{0.0, 0.0, -1.0}, std::array{std::nan(""), 0.0, 0.0}}) {
    if (axes() == 2 && eigenvalues[2] < 0.0) {
      continue;
    }
    write_values("precision.nrrd", entries(), 0.0,
                 {{site(4, 3), matrix_of(eigenvalues, turn_of(axes()), axes())}});
    expect_refusal([&] { (void)load(images); }, "its value at x = 4, y = 3");
  }
  write_values("precision.nrrd", axes(), 0.0, {});
  if (axes() == 3) {
    expect_refusal([&] { (void)load(images); }, "it has 3 components per voxel, 6 are expected");
  } else {
    expect_refusal([&] { (void)load(images); }, "it has 2 components per pixel, 3 or 6 are expected");
  }
}

/// The gradient is of components alone, and says so.
TEST_P(PrecisionImage, HasNoGradient) {
  write_labels();
  write_values("target.nrrd", axes(), 0.0, {});
  write_values("precision.nrrd", entries(), 0.0, {{site(4, 3), matrix_of({1.0, 0.0, 0.0}, no_turn, axes())}});
  EXPECT_THAT(why_no_gradient(load(images)), HasSubstr("has a precision"));
}

INSTANTIATE_TEST_SUITE_P(Of, PrecisionImage, testing::Values(Extent{9, 8}, Extent{9, 7, 6}));

} // namespace
} // namespace hdmbench
