#include "harness/applications/region_sheet.hpp"

#include "harness/applications/modulus_problem.hpp"
#include "harness/scene/sites.hpp"
#include "harness/solve/methods/elastic.hpp"
#include "kernels/data/input_error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace hdmbench {

namespace {

constexpr int margin = 6;           // sites around the region that are looked at
constexpr float held_gently = 0.1F; // confidence of what is smoothed before it is prescribed
/// The same of label 0, which is not tissue: whatever moves it acts there, it is in no equilibrium.
constexpr float held_outside = 0.99F;

} // namespace

RegionSheet::RegionSheet(const ScalarField& region, const Scene& scene, ElasticSession& session)
    : poisson_(scene.poisson), image_(scene.extent()), session_(session) {
  if (region.extent != image_) {
    throw InputError(fmt::format("detection: the scene is {} x {} pixels, the region {} x {}", image_.width,
                                 image_.height, region.extent.width, region.extent.height));
  }
  int right = -1;
  int bottom = -1;
  left_ = image_.width;
  top_ = image_.height;
  for_each_site(image_, [&](int x, int y) {
    if (region.values[image_.index(x, y)] != 0.0F) {
      left_ = std::clamp(x - margin, 0, left_);
      right = std::clamp(x + margin, right, image_.width - 1);
      top_ = std::clamp(y - margin, 0, top_);
      bottom = std::clamp(y + margin, bottom, image_.height - 1);
    }
  });
  if (right < 0) {
    throw InputError("detection: the region of interest is empty, no pixel of the mask is above 0");
  }
  const Extent extent{right - left_ + 1, bottom - top_ + 1};
  sheet_.extent = extent;
  sheet_.modulus = ScalarField(extent);
  sheet_.target = VectorField(extent);
  sheet_.confidence = VectorField(extent);
  labels_.resize(extent.sites());
  index_.assign(extent.sites(), -1);
  for (std::size_t site = 0; site < extent.sites(); ++site) {
    const std::size_t from = site_of_image(site);
    sheet_.modulus.values[site] = scene.full.modulus.values[from];
    labels_[site] = scene.labels.values.empty() ? 0 : scene.labels.values[from];
    if (region.values[from] != 0.0F) {
      index_[site] = static_cast<int>(inside_.size());
      inside_.push_back(site);
    }
  }
  if (inside_.size() == extent.sites()) {
    throw InputError(
        "detection: the region of interest is the whole image; something around it must be known");
  }
}

std::size_t RegionSheet::site_of_image(std::size_t site) const {
  const auto width = static_cast<std::size_t>(sheet_.extent.width);
  return image_.index(left_ + static_cast<int>(site % width), top_ + static_cast<int>(site / width));
}

VectorField RegionSheet::part_of(const VectorField& of_image) const {
  if (of_image.extent != image_) {
    throw InputError(fmt::format("detection: the scene is {} x {} pixels, the displacement {} x {}",
                                 image_.width, image_.height, of_image.extent.width, of_image.extent.height));
  }
  VectorField part(extent());
  for (std::size_t site = 0; site < extent().sites(); ++site) {
    part.x[site] = of_image.x[site_of_image(site)];
    part.y[site] = of_image.y[site_of_image(site)];
  }
  return part;
}

void RegionSheet::put_back(const VectorField& part, VectorField& of_image) const {
  for (std::size_t site = 0; site < extent().sites(); ++site) {
    of_image.x[site_of_image(site)] = part.x[site];
    of_image.y[site_of_image(site)] = part.y[site];
  }
}

float RegionSheet::gentle_hold(std::size_t site) const {
  return labels_[site] == 0 ? held_outside : held_gently;
}

Level RegionSheet::with_border(const VectorField& observed) const {
  Level level = sheet_;
  level.target = observed;
  for (std::size_t site = 0; site < extent().sites(); ++site) {
    level.confidence.x[site] = level.confidence.y[site] = gentle_hold(site);
  }
  ElasticSolver solver(level, poisson_, session_);
  solver.full_multigrid();
  level.target = solver.displacement();
  for (std::size_t site = 0; site < extent().sites(); ++site) {
    const float known = index_[site] < 0 ? 1.0F : 0.0F;
    level.confidence.x[site] = known;
    level.confidence.y[site] = known;
  }
  return level;
}

void RegionSheet::loosen(Level& level) const {
  for_each_site(extent(), [&](int x, int y) {
    const std::size_t site = extent().index(x, y);
    const bool is_rim = x == 0 || y == 0 || x == extent().width - 1 || y == extent().height - 1;
    if (index_[site] < 0 && !is_rim) {
      level.confidence.x[site] = level.confidence.y[site] = gentle_hold(site);
    }
  });
}

VectorField RegionSheet::displacement(const Level& level, double poisson,
                                      std::vector<double> logarithms) const {
  logarithms.resize(inside_.size());
  return ModulusProblem(level, poisson, inside_, session_).displacement(logarithms);
}

double RegionSheet::distance(const VectorField& a, const VectorField& b) const {
  double sum = 0.0;
  for (const std::size_t site : inside_) {
    sum += std::pow(static_cast<double>(a.x[site]) - static_cast<double>(b.x[site]), 2) +
           std::pow(static_cast<double>(a.y[site]) - static_cast<double>(b.y[site]), 2);
  }
  return std::sqrt(sum / static_cast<double>(inside_.size()));
}

} // namespace hdmbench
