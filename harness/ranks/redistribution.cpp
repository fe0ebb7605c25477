#include "harness/ranks/redistribution.hpp"

namespace hdmbench {

std::vector<float> redistribute(Exchange& exchange, std::size_t rank, std::span<const Rectangle> held,
                                std::span<const Rectangle> wanted, std::span<const float> own) {
  const std::vector<Transfer> ways = transfers(held, wanted);
  std::vector<Parcel> leaving;
  for (const Transfer& way : ways) {
    if (way.from == rank) {
      Parcel& parcel = leaving.emplace_back(Parcel{way, std::vector<float>(way.sites.extent().sites())});
      copy(way.sites, own, held[rank], parcel.values, way.sites);
    }
  }
  const std::vector<Parcel> arrived = exchange.exchange(ways, std::move(leaving), 1);
  std::vector<float> result(wanted[rank].extent().sites());
  copy(intersection(held[rank], wanted[rank]), own, held[rank], result, wanted[rank]);
  for (const Parcel& parcel : arrived) {
    copy(parcel.way.sites, parcel.values, parcel.way.sites, result, wanted[rank]);
  }
  return result;
}

VectorField redistribute(Exchange& exchange, std::size_t rank, std::span<const Rectangle> held,
                         std::span<const Rectangle> wanted, const VectorField& own) {
  VectorField result;
  result.extent = wanted[rank].extent();
  result.x = redistribute(exchange, rank, held, wanted, own.x);
  result.y = redistribute(exchange, rank, held, wanted, own.y);
  return result;
}

} // namespace hdmbench
