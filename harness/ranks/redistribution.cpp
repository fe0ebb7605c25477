#include "harness/ranks/redistribution.hpp"

#include <array>
#include <utility>

namespace hdmbench {

namespace {

HeldValues held_values(std::span<const float> values, const Rectangle& held) {
  return [values, held](const Rectangle& part, std::span<float> to, const Rectangle& to_sites) {
    copy(part, values, held, to, to_sites);
  };
}

} // namespace

std::vector<std::vector<float>> redistribute(Exchange& exchange, std::size_t rank,
                                             std::span<const Rectangle> held,
                                             std::span<const Rectangle> wanted,
                                             std::span<const HeldValues> own) {
  const std::vector<Transfer> ways = transfers(held, wanted);
  std::vector<Parcel> leaving;
  for (const Transfer& way : ways) {
    if (way.from == rank) {
      const std::size_t sites = way.sites.extent().sites();
      Parcel& parcel = leaving.emplace_back(Parcel{way, std::vector<float>(own.size() * sites)});
      for (std::size_t i = 0; i < own.size(); ++i) {
        own[i](way.sites, std::span(parcel.values).subspan(i * sites, sites), way.sites);
      }
    }
  }
  const std::vector<Parcel> arrived =
      exchange.exchange(ways, std::move(leaving), static_cast<int>(own.size()));
  std::vector<std::vector<float>> results;
  for (std::size_t i = 0; i < own.size(); ++i) {
    std::vector<float>& result = results.emplace_back(wanted[rank].extent().sites());
    if (const Rectangle here = intersection(held[rank], wanted[rank]); here.extent().sites() > 0) {
      own[i](here, result, wanted[rank]);
    }
    for (const Parcel& parcel : arrived) {
      const std::size_t sites = parcel.way.sites.extent().sites();
      copy(parcel.way.sites, std::span(parcel.values).subspan(i * sites, sites), parcel.way.sites, result,
           wanted[rank]);
    }
  }
  return results;
}

std::vector<float> redistribute(Exchange& exchange, std::size_t rank, std::span<const Rectangle> held,
                                std::span<const Rectangle> wanted, std::span<const float> own) {
  const HeldValues values = held_values(own, held[rank]);
  return std::move(redistribute(exchange, rank, held, wanted, std::span(&values, 1)).front());
}

VectorField redistribute(Exchange& exchange, std::size_t rank, std::span<const Rectangle> held,
                         std::span<const Rectangle> wanted, const VectorField& own) {
  const std::array values{held_values(own.x, held[rank]), held_values(own.y, held[rank])};
  std::vector<std::vector<float>> both = redistribute(exchange, rank, held, wanted, values);
  VectorField result;
  result.extent = wanted[rank].extent();
  result.x = std::move(both[0]);
  result.y = std::move(both[1]);
  return result;
}

} // namespace hdmbench
