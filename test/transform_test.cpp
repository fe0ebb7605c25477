// Displacements that lead back: what invert() finds, and what ITK, which resamples with them, makes of the
// files.

#include "harness/scene/images/pixels.hpp"
#include "test/files.hpp"
#include "test/program.hpp"
#include "test/scenes.hpp"
#include "test/sessions.hpp"

#include <itkDisplacementFieldTransform.h>
#include <itkHDF5TransformIO.h>
#include <itkImageFileReader.h>
#include <itkMetaImageIO.h>
#include <itkNiftiImageIO.h>
#include <itkNrrdImageIO.h>
#include <itkTransformFactory.h>

#include <numbers>
#include <numeric>

namespace hdmbench {
namespace {

using Place = std::array<double, 3>;
using Transform = itk::DisplacementFieldTransform<double, 3>;

/// Waves that are 0 on the border, `largest` pixels high.
VectorField waves(Extent extent, double largest) {
  VectorField field(extent);
  for_each_site(extent, [&](int x, int y, int z) {
    const Place at{double(x), double(y), double(z)};
    double height = largest;
    for (std::size_t axis = 0; axis < extent.axes(); ++axis) {
      height *= std::sin(std::numbers::pi * at[axis] / std::max(1, extent.sides()[axis] - 1));
    }
    for (std::size_t axis = 0; axis < extent.axes(); ++axis) {
      field[axis][extent.index(x, y, z)] = static_cast<float>(height * (axis == 1 ? -0.8 : 1.0));
    }
  });
  return field;
}

/// How far a point that `inverse` leads back to lands from the site, along the axis where it is most.
double gap_at(const VectorField& displacement, const VectorField& inverse, int x, int y, int z) {
  const Extent extent = displacement.extent;
  const std::size_t site = extent.index(x, y, z);
  Place from{double(x), double(y), double(z)};
  for (std::size_t axis = 0; axis < extent.axes(); ++axis) {
    from[axis] += double{inverse[axis][site]};
  }
  double gap = 0.0;
  for (std::size_t axis = 0; axis < extent.axes(); ++axis) {
    const double way = images::linear_at(displacement[axis], extent, from[0], from[1], from[2]);
    gap = std::max(gap, std::abs(double{inverse[axis][site]} + way));
  }
  return gap;
}

TEST(Inverse, LeadsEverySiteBackToWhereItCameFrom) {
  for (const Extent extent :
       {Extent{40, 31}, Extent{17, 20, 13}, Extent{1, 9}, Extent{5, 1}, Extent{2, 2, 2}}) {
    for (const double largest : {0.5, 3.0}) {
      const VectorField field = waves(extent, largest);
      const Inverse inverse = invert(field);
      EXPECT_EQ(inverse.unmet, 0U) << extent.text() << ", " << largest;
      for_each_site(extent, [&](int x, int y, int z) {
        EXPECT_LE(gap_at(field, inverse.displacement, x, y, z), 2e-4) << x << ' ' << y << ' ' << z;
      });
    }
  }
}

TEST(Inverse, OfAShiftIsTheOppositeAlsoWhereNothingIsKnown) {
  VectorField field({6, 5, 4});
  std::ranges::fill(field[0], 2.5F);
  std::ranges::fill(field[2], -7.0F);
  const Inverse inverse = invert(field);
  EXPECT_EQ(inverse.unmet, 0U);
  for (std::size_t site = 0; site < field.extent.sites(); ++site) {
    EXPECT_EQ(inverse.displacement[0][site], -2.5F);
    EXPECT_EQ(inverse.displacement[1][site], 0.0F);
    EXPECT_EQ(inverse.displacement[2][site], 7.0F);
  }
}

/// What it says of folds is what is there, and of tissue alone where there is void.
TEST(Inverse, CountsTheSitesThatItDoesNotMeet) {
  std::size_t unmet = 0;
  std::size_t of_void = 0;
  for (const unsigned seed : {1U, 2U, 3U}) {
    const Extent extent{24, 20};
    VectorField field = waves(extent, 1.0);
    std::mt19937 random(seed);
    for (std::vector<float>& values : field.planes) { // a crumpled image
      std::ranges::transform(values, values.begin(), [&](float value) {
        return value * static_cast<float>(random() % 1000) * 0.01F;
      });
    }
    const Inverse inverse = invert(field);
    std::size_t far = 0;
    double farthest = 0.0;
    for_each_site(extent, [&](int x, int y, int z) {
      const double gap = gap_at(field, inverse.displacement, x, y, z);
      far += gap > inverse_is_met ? 1 : 0;
      farthest = std::max(farthest, gap);
    });
    EXPECT_EQ(inverse.unmet, far) << seed;
    EXPECT_NEAR(inverse.farthest, farthest, 1e-5) << seed;
    unmet += far;
    ScalarField tissue(extent); // the left half
    for_each_site(extent,
                  [&](int x, int y, int /*z*/) { tissue.values[extent.index(x, y)] = x < 12 ? 1.0F : 0.0F; });
    std::size_t of_tissue = 0;
    for_each_site(extent, [&](int x, int y, int z) {
      const double origin = x + double{inverse.displacement[0][extent.index(x, y)]};
      of_tissue += origin <= 11.0 && gap_at(field, inverse.displacement, x, y, z) > inverse_is_met ? 1 : 0;
    });
    EXPECT_EQ(invert(field, tissue).unmet, of_tissue) << seed;
    of_void += far - of_tissue;
  }
  EXPECT_GT(unmet, of_void) << "nothing was hard enough";
  EXPECT_GT(of_void, 0U) << "nothing was hard enough";
  VectorField broken({3, 3});
  broken[0][4] = NAN;
  expect_refusal([&] { (void)invert(broken); }, "must be finite");
}

/// Axes of the space in any order, with any sign, and turned a little, that a volume lies along.
std::array<Placement::Vector, 3> axes_of(int number, double angle) {
  std::array<std::size_t, 3> order{0, 1, 2};
  for (int i = 0; i < number / 8; ++i) {
    std::ranges::next_permutation(order);
  }
  const double c = std::cos(angle);
  const double s = std::sin(angle);
  const std::array<Placement::Vector, 3> turned{{{c, s, 0.0}, {-s * c, c * c, s}, {s * s, -s * c, c}}};
  std::array<Placement::Vector, 3> axes{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    axes[axis] = turned[order[axis]];
    for (double& component : axes[axis]) {
      component *= (number >> axis & 1) != 0 ? -1.0 : 1.0;
    }
  }
  return axes;
}

Transform::Pointer read_by_itk(const fs::path& file) {
  if (file.extension() == ".h5") {
    itk::TransformFactory<Transform>::RegisterTransform();
    const auto format = itk::HDF5TransformIOTemplate<double>::New();
    format->SetFileName(file.string());
    format->Read();
    return dynamic_cast<Transform*>(format->GetReadTransformList().front().GetPointer());
  }
  const auto reader = itk::ImageFileReader<Transform::DisplacementFieldType>::New();
  reader->SetFileName(file.string());
  if (file.extension() == ".nrrd") {
    reader->SetImageIO(itk::NrrdImageIO::New());
  } else {
    reader->SetImageIO(itk::MetaImageIO::New());
  }
  reader->Update();
  auto transform = Transform::New();
  transform->SetDisplacementField(reader->GetOutput());
  return transform;
}

class Transforms : public ImageFiles {};

/// 48 ways to lie, straight and oblique, with cubes and with boxes of a file: where tissue has moved to, ITK
/// leads back to where it was.
TEST_F(Transforms, LeadAMovedPointBackInITK) {
  const Extent extent{11, 12, 13};
  VectorField field(extent); // a linear one, whose inverse is linear between sites as well
  for_each_site(extent, [&](int x, int y, int z) {
    const std::size_t site = extent.index(x, y, z);
    field[0][site] = 0.04F * static_cast<float>(x) + 0.02F * static_cast<float>(y) - 0.4F;
    field[1][site] = -0.03F * static_cast<float>(z) + 0.2F;
    field[2][site] = 0.05F * static_cast<float>(x - y);
  });
  const VectorField back = invert(field).displacement;
  const double side = 1.5;
  for (int number = 0; number < 48; ++number) {
    for (const double angle : {0.0, 0.3}) {
      const Placement placement{.origin = {-20.0, 31.0, 7.5}, .axes = axes_of(number, angle)};
      for (const bool has_boxes : {false, true}) {
        std::optional<FileGrid> grid;
        if (has_boxes) {
          grid = FileGrid{{11, 12, 7}, {1.5, 1.5, 3.0}, placement};
        }
        const std::string name =
            fmt::format("{}.{}", has_boxes ? "boxes" : "cubes",
                        std::array{"nrrd", "mha", "h5"}.at(static_cast<std::size_t>(number % 3)));
        write_displacement(path(name), back, side, placement, grid, Mapping::backward);
        const Transform::Pointer transform = read_by_itk(path(name));
        ASSERT_TRUE(transform) << name;
        for (const auto& [x, y, z] : {std::array{3, 4, 5}, {7, 3, 8}, {5, 8, 6}}) {
          const std::size_t site = extent.index(x, y, z);
          const auto in_space = [&](double more) {
            const Placement moved = placement.moved(side * (x + more * double{field[0][site]}),
                                                    side * (y + more * double{field[1][site]}),
                                                    side * (z + more * double{field[2][site]}));
            return itk::Point<double, 3>(moved.origin.data());
          };
          EXPECT_LE((transform->TransformPoint(in_space(1.0)) - in_space(0.0)).GetNorm(), 1e-4)
              << name << ", way " << number << ", angle " << angle;
        }
        if (!has_boxes) { // which our reader takes to cubes
          write_displacement(path("again.nii.gz"), back, side, placement, grid, Mapping::backward);
          for (const fs::path& file : {path(name), path("again.nii.gz")}) {
            const VectorField read = read_displacement(file, true).pixels;
            const std::size_t site = extent.index(3, 4, 4);
            EXPECT_NEAR(read[2][site], back[2][site], 1e-5) << file << ", way " << number;
          }
        }
      }
    }
  }
}

TEST_F(Transforms, WhatIsNoneIsRefused) {
  (void)write("text.h5", "no HDF5");
  expect_refusal([&] { (void)read_displacement(path("text.h5"), true); }, "text.h5");
  expect_refusal([&] { (void)read_displacement(path("none.h5"), true); }, "none.h5");
  expect_refusal([&] { require_displacement_name(path("a.png"), {3, 3, 3}); }, "must end in");
  expect_refusal([&] { require_displacement_name(path("a.nii.gz"), {3, 3}); }, "NIfTI is for volumes");
}

/// A picture that is pulled back by the file is the one that is pushed by the displacement.
TEST_F(Transforms, TheCommandsMoveAPictureAsTheTissueMoves) {
  for (const auto& [scene, size, words, options] :
       {std::tuple{"ball", Extent{24, 20, 22}, "24x20x22", "--energy elastic"},
        std::tuple{"square", Extent{40, 32}, "40x32", ""}}) {
    const Scene loaded = load_scene(scene, {.size = size});
    write_scalar(path("picture.mha"), loaded.picture, loaded.spacing, loaded.placement);
    write_labels(path("labels.mha"), loaded.labels, loaded.spacing, loaded.placement);
    const std::string arguments = fmt::format(
        "run {} --size {} {} --format mha --output '{}' --transform '{}' --warp '{}'", scene, words, options,
        path("out").string(), path("back.h5").string(), path("picture.mha").string());
    test::expect_run(
        0, arguments,
        testing::AllOf(testing::HasSubstr("leads back"), testing::HasSubstr("picture.mha, moved")));
    test::expect_run(0, fmt::format("warp '{0}' --transform '{1}' --output '{2}' --format mha",
                                    path("picture.mha").string(), path("back.h5").string(),
                                    path("moved").string()));
    test::expect_run(0, fmt::format("warp '{0}' --transform '{1}' --output '{2}' --labels",
                                    path("labels.mha").string(), path("back.h5").string(),
                                    path("moved").string()));
    EXPECT_EQ(test::files_in(path("out"))["picture.mha"], test::files_in(path("moved"))["picture.mha"]);
    const VectorField displacement =
        read_displacement(path("out") / fmt::format("{}.mha", scene), true).pixels;
    const ScalarField pushed = warp(loaded.picture, displacement);
    const ScalarField pulled = read_scalar(path("moved") / "picture.mha", {.takes_volumes = true}).pixels;
    ASSERT_EQ(pulled.extent, pushed.extent);
    double moved = 0.0;
    double apart = 0.0;
    for (std::size_t site = 0; site < pushed.values.size(); ++site) {
      moved += std::pow(double{pushed.values[site]} - loaded.picture.values[site], 2);
      apart += std::pow(double{pushed.values[site]} - pulled.values[site], 2);
    }
    EXPECT_GT(moved, 0.0) << scene;
    EXPECT_LE(apart, 0.02 * moved) << scene << ": " << moved;
    test::expect_run(0,
                     fmt::format("warp '{0}' --transform '{1}/{2}.mha' --output '{3}'",
                                 path("picture.mha").string(), path("out").string(), scene,
                                 path("wrong").string()),
                     testing::HasSubstr("back to before"));
    const LabelField labels = read_labels(path("moved") / "labels.nrrd", {.takes_volumes = true}).pixels;
    EXPECT_THAT(std::set<int>(labels.values.begin(), labels.values.end()),
                testing::IsSubsetOf(std::set<int>(loaded.labels.values.begin(), loaded.labels.values.end())))
        << scene;
  }
  test::expect_run(2,
                   fmt::format("warp '{0}' '{1}/picture.mha' --transform '{2}' --output '{3}'",
                               path("picture.mha").string(), path("moved").string(), path("back.h5").string(),
                               path("other").string()),
                   testing::HasSubstr("would both become picture.nrrd"));
  test::expect_run(2, fmt::format("warp '{0}' --transform '{1}' --output '{2}' --format mha",
                                  path("picture.mha").string(), path("back.h5").string(), path("").string()));
  test::expect_run(2,
                   fmt::format("run square --size 32 --output '{0}' --transform '{0}/../out/square.nrrd'",
                               path("out").string()),
                   testing::HasSubstr("what run writes anyway"));
  test::expect_run(2, fmt::format("run square --size 32 --transform '{}'", path("back.txt").string()),
                   testing::HasSubstr("must end in"));
  for (const auto& [words, says] :
       {std::pair{fmt::format("--warp '{}'", path("picture.mha").string()), "give both"},
        {fmt::format("--warp '{}' --transform '{}'", path("none.mha").string(), path("b.h5").string()),
         "there is no such file"},
        {fmt::format("--warp '{0}/square.mha' --transform '{0}/../b.h5'", path("out").string()),
         "which run writes anyway"}}) {
    test::expect_run(
        2, fmt::format("run square --size 32 --format mha --output '{}' {}", path("out").string(), words),
        testing::HasSubstr(says));
  }
}

/// A volume from a file has one size, and `bench` takes it where it is told none.
TEST_F(Transforms, TheCommandBenchTakesTheSizeOfAVolumeFromAFile) {
  const Extent extent{10, 9, 8};
  write_labels(path("labels.nrrd"), {extent, std::vector<int>(extent.sites(), 1)}, 2.0, {});
  const std::string scene =
      write("scene.toml", "energy = \"elastic\"\n[image]\nlabels = \"labels.nrrd\"\n[[tissue]]\nlabel = "
                          "1\nmodulus = 3.0\n[[condition]]\nwhere = \"left\"\ndx = 1.0\ndy = 0.0\ndz = 0.0\n")
          .string();
  const std::string bench = "bench --backends openmp --no-ceilings --repeat 1 ";
  test::expect_run(0, bench + "'" + scene + "'", testing::HasSubstr("10 x 9 x 8"));
  test::expect_run(2, bench + "square '" + scene + "'", testing::HasSubstr("no sizes in common"));
}

/// What the program says of a point that is left out is what a scene says that never had it.
TEST_F(Transforms, TheCommandLeavesPointsOutInTurn) {
  const Extent extent{10, 9, 8};
  write_labels(path("labels.nrrd"), {extent, std::vector<int>(extent.sites(), 1)}, 2.0, {});
  const std::filesystem::path tissues = write("tissues.toml", "[[tissue]]\nlabel = 1\nmodulus = 3.0\n");
  const std::array<std::string, 2> points{"9 7.5 6.5 0.6 -0.2 0.9\n", "12 8 8 0.5 0.1 -0.3\n"};
  const std::string run = fmt::format(
      "run '{}' --tissues '{}' --points '{}' --no-pictures --output '{}' ", path("labels.nrrd").string(),
      tissues.string(), write("both.txt", points[0] + points[1]).string(), path("out").string());
  test::expect_run(
      0, fmt::format("{} --leave-one-out --uncertainty 2 --json '{}'", run, path("run.json").string()),
      testing::AllOf(testing::HasSubstr("each left out in turn"), testing::HasSubstr("left out  how sure")));
  const auto result = test::read_json(path("run.json"))["results"][0];
  const auto rows = result["points"];
  EXPECT_GT(result["phases"]["left_out_seconds"].get<double>(), 0.0);
  EXPECT_GT(result["phases"]["uncertainty_seconds"].get<double>(), 0.0);
  const Scene both =
      load_scene(path("labels.nrrd").string(), {.tissues = tissues, .points = {path("both.txt")}});
  for (std::size_t left_out = 0; left_out < 2; ++left_out) {
    const Scene other =
        load_scene(path("labels.nrrd").string(),
                   {.tissues = tissues, .points = {write("other.txt", points[1 - left_out])}});
    const double miss = 2.0 * residual_at(both.points[left_out], test::solved(other).displacement);
    EXPECT_GT(miss, 0.1);
    EXPECT_NEAR(rows[left_out]["left_out_mm"].get<double>(), miss, 1e-9 * miss);
    EXPECT_LE(rows[left_out]["residual_mm"].get<double>(), 1e-5);
  }
  (void)write("free.toml", "[image]\nlabels = \"labels.nrrd\"\n[[tissue]]\nlabel = 1\nmodulus = 3.0\n");
  test::expect_run(
      0,
      fmt::format("run '{}' --energy elastic --points '{}' --leave-one-out --no-pictures "
                  "--output '{}'",
                  path("free.toml").string(), path("other.txt").string(), path("out").string()),
      testing::AllOf(testing::HasSubstr("without 1 of them"), testing::Not(testing::HasSubstr("in turn"))));
  test::expect_run(2, "run square --size 9 --leave-one-out", testing::HasSubstr("the scene has none"));
}

} // namespace
} // namespace hdmbench
