// Fibres of a scene: where they lead in the image, and what is refused.

#include "harness/scene/scene.hpp"
#include "test/files.hpp"

namespace hdmbench {
namespace {

constexpr const char* directions_of[] = {"(2,0,0) (0,2,0) (0,0,4)", "(0,-2,0) (2,0,0) (0,0,4)",
                                         "(0,0,4) (0,2,0) (-2,0,0)", "(1.2,1.6,0) (-1.6,1.2,0) (0,0,4)"};

class FibreScene : public ImageFiles {
protected:
  [[nodiscard]] std::string header(const char* type, int dimensions, const char* directions,
                                   const char* more) const {
    const bool is_vector = dimensions == 4;
    return fmt::format("NRRD0004\ntype: {}\ndimension: {}\nspace: left-posterior-superior\nsizes: {}4 4 4\n"
                       "space directions: {}{}\nspace origin: (3,-8,1)\nencoding: ascii\n{}\n",
                       type, dimensions, is_vector ? "3 " : "", is_vector ? "none " : "", directions, more);
  }
  void write_labels(const char* directions) const {
    std::string labels;
    for (int site = 0; site < 64; ++site) {
      labels += site % 4 == 3 ? "2 " : "1 ";
    }
    write("labels.nrrd", header("uchar", 3, directions, "") + labels);
  }
  [[nodiscard]] Scene load(const std::string& tissue, const std::string& image = "",
                           const SceneOptions& options = {}) const {
    return load_scene(
        write("scene.toml", fmt::format("energy = \"elastic\"\n[[tissue]]\nlabel = 1\nmodulus = 2.0\n{}"
                                        "[[tissue]]\nlabel = 2\nmodulus = 1.0\n"
                                        "[[condition]]\nwhere = \"left\"\ndx = 0\ndy = 0\ndz = 0\n"
                                        "[[condition]]\nwhere = \"right\"\ndx = 0.5\n"
                                        "[image]\nlabels = \"labels.nrrd\"\n{}",
                                        tissue, image))
            .string(),
        options);
  }
  static constexpr const char* law = "law = \"neo-hookean\"\n";
};

/// Their direction is in the patient's space, whether a tissue or an image has it, and of any length.
TEST_F(FibreScene, LeadInThePatientsSpace) {
  constexpr std::array<std::array<double, 3>, 4> expected{
      {{0.6, -0.64, 0.48}, {0.64, 0.6, 0.48}, {0.48, -0.64, -0.6}, {-0.152, -0.864, 0.48}}};
  for (std::size_t i = 0; i < expected.size(); ++i) {
    const char* const directions = directions_of[i];
    write_labels(directions);
    const Scene by_tissue = load(std::string(law) + "fibre = [1.2, -1.28, 0.96]\nfibre_modulus = 32.0\n");
    std::string vectors;
    for (int site = 0; site < 64; ++site) {
      vectors += site == 21 ? "0 0 0 " : "12 -12.8 9.6 ";
    }
    write("fibre.nrrd", header("float", 4, directions, "kinds: vector domain domain domain\n") + vectors);
    const Scene by_image = load(std::string(law) + "fibre_modulus = 32.0\nfibre_tension_only = false\n",
                                "fibre = \"fibre.nrrd\"\n");
    for (std::size_t axis = 0; axis < 3; ++axis) {
      for (std::size_t site = 0; site < 64; ++site) {
        const double of_label = site % 4 == 3 ? 0.0 : 2.0 * expected.at(i).at(axis); // (32 / 2)^(1/4)
        ASSERT_NEAR(by_tissue.full.fibre[axis][site], of_label, 2e-6) << directions << ", site " << site;
        ASSERT_NEAR(by_image.full.fibre[axis][site], site == 21 ? 0.0 : of_label, 2e-6)
            << directions << ", site " << site;
      }
    }
    EXPECT_EQ(by_tissue.full.fibre_compression.values[1], 0.0F);
    EXPECT_EQ(by_image.full.fibre_compression.values[1], 1.0F);
  }
}

/// In an image a fibre bears by its share in the plane, to the fourth power, whoever says where it leads.
TEST_F(FibreScene, OfAnImageBearByWhatOfThemIsInItsPlane) {
  const auto one_slice = [&](std::string text) { return text.replace(text.find("4 4 4"), 5, "4 4 1"); };
  std::string vectors;
  std::string labels;
  for (int site = 0; site < 16; ++site) {
    vectors += "3 0 4 ";
    labels += "1 ";
  }
  write("labels.nrrd", one_slice(header("uchar", 3, directions_of[0], "")) + labels);
  write("fibre.nrrd",
        one_slice(header("float", 4, directions_of[0], "kinds: vector domain domain domain\n")) + vectors);
  const auto load_image = [&](const std::string& fibre, const std::string& image) {
    return load_scene(
        write("image.toml", "energy = \"elastic\"\nlaw = \"neo-hookean\"\n[[tissue]]\nlabel = 1\n"
                            "modulus = 2.0\nfibre_modulus = 32.0\n" +
                                fibre + "[[condition]]\nwhere = \"border\"\ndx = 0\ndy = 0\n" +
                                "[image]\nlabels = \"labels.nrrd\"\n" + image)
            .string());
  };
  const Scene by_tissue = load_image("fibre = [3, 0, 4]\n", "");
  const Scene by_image = load_image("", "fibre = \"fibre.nrrd\"\n");
  for (const Scene* const scene : {&by_tissue, &by_image}) {
    EXPECT_NEAR(scene->full.fibre[0][5], 2.0 * 0.6, 1e-6);
    EXPECT_EQ(scene->full.fibre[1][5], 0.0F);
    EXPECT_TRUE(scene->idle.empty());
  }
  const Scene across = load_image("fibre = [0, 0, 1]\n", "");
  EXPECT_THAT(across.idle, testing::Contains(testing::HasSubstr("whose fibres lead out of the image")));
}

TEST_F(FibreScene, AreRefusedWhereTheyCannotBe) {
  write_labels(directions_of[0]);
  const std::string fibres = "fibre = [1, 0, 0]\nfibre_modulus = 5.0\n";
  expect_refusal([&] { (void)load(fibres); }, "of label 1 has fibres, which go with large strains");
  expect_refusal([&] { (void)load(std::string(law) + "fibre_modulus = 5.0\n"); },
                 "nothing says where its fibres");
  expect_refusal([&] { (void)load(std::string(law) + "fibre = [1, 0, 0]\n"); },
                 "fibre has no effect in this scene: it belongs to a fibre_modulus");
  expect_refusal([&] { (void)load(std::string(law) + "fibre = [0, 0, 0]\nfibre_modulus = 5.0\n"); },
                 "fibre has no direction");
  expect_refusal([&] { (void)load(std::string(law) + "fibre = [0, 0, 1]\nfibre_modulus = -5.0\n"); },
                 "fibre_modulus is -5, it must be positive");
  std::string vectors;
  for (int i = 0; i < 192; ++i) {
    vectors += "1 ";
  }
  write("fibre.nrrd", header("float", 4, directions_of[0], "kinds: vector domain domain domain\n") + vectors);
  expect_refusal([&] { (void)load(law, "fibre = \"fibre.nrrd\"\n"); }, "no [[tissue]] a fibre_modulus");
  expect_refusal(
      [&] {
        (void)load(std::string(law) + "fibre_modulus = 5.0\n", "fibre = \"fibre.nrrd\"\n",
                   {.as_cubes = true});
      },
      "fibre takes the file's own pixels");
}

} // namespace
} // namespace hdmbench
