#include "harness/ranks/redistribution.hpp"

#include <utility>

namespace hdmbench {

namespace {

using Arrays = std::vector<std::span<const float>>;

std::vector<std::vector<float>> redistribute_all(Exchange& exchange, std::size_t rank,
                                                 std::span<const Rectangle> held,
                                                 std::span<const Rectangle> wanted, const Arrays& own) {
  const std::vector<Transfer> ways = transfers(held, wanted);
  std::vector<Parcel> leaving;
  for (const Transfer& way : ways) {
    if (way.from == rank) {
      const std::size_t sites = way.sites.extent().sites();
      Parcel& parcel = leaving.emplace_back(Parcel{way, std::vector<float>(own.size() * sites)});
      for (std::size_t i = 0; i < own.size(); ++i) {
        copy(way.sites, own[i], held[rank], std::span(parcel.values).subspan(i * sites, sites), way.sites);
      }
    }
  }
  const std::vector<Parcel> arrived =
      exchange.exchange(ways, std::move(leaving), static_cast<int>(own.size()));
  std::vector<std::vector<float>> results;
  for (std::size_t i = 0; i < own.size(); ++i) {
    std::vector<float>& result = results.emplace_back(wanted[rank].extent().sites());
    copy(intersection(held[rank], wanted[rank]), own[i], held[rank], result, wanted[rank]);
    for (const Parcel& parcel : arrived) {
      const std::size_t sites = parcel.way.sites.extent().sites();
      copy(parcel.way.sites, std::span(parcel.values).subspan(i * sites, sites), parcel.way.sites, result,
           wanted[rank]);
    }
  }
  return results;
}

} // namespace

std::vector<float> redistribute(Exchange& exchange, std::size_t rank, std::span<const Rectangle> held,
                                std::span<const Rectangle> wanted, std::span<const float> own) {
  return std::move(redistribute_all(exchange, rank, held, wanted, {own}).front());
}

VectorField redistribute(Exchange& exchange, std::size_t rank, std::span<const Rectangle> held,
                         std::span<const Rectangle> wanted, const VectorField& own) {
  std::vector<std::vector<float>> both = redistribute_all(exchange, rank, held, wanted, {own.x, own.y});
  VectorField result;
  result.extent = wanted[rank].extent();
  result.x = std::move(both[0]);
  result.y = std::move(both[1]);
  return result;
}

} // namespace hdmbench
