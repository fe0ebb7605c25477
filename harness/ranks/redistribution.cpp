#include "harness/ranks/redistribution.hpp"

#include <utility>

namespace hdmbench {

namespace {

/// Copies `part` of all arrays.
void copy_arrays(const Rectangle& part, int arrays, std::span<const float> from, const Rectangle& from_sites,
                 std::span<float> to, const Rectangle& to_sites) {
  for (std::size_t i = 0; i < static_cast<std::size_t>(arrays); ++i) {
    const auto array = [i](auto values, const Rectangle& sites) {
      return values.subspan(i * sites.extent().sites(), sites.extent().sites());
    };
    copy(part, array(from, from_sites), from_sites, array(to, to_sites), to_sites);
  }
}

} // namespace

std::vector<float> redistribute(Exchange& exchange, std::size_t rank, std::span<const Rectangle> held,
                                std::span<const Rectangle> wanted, std::span<const float> own, int arrays) {
  const auto room = [arrays](const Rectangle& sites) {
    return std::vector<float>(static_cast<std::size_t>(arrays) * sites.extent().sites());
  };
  const std::vector<Transfer> ways = transfers(held, wanted);
  std::vector<Parcel> leaving;
  for (const Transfer& way : ways) {
    if (way.from == rank) {
      Parcel& parcel = leaving.emplace_back(Parcel{.way = way, .values = room(way.sites)});
      copy_arrays(way.sites, arrays, own, held[rank], parcel.values, way.sites);
    }
  }
  std::vector<float> result = room(wanted[rank]);
  if (const Rectangle here = intersection(held[rank], wanted[rank]); here.extent().sites() > 0) {
    copy_arrays(here, arrays, own, held[rank], result, wanted[rank]);
  }
  for (const Parcel& parcel : exchange.exchange(ways, std::move(leaving), arrays)) {
    copy_arrays(parcel.way.sites, arrays, parcel.values, parcel.way.sites, result, wanted[rank]);
  }
  return result;
}

VectorField redistribute(Exchange& exchange, std::size_t rank, std::span<const Rectangle> held,
                         std::span<const Rectangle> wanted, const VectorField& own) {
  return field_of(redistribute(exchange, rank, held, wanted, one_after_the_other(own), 2),
                  wanted[rank].extent());
}

std::vector<float> one_after_the_other(const VectorField& field) {
  std::vector<float> values = field.x;
  values.insert(values.end(), field.y.begin(), field.y.end());
  return values;
}

VectorField field_of(std::span<const float> values, Extent extent) {
  VectorField field;
  field.extent = extent;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(extent.sites());
  field.x.assign(values.begin(), middle);
  field.y.assign(middle, values.end());
  return field;
}

} // namespace hdmbench
