#include "harness/check/follower.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <tuple>

namespace hdmbench {

namespace {

/// A scene that prescribes more than all but this leaves backends next to nothing to get wrong.
constexpr double least_free_share = 0.01;

/// Of the components, those without any observation.
double free_share(const VectorField& confidence) {
  std::ptrdiff_t free = 0;
  for (std::size_t axis = 0; axis < confidence.extent.axes(); ++axis) {
    free += std::ranges::count(confidence[axis], 0.0F);
  }
  return static_cast<double>(free) / static_cast<double>(confidence.extent.axes() * confidence[0].size());
}

/// Keeps the site where it is the first that differs, or the first without an explanation. Returns whether it
/// is.
bool keep_first(Comparison& comparison, FirstDifference first, std::size_t site, const VectorField& expected,
                const VectorField& found, const Certificate& certificate) {
  const bool is_first = !comparison.first || (!certificate.holds && comparison.uncertified == 0);
  if (is_first) {
    std::tie(first.x, first.y, first.z) = std::tuple_cat(expected.extent.coordinates(site));
    first.expected.resize(expected.extent.axes());
    first.found.resize(expected.extent.axes());
    for (std::size_t axis = 0; axis < expected.extent.axes(); ++axis) {
      first.expected[axis] = expected[axis][site];
      first.found[axis] = found[axis][site];
    }
    first.certificate = certificate;
    comparison.first = first;
  }
  return is_first;
}

} // namespace

std::string FirstDifference::text() const {
  const std::string when =
      step.empty() ? fmt::format("iteration {}", iteration) : fmt::format("step {}, {}", iteration, step);
  return fmt::format("level {}, {}, x = {}, y = {}{}: expected ({}), found ({})", level, when, x, y,
                     expected.size() > 2 ? fmt::format(", z = {}", z) : "", fmt::join(expected, ", "),
                     fmt::join(found, ", "));
}

Comparison broken_off(const Comparison& comparison, const DeviceError& error) {
  return {.backend = comparison.backend,
          .device = comparison.device,
          .mode = comparison.mode,
          .reason = error.what(),
          .failed = dynamic_cast<const TooLarge*>(&error) == nullptr};
}

void count_field(Comparison& comparison, const VectorField& reference, const FieldDifference& drift) {
  comparison.sites_compared += static_cast<std::int64_t>(reference.extent.sites());
  comparison.sites_drifted += drift.sites;
  comparison.not_finite += drift.not_finite;
  comparison.largest_difference = std::max(comparison.largest_difference, drift.largest);
}

bool judge_step(Comparison& comparison, const VectorField& expected, const VectorField& found,
                const FirstDifference& place,
                const std::function<Certificate(int x, int y, int z)>& certify) {
  bool has_first = false;
  for (std::size_t site = 0; site < expected[0].size(); ++site) {
    if (!differs(expected, found, site)) {
      continue;
    }
    const Certificate certificate = std::apply(certify, expected.extent.coordinates(site));
    has_first = keep_first(comparison, place, site, expected, found, certificate) || has_first;
    ++comparison.sites_differing;
    ++(certificate.holds ? comparison.certified_ties : comparison.uncertified);
    if (certificate.holds) {
      comparison.largest_gap_over_bound =
          std::max(comparison.largest_gap_over_bound, certificate.gap_over_bound);
    }
  }
  return has_first;
}

void judge_end(Comparison& comparison, const VectorField& expected, const VectorField& found,
               const FirstDifference& place, bool explained) {
  const FieldDifference difference = compare(expected, found);
  count_field(comparison, expected, difference);
  if (difference.first) {
    (void)keep_first(comparison, place, *difference.first, expected, found, {.holds = explained});
  }
  comparison.sites_differing += difference.sites;
  (explained ? comparison.certified_ties : comparison.uncertified) += difference.sites;
}

void FirstStep::record(const Comparison& comparison, const std::function<void()>& take) {
  if (recording_ != nullptr && comparison.uncertified == 0) {
    recording_->record(take);
  } else {
    take();
  }
}

void FirstStep::keep(Comparison& comparison, const VectorField& expected, const VectorField& found,
                     const std::function<void(VectorField&)>& read,
                     const std::function<void(const VectorField&)>& write) {
  if (recording_ != nullptr) {
    VectorField again;
    auto step = recording_->step([&] { read(again); }, [&] { write(found); }, [&] { write(expected); });
    comparison.step = step ? std::make_shared<const RecordedStep>(std::move(*step)) : nullptr;
  }
}

std::string why_mistrusted(const Scene& scene, bool moved) {
  if (!moved) {
    return "no site ever moved, so a backend that does nothing would pass";
  }
  const double free = free_share(scene.full.confidence);
  return free >= least_free_share
             ? ""
             : fmt::format("only {:.2g} % of the components are free, so almost nothing was computed",
                           100.0 * free);
}

void conclude(Comparison& comparison, const Conditions& conditions) {
  const bool active = comparison.mode == Mode::active;
  comparison.sites_at_rest = active ? conditions.sites_at_rest : 0;
  if (comparison.uncertified > 0 || comparison.counts_differing > 0) {
    comparison.verdict = Verdict::disagree;
  } else if (!conditions.why_mistrusted.empty()) {
    comparison.verdict = Verdict::mistrusted;
    comparison.reason = conditions.why_mistrusted;
  } else if (active && comparison.sites_at_rest == 0) {
    comparison.verdict = Verdict::skipped;
    comparison.reason = "there was nothing to leave out: something could change in every tile in every sweep";
  } else if (comparison.certified_ties > 0) {
    comparison.verdict = Verdict::certified;
    comparison.tier = Tier::certified;
  } else {
    comparison.verdict = Verdict::agree;
    comparison.tier = conditions.exact ? Tier::exact : Tier::bitwise;
  }
}

} // namespace hdmbench
