#include "harness/ranks/rank_faults.hpp"

#include "harness/check/compare.hpp"
#include "harness/ranks/rank_backend.hpp"
#include "harness/scene/method.hpp"
#include "harness/scene/sites.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <numeric>
#include <tuple>

namespace hdmbench::faults {

namespace {

/// `sites` without the slice, row or column that is farthest from `from`, on one side of it.
Box without_farthest(Box sites, const Box& from) {
  for (std::size_t axis = 3; axis-- > 0;) {
    const bool is_before = sites.end[axis] <= from.first[axis];
    if (is_before || sites.first[axis] >= from.end[axis]) {
      (is_before ? sites.first : sites.end)[axis] += is_before ? 1 : -1;
      return sites;
    }
  }
  return sites;
}

/// What goes wrong first of a halo is not brought.
void shorten(std::vector<Message>& arrived, std::span<const Transfer> ways) {
  for (Message& message : arrived) {
    const Transfer& way = message.way;
    const auto back = std::ranges::find_if(
        ways, [&](const Transfer& other) { return other.from == way.to && other.to == way.from; });
    if (back == ways.end()) { // no halo, but a level on its way to or from the first rank
      continue;
    }
    const Box kept = without_farthest(way.sites, back->sites);
    const std::size_t whole = way.sites.extent().sites();
    const std::size_t part = kept.extent().sites();
    const std::size_t arrays = message.values.size() / whole;
    Message shorter{.way = {way.from, way.to, kept}, .values = std::vector<float>(arrays * part)};
    for (std::size_t i = 0; i < arrays; ++i) {
      copy(kept, std::span(message.values).subspan(i * whole, whole), way.sites,
           std::span(shorter.values).subspan(i * part, part), kept);
    }
    message = std::move(shorter);
  }
}

/// What the exchange before brought; at first what is right.
class Stale {
public:
  void operator()(std::vector<Message>& arrived, std::span<const Transfer> /*ways*/) {
    for (Message& message : arrived) {
      auto& before = before_[{message.way.from, message.way.sites}];
      const std::vector<float> now = message.values;
      message.values = before.empty() ? now : before;
      before = now;
    }
  }

private:
  std::map<std::pair<std::size_t, Box>, std::vector<float>> before_;
};

/// Two neighbours change places.
void swap_neighbours(std::vector<Message>& arrived, std::span<const Transfer> /*ways*/) {
  if (arrived.size() < 2) {
    return;
  }
  const auto take = [](std::vector<float>& to, const std::vector<float>& from) {
    for (std::size_t i = 0; i < to.size(); ++i) {
      to[i] = from[i % from.size()];
    }
  };
  const std::vector<float> first = arrived[0].values;
  take(arrived[0].values, arrived[1].values);
  take(arrived[1].values, first);
}

/// Each rank's own sum, then the sum of these; not the tree.
void add_up(std::vector<Message>& arrived) {
  for (Message& message : arrived) {
    const float sum = std::accumulate(message.values.begin(), message.values.end(), 0.0F);
    std::ranges::fill(message.values, 0.0F);
    message.values.front() = sum;
  }
}

/// The first moment, which is their mean modulus, by the last digit.
void stiffen_cells(std::vector<Message>& arrived) {
  for (Message& message : arrived) {
    const auto sites = static_cast<std::ptrdiff_t>(message.way.sites.extent().sites());
    std::for_each(message.values.begin(), message.values.begin() + sites,
                  [](float& value) { value = std::nextafter(value, 2.0F * value); });
  }
}

/// A tile of 16 x 16 at rest is not woken by a halo that is renewed in it.
Fault unwoken_tiles() {
  const auto tiles = std::make_shared<RestingTiles>();
  return {.in_level = [tiles](Level& level) { tiles->begin_level(level.extent); },
          .in_sweep =
              [tiles](VectorField& after, const VectorField& before) {
                for_each_site(after.extent, [&](int x, int y) {
                  if (tiles->rests(x, y)) {
                    const std::size_t site = after.extent.index(x, y);
                    after[0][site] = before[0][site];
                    after[1][site] = before[1][site];
                  }
                });
                (void)tiles->sweep(before, after);
              }};
}

/// The same of the elastic energy.
RankFault elastic(RankFault fault) {
  fault.name = "elastic-" + fault.name;
  fault.method = elastic_conjugate_gradients;
  return fault;
}

std::vector<RankFault> rank_faults() {
  const std::vector<RankFault> in_halos{
      {.name = "halo-one-row-short",
       .what = "the row of a halo that goes wrong first is not brought",
       .in_halos = shorten},
      {.name = "stale-halo", .what = "a halo is that of the exchange before", .in_halos = Stale()},
      {.name = "swapped-neighbours",
       .what = "the halos of two neighbours have changed places",
       .ranks = 3,
       .in_halos = swap_neighbours}};
  std::vector<RankFault> all = in_halos;
  all.push_back(
      {.name = "other-penalty",
       .what = "the second rank has another K",
       .in_level = [](Level& level, std::size_t rank) { level.penalty *= rank == 1 ? 2.0F : 1.0F; }});
  all.push_back({.name = "count-of-a-rank-missing",
                 .what = "the second rank's changed sites are not counted",
                 .in_count = [](std::int64_t count, std::size_t rank) { return rank == 1 ? 0 : count; }});
  all.push_back({.name = "asleep-after-renewal",
                 .what = "active: a tile that sleeps is not woken by a halo that is renewed in it",
                 .in_active_session = unwoken_tiles(),
                 .part = Part::sleep});
  std::ranges::transform(in_halos, std::back_inserter(all), elastic);
  // Cycles renew a halo while a row of it is left; sweeps without springs use it up. Where several levels are
  // cut it is so wide on the image that a mistake on its rim rounds away.
  RankFault& one_row_short = all.at(all.size() - in_halos.size());
  one_row_short.method = elastic_sweeps;
  one_row_short.fewest_sites = 300;
  all.push_back(elastic({.name = "other-modulus",
                         .what = "the second rank's tissue is stiffer by the last digit",
                         .in_sheet = [](ElasticHierarchy& sheet, std::size_t rank) {
                           for (ElasticLevel& level : sheet.levels) {
                             for (std::vector<float>& moment : level.moments) {
                               std::ranges::transform(moment, moment.begin(), [rank](float value) {
                                 return rank == 1 ? std::nextafter(value, 2.0F * value) : value;
                               });
                             }
                           }
                         }}));
  all.push_back(elastic({.name = "other-cells-of-coarse-levels",
                         .what = "the cells that the first rank gets for coarse levels are stiffer",
                         .in_cells = stiffen_cells}));
  all.push_back(elastic({.name = "sum-in-rank-order",
                         .what = "a dot product is the sum of each rank's own sum",
                         .in_sums = add_up}));
  all.push_back(
      {.name = "annealing-other-first-row",
       .what = "the second rank's random numbers are those of other rows",
       .in_level = [](Level& level,
                      std::size_t rank) { level.seed = seed_from_row(level.seed, rank == 1 ? 1 : 0); },
       .method = "annealing"});
  return all;
}

} // namespace

std::vector<Message> FaultyExchange::exchange(std::span<const Transfer> ways, std::vector<Message> leaving,
                                              int arrays, Purpose purpose) {
  std::vector<Message> arrived = sound_.exchange(ways, std::move(leaving), arrays, purpose);
  if (purpose == Purpose::sums && fault_.in_sums) {
    fault_.in_sums(arrived);
  } else if (purpose == Purpose::cells && fault_.in_cells) {
    fault_.in_cells(arrived);
  } else if (purpose == Purpose::halos && fault_.in_halos) {
    fault_.in_halos(arrived, ways);
  }
  return arrived;
}

std::int64_t FaultyExchange::sum(std::int64_t own) {
  return sound_.sum(fault_.in_count ? fault_.in_count(own, static_cast<std::size_t>(rank())) : own);
}

std::unique_ptr<Session> spoilt(std::unique_ptr<Session> sound, const RankFault& fault, int rank, Work work) {
  Fault own;
  if (fault.in_active_session && work == Work::active) {
    own = *fault.in_active_session;
  } else if (!fault.in_level) {
    return sound;
  }
  if (fault.in_level) {
    own.in_level = [in_level = fault.in_level, rank](Level& level) {
      in_level(level, static_cast<std::size_t>(rank));
    };
  }
  return spoilt(std::move(sound), std::move(own));
}

std::unique_ptr<ElasticSession> spoilt(std::unique_ptr<ElasticSession> sound, const RankFault& fault,
                                       int rank) {
  if (!fault.in_sheet) {
    return sound;
  }
  Fault own;
  own.in_hierarchy = [in_sheet = fault.in_sheet, rank](ElasticHierarchy& hierarchy) {
    in_sheet(hierarchy, static_cast<std::size_t>(rank));
  };
  return spoilt(std::move(sound), std::move(own));
}

std::vector<Planted> planted_on_ranks(Ranks& ranks, const std::vector<std::unique_ptr<Backend>>& registry,
                                      const std::string& backends) {
  const bool on_cpu = backend_of_rank(registry, backends, 0).threads({}) > 0;
  const auto planted = [&](const RankFault& fault, Expected expected) {
    // As small as a piece can be, so that small scenes are cut, too; and halos as narrow.
    const Sharing sharing{.pieces = ranks.size(),
                          .fewest_sites = fault.fewest_sites,
                          .halo = energy_of(find_method(fault.method)).is_of_cells() ? 2 : 0};
    return Planted{.name = fault.name,
                   .what = fault.what,
                   .backend = backends,
                   .layer = Layer::ranks,
                   .expected = expected,
                   .method = fault.method,
                   .bitwise = on_cpu,
                   .part = fault.part,
                   .make = [&ranks, &registry, backends, sharing, fault] {
                     return std::make_unique<RankBackend>(ranks, registry, backends, SessionOptions{},
                                                          sharing, fault);
                   }};
  };
  const RankFault none{.name = "sound", .what = "no mistake"};
  std::vector<Planted> list{planted(none, Expected::let_through),
                            planted(elastic(none), Expected::let_through)};
  for (const auto& [name, method, part] : {std::tuple{"sleeping-sound", "icm", Part::sleep},
                                           std::tuple{"annealing-sound", "annealing", Part::sweep},
                                           std::tuple{"cascade-sound", "cascade", Part::sweep}}) {
    list.push_back(
        planted({.name = name, .what = none.what, .method = method, .part = part}, Expected::let_through));
  }
  for (const RankFault& fault : rank_faults()) {
    if (ranks.size() >= fault.ranks) {
      list.push_back(planted(fault, Expected::disagree));
    }
  }
  return list;
}

} // namespace hdmbench::faults
