#include "harness/scene/carried_conditions.hpp"
#include "harness/scene/images/images.hpp"
#include "harness/scene/method.hpp"
#include "harness/scene/precision.hpp"
#include "harness/scene/scene_content.hpp"
#include "kernels/data/elastic/springs.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <utility>

namespace hdmbench {

namespace {

/// `why_wrong` returns what is wrong with a value, or nothing.
template <typename WhyWrong>
void require(TomlReader& image, std::string_view key, const VectorField& field, const WhyWrong& why_wrong) {
  for (std::size_t axis = 0; axis < field.extent.axes(); ++axis) {
    for (std::size_t site = 0; site < field[axis].size(); ++site) {
      if (const char* const why = why_wrong(field[axis][site]); why != nullptr) {
        image.fail(
            key, fmt::format("{} (its value at {} is {})", why, field.extent.place(site), field[axis][site]));
      }
      if (key == "target" || key == "start") {
        require_possible_displacement(image, key, double{field[axis][site]});
      }
    }
  }
}

/// Reads the images of a scene's [image] one by one.
class VectorImages {
public:
  VectorImages(TomlReader& image, const SceneText& file, std::optional<Extent> size, const Content& content)
      : image_(image), file_(file), content_(content), size_(size) {}

  /// How certain targets are: which key says it, or "" where there are none.
  std::string_view certainty() {
    constexpr std::array<std::string_view, 3> keys{"confidence", "deviation", "precision"};
    std::string_view given;
    for (const std::string_view key : keys) {
      if (image_.has(key) && !given.empty()) {
        image_.fail(key, fmt::format("cannot stand beside {}", given));
      }
      given = image_.has(key) ? key : given;
    }
    if (image_.has("target") == given.empty()) {
      image_.fail("target", "and confidence (or deviation, or precision): give both images or none");
    }
    if (!given.empty()) {
      image_.read("target_unit", std::array<std::string_view, 2>{"pixels", "mm"}, is_physical_);
    }
    return given;
  }

  VectorField target() {
    VectorField target = read("target", true, side_of_targets(), read_vector);
    require(image_, "target", target, [](float value) {
      return std::isfinite(value) ? nullptr : "must be finite; where nothing is observed the confidence is 0";
    });
    return target;
  }

  VectorField confidence(bool by_deviation) {
    const char* const key = by_deviation ? "deviation" : "confidence";
    VectorField confidence = read(key, true, {}, read_vector);
    require(image_, key, confidence, [&](float value) -> const char* {
      if (by_deviation) {
        return value >= 0.0F ? nullptr : "has a value below 0 (pixels); infinite is not observed";
      }
      return value >= 0.0F && value <= 1.0F ? nullptr : "must be 0 ... 1";
    });
    for (std::vector<float>& plane : confidence.planes) {
      for (float& value : plane) {
        value = by_deviation ? confidence_of_deviation(static_cast<double>(value)) : value; // 0 of infinity
      }
    }
    return confidence;
  }

  /// Returns that of `sites`, whose pixels are not resampled.
  Precision precision(Extent sites) {
    require_own_pixels("precision", sites);
    Precision precision{.entries = {}, .target = target()};
    for (ScalarField& entry : read("precision", true, side_of_targets(), read_matrix)) {
      precision.entries.push_back(std::move(entry.values));
    }
    if (const auto wrong = find_impossible(precision)) {
      image_.fail("precision", fmt::format("must be the inverse of a covariance, a symmetric matrix that has "
                                           "no negative eigenvalue; its value at {} is not",
                                           sites.place(*wrong)));
    }
    return precision;
  }

  /// MPa over a shortest side; where the image ends a site stands for a part of its pixel.
  VectorField force(Extent sites) {
    require_own_pixels("force", sites);
    VectorField force = read("force", true, 1.0 / content_.spacing, read_vector);
    require(image_, "force", force,
            [](float value) { return std::isfinite(value) ? nullptr : "must be finite"; });
    return force;
  }

  /// Directions of length 1 in the space.
  VectorField fibre(Extent sites) {
    require_own_pixels("fibre", sites);
    VectorField fibre = read("fibre", true, {}, read_directions);
    require(image_, "fibre", fibre, [](float value) {
      return std::isfinite(value) ? nullptr : "must be finite; 0 is a pixel without fibres";
    });
    return fibre;
  }

  /// Directions as those of fibres.
  VectorField normals(Extent sites) {
    require_own_pixels("normals", sites);
    VectorField normals = read("normals", true, {}, read_normals);
    require(image_, "normals", normals, [](float value) {
      return std::isfinite(value) ? nullptr
                                  : "must be finite; 0 is a pixel whose normal is that of the labels";
    });
    return normals;
  }

  VectorField start() {
    VectorField start = read("start", false, {}, read_vector);
    require(image_, "start", start,
            [](float value) { return std::isfinite(value) ? nullptr : "must be finite"; });
    return start;
  }

  [[nodiscard]] PixelPositions positions() const {
    return positions_of(content_.grid, content_.spacing, content_.placement);
  }

private:
  void require_own_pixels(std::string_view key, Extent sites) const {
    if (!are_the_sites(content_.grid.extent, positions(), sites)) {
      image_.fail(key, "takes the file's own pixels, which are resampled here; leave --size out");
    }
  }

  [[nodiscard]] std::optional<double> side_of_targets() const {
    return is_physical_ ? std::optional(content_.spacing) : std::nullopt;
  }

  /// `physical_side`: as of ReadOptions.
  template <typename Pixels>
  Pixels read(std::string_view key, bool as_stored, std::optional<double> physical_side,
              Image<Pixels> (*read_file)(const std::filesystem::path&, const ReadOptions&)) {
    ReadOptions options{.size = as_stored ? std::nullopt : size_,
                        .spacing = content_.stated_spacing,
                        .takes_volumes = true,
                        .as_stored = as_stored};
    options.physical_side = physical_side;
    const std::filesystem::path vectors = file_.image(image_, key, options);
    Image<Pixels> found = read_file(vectors, options);
    require_same_grid(image_, key, found.grid, content_.grid);
    return std::move(found.pixels);
  }

  TomlReader& image_;
  const SceneText& file_;
  const Content& content_;
  std::optional<Extent> size_;
  bool is_physical_ = false;
};

} // namespace

void read_vector_images(TomlReader& image, const SceneText& file, std::optional<Extent> size,
                        Content& content, Scene& scene) {
  VectorImages images(image, file, size, content);
  const bool is_of_cells = scene.energy->is_of_cells();
  for (const std::string_view key : {"deviation", "precision", "force", "fibre", "normals"}) {
    image.refuse_unless(is_of_cells, key);
  }
  image.refuse_unless(!is_of_cells, "start");
  const std::string_view certainty = images.certainty();
  if (certainty == "precision") {
    content.precision = images.precision(scene.extent());
  } else if (!certainty.empty()) {
    FileConditions known{.target = images.target(),
                         .confidence = images.confidence(certainty == "deviation"),
                         .at = images.positions()};
    scene.observed = carry_conditions(known, is_of_cells, scene.full);
  }
  if (image.has("force")) {
    content.force = images.force(scene.extent());
  }
  if (image.has("fibre")) {
    content.fibre = images.fibre(scene.extent());
  }
  if (image.has("normals")) {
    content.normals = images.normals(scene.extent());
  }
  if (image.has("start")) {
    scene.start = images.start();
  }
}

} // namespace hdmbench
