#include "harness/ranks/ranked_sampling.hpp"

#include "harness/ranks/redistribution.hpp"
#include "kernels/data/mean_modulus.hpp"

#include <algorithm>
#include <cstring>
#include <span>
#include <utility>

namespace hdmbench {

namespace {

/// Rows `first` ... `end` - 1 of a level.
struct Rows {
  int first = 0;
  int end = 0;
};

/// The rows of a level for which `is_one` holds: all one after the other, or none.
template <typename Predicate>
Rows rows_where(int height, const Predicate& is_one) {
  Rows rows;
  while (rows.first < height && !is_one(rows.first)) {
    ++rows.first;
  }
  rows.end = rows.first;
  while (rows.end < height && is_one(rows.end)) {
    ++rows.end;
  }
  return rows;
}

/// Doubles go in two floats each.
Rectangle as_floats(Rows rows, int width) {
  return {.left = 0, .top = rows.first, .width = 2 * width, .height = rows.end - rows.first};
}

} // namespace

RankedSampling::RankedSampling(Exchange& exchange, std::size_t rank, Extent image,
                               const LevelShare& shared_image, Extent level, const LevelShare& shared_level,
                               Alignment alignment)
    : exchange_(exchange), rank_(rank), image_(image), shared_image_(shared_image), level_(level),
      shared_level_(shared_level), alignment_(alignment), sampler_(image, level, alignment) {
  std::ranges::transform(shared_image.owned, std::back_inserter(held_),
                         [this](const Rectangle& part) { return sampler_.sites(part); });
}

std::vector<float> RankedSampling::values(const std::vector<float>& image) const {
  return redistribute(exchange_, rank_, held_, shared_level_.loaded,
                      sampler_(image, shared_image_.loaded[rank_], shared_image_.owned[rank_]));
}

VectorField RankedSampling::operator()(const VectorField& image) const {
  VectorField result;
  result.extent = shared_level_.loaded[rank_].extent();
  result.x = values(image.x);
  result.y = values(image.y);
  return result;
}

Level RankedSampling::operator()(const Level& image, Material material) const {
  Level result = without_fields(image);
  result.extent = shared_level_.loaded[rank_].extent();
  const auto sample = [&](const ScalarField& field) {
    ScalarField sampled;
    sampled.extent = result.extent;
    sampled.values = values(field.values);
    return sampled;
  };
  result.target = (*this)(image.target);
  result.confidence = (*this)(image.confidence);
  if (material == Material::mean) {
    result.modulus.extent = result.extent;
    result.modulus.values = mean_moduli(image.modulus.values);
    set_inverse_modulus(result);
  } else {
    result.modulus = sample(image.modulus);
    result.inverse_modulus = sample(image.inverse_modulus);
  }
  for (const ScalarField& input : image.inputs) {
    result.inputs.push_back(sample(input));
  }
  return result;
}

/// What a row of the level stands for may be shared by several ranks, one below the other: each adds its own
/// rows to the sums of the one above and hands them down, the last one divides.
std::vector<float> RankedSampling::mean_moduli(const std::vector<float>& image) const {
  const MeanModulus mean(image_, level_, alignment_);
  const auto width = static_cast<std::size_t>(level_.width);
  const auto handed_down_to = [&](std::size_t rank) {
    const int top = shared_image_.owned[rank].top;
    return rows_where(level_.height,
                      [&](int y) { return mean.rows(y).first < top && mean.rows(y).last >= top; });
  };
  const auto finished_by = [&](std::size_t rank) {
    const Rectangle& owned = shared_image_.owned[rank];
    return rows_where(level_.height, [&](int y) {
      return mean.rows(y).last >= owned.top && mean.rows(y).last < owned.top + owned.height;
    });
  };
  const std::size_t pieces = shared_image_.cut.pieces.size();
  ScalarField means; // of the rows that are finished here
  if (rank_ < pieces) {
    const Rectangle& owned = shared_image_.owned[rank_];
    const Rectangle& loaded = shared_image_.loaded[rank_];
    std::vector<double> sums; // of rows that the rank above began
    const Rows begun = handed_down_to(rank_);
    if (begun.end > begun.first) {
      const Transfer way{rank_ - 1, rank_, as_floats(begun, level_.width)};
      const Parcel arrived = exchange_.exchange(std::span(&way, 1), {}, 1).front();
      sums.resize(static_cast<std::size_t>(begun.end - begun.first) * width);
      std::memcpy(sums.data(), arrived.values.data(), sums.size() * sizeof(double));
    }
    const Rows own = rows_where(level_.height, [&](int y) {
      return mean.rows(y).first < owned.top + owned.height && mean.rows(y).last >= owned.top;
    });
    sums.resize(static_cast<std::size_t>(own.end - own.first) * width);
    const auto sums_of = [&](int y) {
      return std::span(sums).subspan(static_cast<std::size_t>(y - own.first) * width, width);
    };
    for (int y = own.first; y < own.end; ++y) {
      const int end = std::min(mean.rows(y).last + 1, owned.top + owned.height);
      for (int row = std::max(mean.rows(y).first, owned.top); row < end; ++row) {
        mean.add(std::span(image).subspan(loaded.extent().index(0, row - loaded.top)), sums_of(y));
      }
    }
    const Rows left = rank_ + 1 < pieces ? handed_down_to(rank_ + 1) : Rows{};
    if (left.end > left.first) {
      const Transfer way{rank_, rank_ + 1, as_floats(left, level_.width)};
      Parcel parcel{.way = way, .values = std::vector<float>(way.sites.extent().sites())};
      std::memcpy(parcel.values.data(), sums_of(left.first).data(), parcel.values.size() * sizeof(float));
      std::vector<Parcel> leaving;
      leaving.push_back(std::move(parcel));
      (void)exchange_.exchange(std::span(&way, 1), std::move(leaving), 1);
    }
    const Rows finished = finished_by(rank_);
    means = ScalarField({level_.width, finished.end - finished.first});
    for (int y = finished.first; y < finished.end; ++y) {
      mean.divide(y, sums_of(y),
                  std::span(means.values).subspan(means.extent.index(0, y - finished.first), width));
    }
  }
  std::vector<Rectangle> held(shared_image_.owned.size());
  for (std::size_t rank = 0; rank < pieces; ++rank) {
    const Rows rows = finished_by(rank);
    if (rows.end > rows.first) {
      held[rank] = {.left = 0, .top = rows.first, .width = level_.width, .height = rows.end - rows.first};
    }
  }
  return redistribute(exchange_, rank_, held, shared_level_.loaded, means.values);
}

} // namespace hdmbench
