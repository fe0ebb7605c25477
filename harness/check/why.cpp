#include "harness/check/why.hpp"

#include "harness/check/compare.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <set>
#include <utility>

namespace hdmbench {

namespace {

using rewritten::Kind;
using rewritten::Place;
using rewritten::Rewrite;

/// Sites of one step that are kept, of those that differ and of the others.
constexpr std::size_t most_of_step = 16;
/// Where no rewrite alone makes all: sites, of those that differ and of the others, by which rewrites are
/// tried together, and how many at most.
constexpr std::size_t most_for_several = 16;
constexpr std::size_t most_together = 4;

constexpr std::array<std::string_view, rewritten::kinds> of_a_place{
    "a product is fused into the sum that follows",
    "a product is fused into the sum that follows, of two the second",
    "a product that has a name is fused into the sum that follows",
    "terms are added in another order",
    "a product with a sum is made of its terms",
    "a factor of two terms is taken out of their sum",
    "a subnormal number is 0",
    "a result is rounded toward zero",
    "a result has the bits of a half float"};
constexpr std::array<std::string_view, rewritten::kinds> of_all_places{
    "every product is fused into the sum that follows",
    "every product is fused into the sum that follows, of two the second",
    "every product, also one that has a name, is fused into the sum that follows",
    "terms are added in another order everywhere",
    "every product with a sum is made of its terms",
    "factors of two terms are taken out of their sums",
    "subnormal numbers are 0",
    "all results are rounded toward zero",
    "all results have the bits of half floats"};

/// Whether an all-or-nothing rewrite is something that devices do.
constexpr bool is_done_everywhere(Kind kind) {
  return kind != Kind::reordered && kind != Kind::distributed && kind != Kind::factored;
}

/// The file as a reader finds it below kernels/specification.
std::string_view short_name(std::string_view file) {
  constexpr std::string_view folder = "specification/";
  const std::size_t at = file.rfind(folder);
  return at == std::string_view::npos ? file.substr(file.rfind('/') + 1) : file.substr(at + folder.size());
}

std::string lines_of(std::span<const Rewrite> rewrites) {
  std::vector<std::string> texts;
  std::ranges::transform(rewrites, std::back_inserter(texts), text_of);
  return fmt::format("{}", fmt::join(texts, "; "));
}

/// call(i) for some of 0 ... count - 1, at most so many, evenly spread.
template <typename Call>
void for_some(std::size_t count, std::size_t most, const Call& call) {
  const std::size_t some = std::min(count, most);
  for (std::size_t i = 0; i < some; ++i) {
    call(i * count / some);
  }
}

/// The rewrites of whole lines, and of everything.
std::vector<Rewrite> of_lines(const std::vector<Rewrite>& possible) {
  std::set<Rewrite> lines;
  std::set<Kind> everywhere;
  for (const Rewrite& one : possible) {
    lines.insert({.kind = one.kind, .place = Place{one.place->file, one.place->line}});
    if (is_done_everywhere(one.kind)) {
      everywhere.insert(one.kind);
    }
  }
  std::vector<Rewrite> all(lines.begin(), lines.end());
  for (const Kind kind : everywhere) {
    all.push_back({.kind = kind, .place = std::nullopt});
  }
  return all;
}

} // namespace

std::string text_of(const Rewrite& rewrite) {
  const auto kind = static_cast<std::size_t>(rewrite.kind);
  return rewrite.place ? fmt::format("{} in {}, line {}", of_a_place.at(kind),
                                     short_name(rewrite.place->file), rewrite.place->line)
                       : std::string(of_all_places.at(kind));
}

std::string Explanation::text() const {
  if (sites == 0) {
    return {};
  }
  const std::string looked_at =
      differing == 1 ? fmt::format("one site that differs and {} beside it", sites - differing)
                     : fmt::format("{} sites that differ and {} beside them", differing, sites - differing);
  if (is_complete()) {
    constexpr std::size_t most_named = 2;
    const std::size_t named = std::min(others.size(), most_named);
    return fmt::format("{}{}{}: that makes all of {}", lines_of(rewrites),
                       named > 0 ? fmt::format("; or {}", lines_of(std::span(others).first(named))) : "",
                       others.size() > named
                           ? fmt::format("; or one of {} others, among which so few sites cannot tell",
                                         others.size() - named)
                           : "",
                       looked_at);
  }
  const std::string none =
      fmt::format("none of {} rewrites of the arithmetic makes what was found of {}", tried, looked_at);
  return explained <= sites - differing
             ? none
             : fmt::format("{}; {} of {} by this: {}", none, explained, sites, lines_of(rewrites));
}

bool Evidence::wants(const Step& step) const {
  constexpr int most_steps = 8;
  constexpr std::size_t most_sites_kept = std::size_t{1} << 21; // 100 to 200 MB
  const auto there = steps_.find({step.level, step.kind});
  const bool tells =
      there == steps_.end() || (there->second.first < most_steps && there->second.second < most_of_step);
  return tells && (samples_.empty() || sites_kept_ + step.sites_kept <= most_sites_kept);
}

void Evidence::add(const Step& step, const VectorField& expected, const VectorField& found,
                   const AtSite& at_site) {
  const Extent extent = expected.extent;
  std::vector<std::size_t> differing;
  for (std::size_t site = 0; site < extent.sites(); ++site) {
    if (differs(expected, found, site)) {
      differing.push_back(site);
    }
  }
  auto& [steps, sites] = steps_[{step.level, step.kind}];
  ++steps;
  sites += differing.size();
  std::set<std::size_t> kept;
  for_some(differing.size(), most_of_step, [&](std::size_t i) { kept.insert(differing[i]); });
  for_some(extent.sites(), most_of_step, [&](std::size_t site) { kept.insert(site); });
  std::vector<Sample> of_step;
  for (const std::size_t site : kept) {
    of_step.push_back({.at_site = at_site,
                       .at = extent.coordinates(site),
                       .found = site_of(found, site),
                       .differs = differs(expected, found, site),
                       .cost = step.cost});
    if (std::apply(at_site, of_step.back().at) != site_of(expected, site)) {
      return;
    }
  }
  sites_kept_ += step.sites_kept;
  samples_.insert(samples_.end(), of_step.begin(), of_step.end());
  std::ranges::stable_sort(samples_, {}, [](const Sample& sample) {
    return std::pair(!sample.differs, sample.cost); // what tells most for least comes first
  });
}

std::size_t Evidence::explained_by(std::span<const Rewrite> rewrites, std::size_t least) const {
  const rewritten::Replay replay(rewrites);
  std::size_t missed = 0;
  for (const Sample& sample : samples_) {
    const SiteAnswer answer = std::apply(sample.at_site, sample.at);
    missed += answer == sample.found ? 0 : 1;
    if (missed + least > samples_.size()) {
      return 0;
    }
  }
  return samples_.size() - missed;
}

/// Through all steps, which the order of samples has one after the other.
Evidence Evidence::part() const {
  const std::size_t differing = counted().differing;
  Evidence few;
  const auto keep = [&](std::size_t i) { few.samples_.push_back(samples_[i]); };
  for_some(differing, most_for_several, keep);
  for_some(samples_.size() - differing, most_for_several, [&](std::size_t i) { keep(differing + i); });
  return few;
}

Explanation Evidence::counted() const {
  const auto differing = static_cast<std::size_t>(std::ranges::count(samples_, true, &Sample::differs));
  return {.sites = samples_.size(), .differing = differing, .explained = samples_.size() - differing};
}

/// Takes lines out of those that all are fused, as long as no fewer sites are explained.
Explanation Evidence::by_fused_lines(const std::vector<Rewrite>& all, Kind kind) const {
  Explanation best = counted();
  std::ranges::copy_if(all, std::back_inserter(best.rewrites), [kind](const Rewrite& one) {
    return one.kind == kind && one.place && one.place->column == 0;
  });
  best.explained = explained_by(best.rewrites, 0);
  for (std::size_t i = 0; i < best.rewrites.size();) {
    std::vector<Rewrite> fewer = best.rewrites;
    fewer.erase(fewer.begin() + static_cast<std::ptrdiff_t>(i));
    if (const std::size_t explained = explained_by(fewer, 0); explained >= best.explained) {
      best.rewrites = fewer;
      best.explained = explained;
    } else {
      ++i;
    }
  }
  return best;
}

/// Adds the rewrite that explains most, as long as one explains more.
Explanation Evidence::by_several(const std::vector<Rewrite>& all) const {
  Explanation best = counted();
  for (std::size_t count = 0; count < most_together && !best.is_complete(); ++count) {
    const std::vector<Rewrite> before = best.rewrites;
    const std::size_t least = best.explained + 1 + best.differing / 8; // one site may be met by chance
    for (const Rewrite& one : all) {
      std::vector<Rewrite> with_one = before;
      with_one.push_back(one);
      if (const std::size_t explained = explained_by(with_one, std::max(least, best.explained + 1));
          explained > 0) {
        best.rewrites = with_one;
        best.explained = explained;
      }
    }
    if (best.rewrites == before) {
      break;
    }
  }
  return best;
}

/// What could be rewritten where bits differ.
std::vector<Rewrite> Evidence::possible() const {
  std::set<Rewrite> all;
  const rewritten::Replay replay({}, &all);
  for (const Sample& sample : part().samples_) {
    (void)std::apply(sample.at_site, sample.at);
  }
  return {all.begin(), all.end()};
}

/// Notes those of `all` that make all sites.
void Evidence::keep_complete(Explanation& found, const std::vector<Rewrite>& all) const {
  std::set<std::string> named;
  for (const Rewrite& one : all) {
    if (explained_by({&one, 1}, samples_.size()) > 0 && named.insert(text_of(one)).second) {
      (found.rewrites.empty() ? found.rewrites : found.others).push_back(one);
      found.explained = found.sites;
    }
  }
}

Explanation Evidence::explain() const {
  Explanation found = counted();
  if (samples_.empty()) {
    return found;
  }
  const std::vector<Rewrite> operations = possible();
  std::vector<Rewrite> all = of_lines(operations);
  keep_complete(found, all);
  if (!found.is_complete()) { // maybe one of several in a line
    keep_complete(found, operations);
    all.insert(all.end(), operations.begin(), operations.end());
  }
  if (!found.is_complete()) {
    const Evidence few = part();
    Explanation best = few.by_fused_lines(all, Kind::fused_first);
    const auto keep_better = [&](const Explanation& other) {
      best = other.explained > best.explained ? other : best;
    };
    keep_better(few.by_fused_lines(all, Kind::fused_named));
    if (!best.is_complete()) {
      keep_better(few.by_several(all));
    }
    found.rewrites = best.rewrites;
    found.explained = explained_by(found.rewrites, 0);
  }
  found.tried = all.size();
  return found;
}

} // namespace hdmbench
