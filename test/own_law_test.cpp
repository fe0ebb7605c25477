// A law of tissue that the library knows nothing of: one file of text and one line in the registry
// (test/own_law). Scenes name it, every backend has the same bits, and the answer is that of the closed form.

#define HDMBENCH_LAW saint_venant
#define HDMBENCH_LAW_TEXT "test/own_law/saint_venant.inc"
#include "kernels/specification/laws/laws.hpp"

#include "harness/check/verify.hpp"
#include "harness/judge/truths.hpp"
#include "harness/scene/laws.hpp"
#include "harness/scene/sites.hpp"
#include "harness/solve/methods/laws.hpp"
#include "test/files.hpp"
#include "test/sessions.hpp"

#include <Eigen/Core>
#include <gmock/gmock.h>

#include <array>
#include <cmath>

namespace hdmbench {
namespace {

using testing::HasSubstr;

/// A block that is pulled along x by a quarter; its sides move as they like.
constexpr const char* pulled_block = R"(
energy = "elastic"
size = [17, 9{}]
poisson = 0.3
law = "saint-venant"
volume_hardening = {}
[[tissue]]
label = 1
modulus = 2.0
{}
[[shape]]
kind = "everything"
label = 1
[[condition]]
where = "left"
dx = 0.0
[[condition]]
where = "right"
dx = 4.0
[[condition]]
where = "top"
dy = 0.0
)";

class OwnLaw : public testing::TestWithParam<bool> {
protected:
  [[nodiscard]] static bool is_volume() { return GetParam(); }

  [[nodiscard]] Scene block(double hardening, std::string_view of_tissue = "",
                            const SceneOptions& options = {}) const {
    std::string text =
        fmt::format(fmt::runtime(pulled_block), is_volume() ? ", 7" : "", hardening, of_tissue);
    text += is_volume() ? "[[condition]]\nwhere = \"front\"\ndz = 0.0\n" : "";
    return load_scene(folder_.write("block.toml", text), options);
  }

private:
  test::TemporaryFolder folder_;
};
INSTANTIATE_TEST_SUITE_P(Block, OwnLaw, testing::Values(false, true),
                         [](const auto& information) { return information.param ? "Volume" : "Image"; });

Solution solved(const Scene& scene, const Backend& backend) {
  const auto session = backend.open_elastic({});
  return solve_by_laws(scene.full, scene.elastic, *session, 1e-4, [](const LawStep& /*step*/) {});
}

/// By how much a length across shrinks where nothing pulls there: the stretch at which that stress is 0.
double shortening(bool is_volume, double poisson, double hardening, double stretch) {
  const double mu = 0.5 / (1.0 + poisson);
  const double lame =
      is_volume ? poisson / ((1.0 + poisson) * (1.0 - 2.0 * poisson)) : poisson / (1.0 - poisson * poisson);
  const double along = 0.5 * (stretch * stretch - 1.0);
  double low = 0.5;
  double high = 1.0;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    const double across = 0.5 * (middle * middle - 1.0);
    const double trace = along + (is_volume ? 2.0 : 1.0) * across;
    const double stress = lame * trace * (1.0 + hardening * trace * trace) + 2.0 * mu * across;
    (stress > 0.0 ? high : low) = middle;
  }
  return 1.0 - low;
}

TEST_P(OwnLaw, ABlockThatIsPulledShrinksAsTheClosedFormSays) {
  std::vector<double> all;
  for (const double hardening : {0.5, 20.0}) {
    const Scene scene = block(hardening);
    EXPECT_EQ(law_name(scene.full), "saint-venant");
    const Solution found = solved(scene, test::find("openmp"));
    EXPECT_EQ(found.failure, "");
    const double expected = shortening(is_volume(), 0.3, hardening, 1.25);
    double worst = 0.0;
    for_each_site(scene.extent(), [&](int x, int y, int z) {
      const std::size_t site = scene.extent().index(x, y, z);
      worst = std::max(worst, std::abs(found.displacement[0][site] - 0.25 * x));
      worst = std::max(worst, std::abs(found.displacement[1][site] + expected * y));
    });
    EXPECT_LT(worst, 2e-3) << expected;
    all.push_back(expected);
  }
  EXPECT_GT(std::abs(all[0] - all[1]), 0.005); // the parameter matters
}

TEST_P(OwnLaw, EveryBackendHasTheSameBits) {
  const Scene scene = block(3.0);
  const Solution expected = solved(scene, test::scalar());
  std::vector<const Backend*> others;
  for (const Backend* const backend : test::present_backends()) {
    if (backend->has_elastic() && backend != &test::scalar()) {
      EXPECT_EQ(expected.displacement.planes, solved(scene, *backend).displacement.planes) << backend->name();
      others.push_back(backend);
    }
  }
  for (const Comparison& one :
       verify(scene, test::scalar(), others, {.session = {}, .iteration_limit = {}}, test::silent())) {
    EXPECT_EQ(one.verdict, Verdict::agree) << one.backend << ", " << name_of(one.mode);
  }
}

/// --energy auto takes neo-Hookean tissue only where the scene says nothing.
TEST_P(OwnLaw, AStatedLawStandsWhereOneIsTakenAsNeeded) {
  for (const char* const of_tissue : {"", "law = \"saint-venant\"\nvolume_hardening = 3.0"}) {
    const Scene scene = block(3.0, of_tissue, {.law = std::string(law_as_needed)});
    EXPECT_EQ(law_name(scene.full), "saint-venant");
    EXPECT_THAT(scene.full.law_parameter.values, testing::Each(3.0F));
  }
  const Scene stiffening = block(5.0, "law = \"stiffening\"\nstiffening = 7.0", {.law = "neo-hookean"});
  EXPECT_THAT(stiffening.full.law_parameter.values, testing::Each(7.0F));
}

/// Linear tissue may lie beside it; another text may not.
TEST_P(OwnLaw, StandsBesideLinearTissueAlone) {
  const Scene mixed = block(3.0, "law = \"linear\"");
  EXPECT_THAT(mixed.full.law_parameter.values, testing::Each(testing::Lt(0.0F)));
  expect_refusal([&] { (void)block(3.0, "law = \"neo-hookean\""); },
                 "of label 1 has a law of another text than others have");
  expect_refusal([&] { (void)block(-1.0); }, "volume_hardening is -1, it must be positive");
  expect_refusal([&] { (void)find_large_strains(block(3.0)); },
                 "there is no reference solution by the law \"saint-venant\"");
}

/// W of the header of saint_venant.inc.
double stored_energy(const Eigen::Matrix3d& h, double mu, double lame, double a) {
  const Eigen::Matrix3d strain = 0.5 * (h + h.transpose() + h.transpose() * h);
  const double square = strain.trace() * strain.trace();
  return mu * strain.squaredNorm() + 0.5 * lame * square * (1.0 + 0.5 * a * square);
}

TEST(OwnLawText, AStressIsTheSlopeOfTheEnergy) {
  const Eigen::Matrix3d h{{0.3, 0.2, -0.1}, {-0.25, -0.3, 0.15}, {0.1, 0.05, 0.25}};
  const auto p = laws::saint_venant::Laws<double>::stress_of(
      {1.3, 2.1, 4.0}, {h(0, 0), h(0, 1), h(0, 2), h(1, 0), h(1, 1), h(1, 2), h(2, 0), h(2, 1), h(2, 2)});
  const std::array<double, 9> stress{p.xx, p.xy, p.xz, p.yx, p.yy, p.yz, p.zx, p.zy, p.zz};
  for (std::size_t entry = 0; entry < 9; ++entry) {
    constexpr double step = 1e-6;
    Eigen::Matrix3d more = h;
    Eigen::Matrix3d less = h;
    more(static_cast<int>(entry / 3), static_cast<int>(entry % 3)) += step;
    less(static_cast<int>(entry / 3), static_cast<int>(entry % 3)) -= step;
    const double slope =
        (stored_energy(more, 1.3, 2.1, 4.0) - stored_energy(less, 1.3, 2.1, 4.0)) / (2.0 * step);
    EXPECT_NEAR(stress[entry], slope, 1e-8);
  }
}

} // namespace
} // namespace hdmbench
