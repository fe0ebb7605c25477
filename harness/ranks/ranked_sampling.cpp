#include "harness/ranks/ranked_sampling.hpp"

#include "harness/ranks/redistribution.hpp"
#include "kernels/data/modulus.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <span>
#include <utility>

namespace hdmbench {

namespace {

/// Rows `first` ... `end` - 1 of a level.
struct Rows {
  int first = 0;
  int end = 0;

  [[nodiscard]] int count() const { return end - first; }
};

/// Which rows of a level a rank has to do with, by the rows of the image that they stand for.
class RowsByRank {
public:
  RowsByRank(const MeanModulus& mean, int height, std::span<const Rectangle> owned)
      : mean_(mean), height_(height), owned_(owned) {}

  /// Some of whose rows are the rank's.
  [[nodiscard]] Rows touched(std::size_t rank) const {
    return rows([&](int first, int last) { return first < bottom(rank) && last >= owned_[rank].top; });
  }
  /// That the rank above began and this one goes on with.
  [[nodiscard]] Rows handed_down(std::size_t rank) const {
    return rows([&](int first, int last) { return first < owned_[rank].top && last >= owned_[rank].top; });
  }
  /// Whose last row is the rank's.
  [[nodiscard]] Rows finished(std::size_t rank) const {
    return rows([&](int /*first*/, int last) { return last >= owned_[rank].top && last < bottom(rank); });
  }

private:
  [[nodiscard]] int bottom(std::size_t rank) const { return owned_[rank].top + owned_[rank].height; }

  /// They follow each other.
  template <typename Predicate>
  [[nodiscard]] Rows rows(const Predicate& is_one) const {
    const auto is_row = [&](int y) { return is_one(mean_.rows(y).first, mean_.rows(y).last); };
    Rows found;
    while (found.first < height_ && !is_row(found.first)) {
      ++found.first;
    }
    found.end = found.first;
    while (found.end < height_ && is_row(found.end)) {
      ++found.end;
    }
    return found;
  }

  const MeanModulus& mean_;
  int height_;
  std::span<const Rectangle> owned_;
};

/// A parcel of sums, a double in two floats.
Transfer way_of_sums(std::size_t from, std::size_t to, Rows rows, int width) {
  return {.from = from,
          .to = to,
          .sites = {.left = 0, .top = rows.first, .width = 2 * width, .height = rows.count()}};
}

} // namespace

RankedSampling::RankedSampling(Exchange& sites, Exchange& sums, std::size_t rank, Extent image,
                               const LevelShare& shared_image, Extent level, const LevelShare& shared_level,
                               Alignment alignment)
    : sites_(sites), sums_(sums), rank_(rank), image_(image), shared_image_(shared_image), level_(level),
      shared_level_(shared_level), alignment_(alignment), sampler_(image, level, alignment) {
  std::ranges::transform(shared_image.owned, std::back_inserter(held_),
                         [this](const Rectangle& part) { return sampler_.sites(part); });
}

std::vector<std::vector<float>>
RankedSampling::values(std::span<const std::vector<float>* const> images) const {
  std::vector<HeldValues> held;
  for (const std::vector<float>* image : images) {
    held.emplace_back([this, image](const Rectangle& part, std::span<float> to, const Rectangle& to_sites) {
      sampler_(part, *image, shared_image_.loaded[rank_], to, to_sites);
    });
  }
  return redistribute(sites_, rank_, held_, shared_level_.loaded, held);
}

VectorField RankedSampling::operator()(const VectorField& image) const {
  std::vector<std::vector<float>> both = values(std::array{&image.x, &image.y});
  VectorField result;
  result.extent = shared_level_.loaded[rank_].extent();
  result.x = std::move(both[0]);
  result.y = std::move(both[1]);
  return result;
}

Level RankedSampling::operator()(const Level& image, Material material) const {
  Level result = without_fields(image);
  result.extent = shared_level_.loaded[rank_].extent();
  result.inputs.resize(image.inputs.size());
  std::vector<const std::vector<float>*> from{&image.target.x, &image.target.y, &image.confidence.x,
                                              &image.confidence.y};
  std::vector<std::vector<float>*> to{&result.target.x, &result.target.y, &result.confidence.x,
                                      &result.confidence.y};
  const auto sample = [&](const ScalarField& field, ScalarField& sampled) {
    sampled.extent = result.extent;
    from.push_back(&field.values);
    to.push_back(&sampled.values);
  };
  result.target.extent = result.extent;
  result.confidence.extent = result.extent;
  if (material == Material::nearest) {
    sample(image.modulus, result.modulus);
    sample(image.inverse_modulus, result.inverse_modulus);
  }
  for (std::size_t i = 0; i < image.inputs.size(); ++i) {
    sample(image.inputs[i], result.inputs[i]);
  }
  std::vector<std::vector<float>> sampled = values(from);
  for (std::size_t i = 0; i < sampled.size(); ++i) {
    *to[i] = std::move(sampled[i]);
  }
  if (material == Material::mean) {
    result.modulus.extent = result.extent;
    result.modulus.values = mean_moduli(image.modulus.values);
    set_inverse_modulus(result);
  }
  return result;
}

/// What a row of the level stands for may be shared by several ranks, one below the other: each adds its own
/// rows to the sums of the one above and hands them down, the last one divides.
std::vector<float> RankedSampling::mean_moduli(const std::vector<float>& image) const {
  const MeanModulus mean(image_, level_, alignment_);
  const RowsByRank rows(mean, level_.height, shared_image_.owned);
  const std::size_t pieces = shared_image_.cut.pieces.size();
  std::vector<Rectangle> held(shared_image_.owned.size()); // of the level, what a rank finishes
  for (std::size_t rank = 0; rank < pieces; ++rank) {
    if (const Rows finished = rows.finished(rank); finished.count() > 0) {
      held[rank] = {.left = 0, .top = finished.first, .width = level_.width, .height = finished.count()};
    }
  }
  std::vector<float> means(held[rank_].extent().sites());
  if (rank_ < pieces) {
    const auto width = static_cast<std::size_t>(level_.width);
    const Rows touched = rows.touched(rank_);
    std::vector<double> sums(static_cast<std::size_t>(touched.count()) * width);
    const auto of_row = [&](int y) {
      return std::span(sums).subspan(static_cast<std::size_t>(y - touched.first) * width, width);
    };
    if (const Rows begun = rows.handed_down(rank_); begun.count() > 0) {
      const Transfer way = way_of_sums(rank_ - 1, rank_, begun, level_.width);
      const Parcel arrived = sums_.exchange(std::span(&way, 1), {}, 1).front();
      std::memcpy(of_row(begun.first).data(), arrived.values.data(), arrived.values.size() * sizeof(float));
    }
    const Rectangle& owned = shared_image_.owned[rank_];
    const Rectangle& loaded = shared_image_.loaded[rank_];
    for (int y = touched.first; y < touched.end; ++y) {
      const int end = std::min(mean.rows(y).last + 1, owned.top + owned.height);
      for (int row = std::max(mean.rows(y).first, owned.top); row < end; ++row) {
        mean.add(std::span(image).subspan(loaded.extent().index(0, row - loaded.top)), of_row(y));
      }
    }
    if (const Rows left = rank_ + 1 < pieces ? rows.handed_down(rank_ + 1) : Rows{}; left.count() > 0) {
      const Transfer way = way_of_sums(rank_, rank_ + 1, left, level_.width);
      std::vector<Parcel> leaving(1, {.way = way, .values = std::vector<float>(way.sites.extent().sites())});
      std::vector<float>& values = leaving.front().values;
      std::memcpy(values.data(), of_row(left.first).data(), values.size() * sizeof(float));
      (void)sums_.exchange(std::span(&way, 1), std::move(leaving), 1);
    }
    for (int y = held[rank_].top; y < held[rank_].top + held[rank_].height; ++y) {
      mean.divide(y, of_row(y),
                  std::span(means).subspan(static_cast<std::size_t>(y - held[rank_].top) * width, width));
    }
  }
  return redistribute(sites_, rank_, held, shared_level_.loaded, means);
}

} // namespace hdmbench
