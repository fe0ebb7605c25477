// A user's own scene: pixels, conditions and confidences from image files.

#include "harness/scene/scene.hpp"
#include "test/files.hpp"

namespace hdmbench {
namespace {

constexpr std::string_view tissues = R"([[tissue]]
label = 0
modulus = 10.0
gray = 5
[[tissue]]
label = 7
modulus = 30.0
gray = 50
)";

constexpr std::string_view vector_kind = "kinds: vector domain domain\n";

/// A 3 x 2 label image and what a scene may have beside it.
class ImageScene : public ImageFiles {
protected:
  void SetUp() override {
    ImageFiles::SetUp();
    if (!IsSkipped()) {
      write_nrrd("labels.nrrd", "short", "3 2", "0 7 7 0 0 7", "spacings: 0.5 0.5\n");
      write_nrrd("modulus.nrrd", "float", "3 2", "1 2 3 4 5 6.5");
      write_nrrd("target.nrrd", "float", "2 3 2", "1 2 3 4 5 6 7 8 9 10 11 12", vector_kind);
      write_nrrd("confidence.nrrd", "float", "2 3 2", "0 1 0.5 0 0 0 0 0 0 0 1 0.25", vector_kind);
    }
  }

  Scene load(std::string_view text, const SceneOptions& options = {}) {
    return load_scene(write("scene.toml", text).string(), options);
  }

  void expect_refused(std::string_view text, std::string_view part) {
    expect_refusal([&] { (void)load(text); }, part);
  }
};

std::string with_image(std::string_view lines) {
  return fmt::format("{}[image]\n{}\n", tissues, lines);
}

TEST_F(ImageScene, LabelsBecomeModuli) {
  const Scene scene = load(with_image("labels = \"labels.nrrd\""));
  EXPECT_EQ(scene.extent(), (Extent{3, 2}));
  EXPECT_EQ(scene.spacing, 0.5);
  EXPECT_EQ(scene.full.modulus.values, (std::vector<float>{10, 30, 30, 10, 10, 30}));
  EXPECT_EQ(scene.full.inverse_modulus.values[1], 1.0F / 30.0F);
  EXPECT_EQ(scene.picture.values, (std::vector<float>{5, 50, 50, 5, 5, 50}));
}

TEST_F(ImageScene, ModuliTargetsAndConfidencesFromImages) {
  const Scene scene = load("[image]\nmodulus = \"modulus.nrrd\"\ntarget = \"target.nrrd\"\n"
                           "confidence = \"confidence.nrrd\"\n[[condition]]\nwhere = \"left\"\ndy = -4.0\n");
  EXPECT_EQ(scene.full.modulus.values, (std::vector<float>{1, 2, 3, 4, 5, 6.5}));
  EXPECT_EQ(scene.full.target.x, (std::vector<float>{1, 3, 5, 7, 9, 11}));
  EXPECT_EQ(scene.full.target.y, (std::vector<float>{-4, 4, 6, -4, 10, 12}))
      << "conditions come after images";
  EXPECT_EQ(scene.full.confidence.x, (std::vector<float>{0, 0.5, 0, 0, 0, 1}));
  EXPECT_EQ(scene.full.confidence.y, (std::vector<float>{1, 0, 0, 1, 0, 0.25}));
}

TEST_F(ImageScene, SizeResamples) {
  const Scene scene = load(with_image("labels = \"labels.nrrd\""), {.size = Extent{30, 20}});
  EXPECT_EQ(scene.extent(), (Extent{30, 20}));
  EXPECT_NEAR(scene.spacing, 0.05, 1e-12);
  // The corner of the image stays where it is: half a pixel before the first pixel's centre.
  EXPECT_NEAR(scene.placement.origin[0] - 0.5 * 0.05, -0.5 * 0.5, 1e-12);
  EXPECT_NEAR(scene.placement.origin[1] - 0.5 * 0.05, -0.5 * 0.5, 1e-12);
  EXPECT_EQ(scene.full.modulus.values[0], 10.0F);
  EXPECT_EQ(scene.full.modulus.values[29], 30.0F);
}

TEST_F(ImageScene, ItsSpacingIsThatOfTheFilesPixels) {
  const std::string text = "spacing = 2.0\n" + with_image("labels = \"labels.nrrd\"");
  EXPECT_EQ(load(text).spacing, 2.0);
  const Scene halved = load(text, {.size = Extent{6, 4}});
  EXPECT_EQ(halved.spacing, 1.0);
  EXPECT_EQ(halved.placement.origin, (Placement::Vector{-0.5, -0.5, 0.0}));
  expect_refused("spacing = 0\n" + with_image("labels = \"labels.nrrd\""), "spacing must be positive");
}

TEST_F(ImageScene, KnowsTheFilesThatItIsMadeOf) {
  const auto scene = write("scene.toml", with_image("labels = \"labels.nrrd\"\npicture = \"none.nrrd\""));
  EXPECT_EQ(files_of_scene(scene.string()), (std::vector<fs::path>{scene, path("labels.nrrd")}));
  EXPECT_TRUE(files_of_scene("square").empty());
  EXPECT_TRUE(files_of_scene(path("nowhere.toml").string()).empty());
}

TEST_F(ImageScene, TheBrainIsAScene) {
  try {
    const Scene scene = load_scene("brain", {.size = Extent{100, 100}});
    EXPECT_EQ(scene.extent(), (Extent{100, 100}));
    EXPECT_EQ(scene.full.confidence.x.front(), 1.0F);
    EXPECT_EQ(scene.full.confidence.x[scene.extent().index(50, 50)], 0.0F);
    EXPECT_GT(std::ranges::count(scene.full.modulus.values, 40.0F), 0);
    EXPECT_GT(scene.spacing, 0.5);
  } catch (const MissingFile& error) {
    GTEST_SKIP() << error.what();
  }
}

} // namespace
} // namespace hdmbench
