// Deformations with a known truth: the same set on every backend, and files that agree with each other.

#include "harness/applications/spread.hpp"
#include "harness/scene/files.hpp"
#include "harness/scene/images/images.hpp"
#include "harness/scene/points.hpp"
#include "harness/scene/scene.hpp"
#include "test/files.hpp"
#include "test/program.hpp"

namespace hdmbench {
namespace {

class Dataset : public ImageFiles {
protected:
  void SetUp() override {
    const Extent extent{12, 11, 9};
    LabelField labels{extent, std::vector<int>(extent.sites(), 0)};
    ScalarField picture(extent);
    for_each_site(extent, [&](int x, int y, int z) {
      const bool is_tissue = x > 1 && x < 10 && y > 1 && y < 9 && z > 1 && z < 7;
      labels.values[extent.index(x, y, z)] = is_tissue ? 1 + x / 6 : 0;
      picture.values[extent.index(x, y, z)] = static_cast<float>(10 * x + 3 * y + z);
    });
    write_labels(path("labels.nrrd"), labels, 2.0, {.origin = {5.0, -7.0, 1.0}});
    write_scalar(path("t1.nrrd"), picture, 2.0, {.origin = {5.0, -7.0, 1.0}});
    (void)write("recipe.toml",
                "[recipe]\npoints = [2, 4]\ndisplacement = [1.0, 3.0]\ndeviation = 0.5\nmoduli = 0.3\n"
                "[[tissue]]\nlabel = 0\nmodulus = 0.5\n[[tissue]]\nlabel = 1\nmodulus = 3.0\n"
                "[[tissue]]\nlabel = 2\nmodulus = 6.0\n");
  }

  /// Returns the line with the hash of the set.
  std::string made(const std::string& more, const std::string& folder) const {
    const std::string output =
        test::expect_run(0, fmt::format("dataset {} --recipe {} --count 2 --output {} {}",
                                        path("labels.nrrd").string(), path("recipe.toml").string(),
                                        path(folder).string(), more))
            .output;
    const std::size_t at = output.find("hash of the set");
    return at == std::string::npos ? output : output.substr(at);
  }
};

TEST_F(Dataset, IsARecipeAndASeed) {
  const std::string one = made("--backend scalar --seed 4", "one");
  EXPECT_THAT(one, testing::StartsWith("hash of the set"));
  EXPECT_EQ(made("--backend openmp --seed 4", "other"), one);
  EXPECT_EQ(test::files_in(path("one")), test::files_in(path("other")));
  EXPECT_NE(made("--backend openmp --seed 5", "next"), one);
  EXPECT_EQ(test::files_in(path("one")).size(), 9U)
      << "points, field, its way back and labels of each; index";
}

/// The hash is of what the files say, and not of how they say it.
TEST_F(Dataset, HasTheSameHashInEveryFormat) {
  const std::string more = "--backend scalar --seed 4 --warp " + path("t1.nrrd").string() + " --format ";
  const std::string one = made(more + "nrrd", "nrrd");
  for (const std::string format : {"mha", "nii.gz", "h5", "npz"}) {
    EXPECT_EQ(made(more + format, format), one) << format;
  }
  EXPECT_EQ(test::files_in(path("npz")).size(), 3U) << "two deformations and the index";
  (void)made(more + "npz", "again");
  EXPECT_EQ(read_file(path("npz/0002.npz")), read_file(path("again/0002.npz"))) << "nothing has a date";
  const auto values = [&](const std::string& file) {
    const Image<VectorField> field = read_displacement(path(file), true);
    return field.pixels.planes;
  };
  EXPECT_EQ(values("h5/0001-field.h5"), values("nrrd/0001-field.nrrd"));
  EXPECT_EQ(values("nii.gz/0001-back.nii.gz"), values("nrrd/0001-back.nrrd"));
}

/// NumPy reads what the other formats have.
TEST_F(Dataset, WritesArraysForNumPy) {
  if (std::system("/usr/bin/python3 -c 'import numpy'") != 0) {
    GTEST_SKIP() << "NumPy is not there";
  }
  const std::string more = "--seed 4 --warp " + path("t1.nrrd").string() + " --format ";
  (void)made(more + "npz", "npz");
  (void)made(more + "nrrd", "nrrd");
  const Image<LabelField> labels = read_labels(path("nrrd/0001-labels.nrrd"), {.takes_volumes = true});
  const long sum = std::accumulate(labels.pixels.values.begin(), labels.pixels.values.end(), 0L);
  const fs::path script =
      write("read.py",
            fmt::format("import numpy as np\n"
                        "a = np.load('{0}/npz/0001.npz')\n"
                        "assert sorted(a) == ['affine', 'back', 'field', 'labels', 'moved-t1', 'points']\n"
                        "assert a['field'].shape == (9, 11, 12, 3) and a['field'].dtype == np.float32\n"
                        "assert a['labels'].dtype == np.int16 and a['labels'].sum() == {1}\n"
                        "raw = open('{0}/nrrd/0001-field.nrrd', 'rb').read().split(b'\\n\\n', 1)[1]\n"
                        "assert a['field'].tobytes() == raw\n"
                        "assert list(a['affine'] @ [1, 0, 0, 1]) == [7, -7, 1, 1]\n"
                        "t = np.loadtxt('{0}/nrrd/0001-points.csv', delimiter=',', skiprows=1)\n"
                        "assert (a['points'] == t).all()\n",
                        path("").string(), sum));
  EXPECT_EQ(std::system(fmt::format("/usr/bin/python3 {}", script.string()).c_str()), 0);
}

/// A recipe says what is held, by which law, and how strong the scene's loads are.
TEST_F(Dataset, DrawsLawsAndLoads) {
  const auto with = [&](const std::string& drawn, const std::string& folder) {
    (void)write("recipe.toml",
                "[recipe]\npoints = [1, 2]\ndisplacement = [0.5, 1.0]\n" + drawn +
                    "[[tissue]]\nlabel = 0\nmodulus = 0.5\ndensity = 0\n[[tissue]]\nlabel = 1\nmodulus = "
                    "0.003\ndensity = 1040\n[[tissue]]\nlabel = 2\nmodulus = 0.006\ndensity = 1040\n"
                    "[[condition]]\nwhere = \"back\"\ndx = 0\ndy = 0\ndz = 0\n"
                    "[[load]]\ngravity = [0, 9.81, 0]\n");
    return made("--seed 3", folder);
  };
  const std::string plain = with("", "plain");
  EXPECT_EQ(with("loads = [1, 1]\n", "once"), plain);
  EXPECT_NE(with("loads = [0, 0.5]\n", "less"), plain);
  EXPECT_NE(with("neo_hookean = 1\n", "law"), plain);
  EXPECT_THAT(read_file(path("law/index.csv")), HasSubstr(",neo-hookean,1,"));
  EXPECT_THAT(read_file(path("less/index.csv")), ContainsRegex("1,[12],as stated,0\\.[0-4]"));
}

/// Tissues of a body in void whose label 2 is taken out; `more` are lines of [recipe], `gravity` is in m/s^2.
std::string resected(const std::string& more, const std::string& gravity) {
  return "[recipe]\npoints = [6, 6]\ndisplacement = [0.5, 1.0]\n" + more +
         "[[tissue]]\nlabel = 0\nmodulus = 0\n[[tissue]]\nlabel = 1\nmodulus = 0.003\ndensity = 1040\n"
         "[[tissue]]\nlabel = 2\nmodulus = 0.006\ndensity = 1040\n[[resect]]\nlabel = 2\n"
         "[[condition]]\nwhere = \"labels\"\nlabels = [1]\ncentre = [0.2, 0.5, 0.5]\nsize = [0.1, 2.0, 2.0]\n"
         "dx = 0\ndy = 0\ndz = 0\n[[load]]\nbefore = true\ngravity = [0, " +
         gravity + ", 0]\n";
}

/// Loads of before are loads, too, and a point in void is known to nobody.
TEST_F(Dataset, TakesOutWhatItsLoadsBore) {
  const auto with = [&](const std::string& drawn, const std::string& gravity, const std::string& folder) {
    (void)write("recipe.toml", resected("labels = [0, 1, 2]\n" + drawn, gravity));
    return made("--seed 3", folder);
  };
  const std::string plain = with("", "4", "plain");
  EXPECT_EQ(with("loads = [2, 2]\n", "2", "twice"), plain);
  EXPECT_NE(with("loads = [1, 1]\n", "2", "once"), plain);
  const LabelField labels = read_labels(path("labels.nrrd"), {.takes_volumes = true}).pixels;
  for (const std::string file : {"plain/0001-points.csv", "plain/0002-points.csv"}) {
    for (const PointPair& pair : read_point_pairs(path(file))) {
      const auto index = [&](std::size_t axis, double origin) {
        return static_cast<int>(std::lround((pair.before[axis] - origin) / 2.0));
      };
      EXPECT_EQ(labels.values[labels.extent.index(index(0, 5.0), index(1, -7.0), index(2, 1.0))], 1);
    }
  }
}

/// What void is depends on the stiffest tissue, which is another one in each draw.
TEST_F(Dataset, DrawsModuliOfTissueAlone) {
  (void)write("recipe.toml", resected("", "4"));
  Scene scene = load_scene(path("labels.nrrd").string(), {.tissues = path("recipe.toml")});
  const ScalarField tissue = tissue_of(scene);
  for (std::uint32_t seed = 0; seed < 20; ++seed) {
    NormalDraws random(1, seed);
    const Scene drawn = with_drawn_moduli(scene, 1.5, random);
    EXPECT_EQ(tissue_of(drawn).values, tissue.values) << "draw " << seed;
    const std::size_t site = scene.extent().index(4, 4, 4);
    EXPECT_EQ(drawn.before->modulus.values[site], drawn.full.modulus.values[site]) << "draw " << seed;
    EXPECT_NE(drawn.full.modulus.values[site], scene.full.modulus.values[site]) << "draw " << seed;
  }
}

TEST_F(Dataset, ARecipeIsATable) {
  (void)write("number.toml", "recipe = 3\n[[tissue]]\nlabel = 0\nmodulus = 1\n");
  test::expect_run(2,
                   fmt::format("dataset {} --recipe {} --output {}", path("labels.nrrd").string(),
                               path("number.toml").string(), path("none").string()),
                   testing::HasSubstr("has no [recipe], which says what is drawn"));
  (void)write("loads.toml",
              "[recipe]\nloads = [0, 1]\n[[tissue]]\nlabel = 0\nmodulus = 1\n[[tissue]]\nlabel = "
              "1\nmodulus = 1\n[[tissue]]\nlabel = 2\nmodulus = 1\n");
  test::expect_run(2,
                   fmt::format("dataset {} --recipe {} --output {}", path("labels.nrrd").string(),
                               path("loads.toml").string(), path("none").string()),
                   testing::HasSubstr("how many times the [[load]]s act, and there are none"));
}

/// The field takes the drawn points near to where they were drawn to go, and what it moves is there.
TEST_F(Dataset, HasFilesThatAgree) {
  (void)made("--warp " + path("t1.nrrd").string(), "set");
  const Image<VectorField> field = read_displacement(path("set/0001-field.nrrd"), true);
  EXPECT_EQ(field.pixels.extent, (Extent{12, 11, 9}));
  const Scene scene = load_scene(path("labels.nrrd").string(),
                                 {.tissues = path("recipe.toml"), .points = {path("set/0001-points.csv")}});
  EXPECT_GE(scene.points.size(), 2U);
  EXPECT_LE(scene.points.size(), 4U);
  for (const KnownPoint& point : scene.points) {
    const double asked = std::hypot(point.target[0], point.target[1], point.target[2]) * scene.spacing;
    EXPECT_GE(asked, 0.999);
    EXPECT_LE(asked, 3.001);
    EXPECT_LT(residual_at(point, field.pixels) * scene.spacing, asked);
  }
  test::expect_run(0, fmt::format("warp {} --labels --transform {} --output {}", path("labels.nrrd").string(),
                                  path("set/0001-back.nrrd").string(), path("again").string()));
  EXPECT_EQ(read_labels(path("again/labels.nrrd"), {.takes_volumes = true}).pixels.values,
            read_labels(path("set/0001-labels.nrrd"), {.takes_volumes = true}).pixels.values);
  EXPECT_TRUE(fs::exists(path("set/0001-moved-t1.nrrd")));
}

} // namespace
} // namespace hdmbench
