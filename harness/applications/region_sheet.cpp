#include "harness/applications/detection.hpp"

#include "harness/solve/methods/elastic.hpp"
#include "kernels/data/input_error.hpp"

#include <fmt/format.h>

namespace hdmbench {

namespace {

constexpr int margin = 6;           // sites around the region that are looked at
constexpr float held_gently = 0.1F; // confidence of what is smoothed before it is prescribed
/// The same of label 0, which is not tissue: whatever moves it acts there, it is in no equilibrium.
constexpr float held_outside = 0.99F;

/// After full multigrid: what is left of the error is far below what noise does.
constexpr int gradient_steps = 3;

struct Strain {
  double xx, yy, xy; ///< xy is the engineering shear
};

/// Of a field in the cell of which `corner` is the top left site, at (r, s) in [0, 1] x [0, 1].
Strain strain_at(const VectorField& field, std::size_t corner, double r, double s) {
  const auto width = static_cast<std::size_t>(field.extent.width);
  const auto slopes = [&](const std::vector<float>& values) {
    const double top = static_cast<double>(values[corner + 1]) - static_cast<double>(values[corner]);
    const double bottom =
        static_cast<double>(values[corner + width + 1]) - static_cast<double>(values[corner + width]);
    const double left = static_cast<double>(values[corner + width]) - static_cast<double>(values[corner]);
    const double right =
        static_cast<double>(values[corner + width + 1]) - static_cast<double>(values[corner + 1]);
    return std::array{std::lerp(top, bottom, s), std::lerp(left, right, r)};
  };
  const auto [xx, xy] = slopes(field[0]);
  const auto [yx, yy] = slopes(field[1]);
  return {xx, yy, xy + yx};
}

/// Of plane stress for a modulus of 1, per area.
double twice_energy(const Strain& a, const Strain& b, double poisson) {
  return (a.xx * b.xx + a.yy * b.yy + poisson * (a.xx * b.yy + a.yy * b.xx)) / (1.0 - poisson * poisson) +
         a.xy * b.xy / (2.0 * (1.0 + poisson));
}

/// What the modulus of a site weighs: the quadrature points of finite elements that lie in its pixel.
double energy_of_site(const VectorField& a, const VectorField& b, int x, int y, double poisson) {
  const Extent extent = a.extent;
  const double near = 0.5 - 0.5 / std::sqrt(3.0); // of a Gauss point from its corner
  double sum = 0.0;
  for (int below = 0; below < 2; ++below) {
    for (int right = 0; right < 2; ++right) {
      const int column = x - 1 + right;
      const int row = y - 1 + below;
      if (column >= 0 && row >= 0 && column + 1 < extent.width && row + 1 < extent.height) {
        const double r = right == 1 ? near : 1.0 - near;
        const double s = below == 1 ? near : 1.0 - near;
        const std::size_t corner = extent.index(column, row);
        sum += 0.25 * twice_energy(strain_at(a, corner, r, s), strain_at(b, corner, r, s), poisson);
      }
    }
  }
  return sum;
}

VectorField solved(ElasticSolver& solver) {
  solver.full_multigrid();
  for (int step = 0; step < gradient_steps && !solver.conjugate_gradients().ended; ++step) {
  }
  return solver.displacement();
}

} // namespace

VectorField difference_at(const std::vector<std::size_t>& sites, const VectorField& a, const VectorField& b) {
  VectorField difference(a.extent);
  for (std::size_t axis = 0; axis < a.extent.axes(); ++axis) {
    for (const std::size_t site : sites) {
      difference[axis][site] = a[axis][site] - b[axis][site];
    }
  }
  return difference;
}

ModulusProblem::ModulusProblem(const Level& level, double poisson, const std::vector<std::size_t>& unknown,
                               ElasticSession& session)
    : level_(level), poisson_(poisson), unknown_(unknown), session_(session) {
  for (const std::size_t site : unknown) {
    labelled_.push_back(level.modulus.values[site]);
  }
}

VectorField ModulusProblem::displacement(std::span<const double> logarithms) {
  for (std::size_t i = 0; i < unknown_.size(); ++i) {
    level_.modulus.values[unknown_[i]] = labelled_[i] * static_cast<float>(std::exp(logarithms[i]));
  }
  ElasticSolver solver(level_, poisson_, session_);
  return solved(solver);
}

void ModulusProblem::slopes(const VectorField& found, const VectorField& difference,
                            std::span<double> derivative) {
  const SiteSprings none;
  ElasticSolver solver(level_, poisson_, none, session_);
  solver.pull(VectorField(level_.extent), difference);
  const VectorField adjoint = solved(solver);
  for (std::size_t i = 0; i < unknown_.size(); ++i) {
    const auto width = static_cast<std::size_t>(level_.extent.width);
    const int x = static_cast<int>(unknown_[i] % width);
    const int y = static_cast<int>(unknown_[i] / width);
    derivative[i] = -static_cast<double>(level_.modulus.values[unknown_[i]]) *
                    energy_of_site(adjoint, found, x, y, poisson_);
  }
}

double ModulusProblem::misfit(std::span<const double> logarithms, const VectorField& observed,
                              std::span<double> derivative) {
  const VectorField found = displacement(logarithms);
  const VectorField difference = difference_at(unknown_, found, observed);
  slopes(found, difference, derivative);
  return 0.5 * product(difference, difference);
}

RegionSheet::RegionSheet(const ScalarField& region, const Scene& scene, ElasticSession& session)
    : poisson_(scene.elastic.poisson), image_(scene.extent()), session_(session) {
  require_conditions_alone(scene.full, "detection");
  if (region.extent != image_) {
    throw InputError(
        fmt::format("detection: the scene is {} pixels, the region {}", image_.text(), region.extent.text()));
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
    throw InputError(fmt::format("detection: the scene is {} pixels, the displacement {}", image_.text(),
                                 of_image.extent.text()));
  }
  VectorField part(extent());
  for (std::size_t axis = 0; axis < image_.axes(); ++axis) {
    for (std::size_t site = 0; site < extent().sites(); ++site) {
      part[axis][site] = of_image[axis][site_of_image(site)];
    }
  }
  return part;
}

void RegionSheet::put_back(const VectorField& part, VectorField& of_image) const {
  for (std::size_t axis = 0; axis < image_.axes(); ++axis) {
    for (std::size_t site = 0; site < extent().sites(); ++site) {
      of_image[axis][site_of_image(site)] = part[axis][site];
    }
  }
}

float RegionSheet::gentle_hold(std::size_t site) const {
  return labels_[site] == 0 ? held_outside : held_gently;
}

Level RegionSheet::with_border(const VectorField& observed) const {
  Level level = sheet_;
  level.target = observed;
  for (std::size_t site = 0; site < extent().sites(); ++site) {
    level.confidence[0][site] = level.confidence[1][site] = gentle_hold(site);
  }
  ElasticSolver solver(level, poisson_, session_);
  solver.full_multigrid();
  level.target = solver.displacement();
  for (std::size_t site = 0; site < extent().sites(); ++site) {
    const float known = index_[site] < 0 ? 1.0F : 0.0F;
    level.confidence[0][site] = known;
    level.confidence[1][site] = known;
  }
  return level;
}

void RegionSheet::loosen(Level& level) const {
  for_each_site(extent(), [&](int x, int y) {
    const std::size_t site = extent().index(x, y);
    const bool is_rim = x == 0 || y == 0 || x == extent().width - 1 || y == extent().height - 1;
    if (index_[site] < 0 && !is_rim) {
      level.confidence[0][site] = level.confidence[1][site] = gentle_hold(site);
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
    sum += std::pow(static_cast<double>(a[0][site]) - static_cast<double>(b[0][site]), 2) +
           std::pow(static_cast<double>(a[1][site]) - static_cast<double>(b[1][site]), 2);
  }
  return std::sqrt(sum / static_cast<double>(inside_.size()));
}

} // namespace hdmbench
