#include "harness/check/follower.hpp"

#include "harness/scene/sites.hpp"
#include "harness/solve/solve.hpp"
#include "reference/thesis_energy.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace hdmbench {

namespace {

/// A scene that prescribes more than all but this leaves backends next to nothing to get wrong.
constexpr double least_free_share = 0.01;

/// Of the components, those without any observation.
double free_share(const VectorField& confidence) {
  const auto free = std::ranges::count(confidence.x, 0.0F) + std::ranges::count(confidence.y, 0.0F);
  return static_cast<double>(free) / (2.0 * static_cast<double>(confidence.x.size()));
}

bool differs(const VectorField& expected, const VectorField& found, std::size_t site) {
  return !(expected.x[site] == found.x[site] && expected.y[site] == found.y[site]); // true for NaN
}

} // namespace

FirstDifference difference_at(std::size_t site, const VectorField& expected, const VectorField& found) {
  const auto width = static_cast<std::size_t>(expected.extent.width);
  return {.x = static_cast<int>(site % width),
          .y = static_cast<int>(site / width),
          .expected = {expected.x[site], expected.y[site]},
          .found = {found.x[site], found.y[site]}};
}

void count_site(Comparison& comparison, const Certificate& certificate,
                const std::function<FirstDifference()>& describe) {
  const bool first_failure = !certificate.holds && comparison.uncertified == 0;
  ++comparison.sites_differing;
  if (certificate.holds) {
    ++comparison.certified_ties;
    comparison.largest_gap_over_bound =
        std::max(comparison.largest_gap_over_bound, certificate.gap_over_bound);
  } else {
    ++comparison.uncertified;
  }
  if (first_failure || !comparison.first) {
    comparison.first = describe();
    comparison.first->certificate = certificate;
  }
}

void count_end(Comparison& comparison, const FieldDifference& difference, Extent extent, bool explained,
               const std::function<FirstDifference(std::size_t site)>& describe) {
  comparison.sites_compared += static_cast<std::int64_t>(extent.sites());
  comparison.sites_differing += difference.sites;
  comparison.sites_drifted += difference.sites;
  comparison.not_finite += difference.not_finite;
  comparison.largest_difference = std::max(comparison.largest_difference, difference.largest);
  const bool first_failure = !explained && comparison.uncertified == 0;
  (explained ? comparison.certified_ties : comparison.uncertified) += difference.sites;
  if (difference.first && (first_failure || !comparison.first)) {
    comparison.first = describe(*difference.first);
    comparison.first->certificate.holds = explained;
  }
}

FirstDifference describe_difference(const ReferenceStep& step, const VectorField& before,
                                    const VectorField& expected, const VectorField& found, std::size_t site) {
  FirstDifference first = difference_at(site, expected, found);
  first.level = step.level_index;
  first.iteration = step.iteration;
  const ThesisEnergy energy(step.level, before);
  const auto total = [](ThesisEnergy::Value value) { return value.x + value.y; };
  first.energy_before = total(energy.at(first.x, first.y));
  first.energy_expected = total(energy.at(first.x, first.y, {first.expected[0], first.expected[1]}));
  first.energy_found = total(energy.at(first.x, first.y, {first.found[0], first.found[1]}));
  return first;
}

std::string why_mistrusted(const Scene& scene, bool moved) {
  if (!moved) {
    return "no site ever moved, so a backend that does nothing would pass";
  }
  const double free = free_share(scene.full.confidence);
  if (free < least_free_share) {
    return fmt::format("only {:.2g} % of the components are free, so almost nothing was computed",
                       100.0 * free);
  }
  return {};
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

Follower::Follower(const Backend& backend, SessionOptions options, const Scene& scene, Mode mode)
    : exact_(scene.exact) {
  options.work = mode == Mode::active ? Work::active : Work::dense;
  comparison_.backend = backend.name();
  comparison_.mode = mode;
  if (!backend.supports(scene.full.update)) {
    comparison_.reason = fmt::format("cannot update as {} wants", method_name(scene));
    return;
  }
  try {
    comparison_.device = backend.device(options);
    session_ = backend.open(options);
  } catch (const DeviceError& error) {
    comparison_.reason = error.what();
  }
}

void Follower::begin_level(const LevelSequence& levels, const Level& level, int index) {
  if (session_ != nullptr) {
    begin_ = levels.begin(index, displacement_);
    ++comparison_.levels;
    begin_again(level);
  }
}

void Follower::begin_again(const Level& level) {
  if (session_ == nullptr) {
    return;
  }
  try {
    session_->load(level);
  } catch (const TooLarge& error) { // what was compared on smaller levels is no verdict on the scene
    session_.reset();
    comparison_ = {.backend = comparison_.backend,
                   .device = comparison_.device,
                   .mode = comparison_.mode,
                   .reason = error.what()};
    return;
  }
  session_->write(begin_);
  displacement_ = begin_;
  last_changed_ = 0;
  drifted_ = is_on_its_own() && comparison_.sites_drifted > 0;
}

void Follower::follow(const ReferenceStep& step) {
  if (session_ == nullptr) {
    return;
  }
  if (is_on_its_own()) {
    before_ = displacement_;
  } else {
    session_->write(step.before);
  }
  const VectorField& before = is_on_its_own() ? before_ : step.before;
  session_->step(1);
  session_->read(displacement_);

  const FieldDifference drift = compare(step.after, displacement_);
  const bool same_before = !drifted_;
  drifted_ = is_on_its_own() && drift.sites > 0;
  if (!same_before || drift.sites > 0) {
    const VectorField& expected = same_before ? step.after : specified(step, before);
    for (std::size_t site = 0; site < expected.x.size(); ++site) {
      if (differs(expected, displacement_, site)) {
        judge_site(step, before, expected, site);
      }
    }
  }
  const bool as_reference = same_before && drift.sites == 0;
  last_changed_ = as_reference ? step.changed : compare(before, displacement_).sites;
  ++comparison_.sweeps;
  comparison_.iterations = comparison_.sweeps / sweeps_per_iteration(step.level);
  comparison_.sites_compared += static_cast<std::int64_t>(step.level.extent.sites());
  comparison_.sites_drifted += drift.sites;
  comparison_.not_finite += drift.not_finite;
  comparison_.counts_differing += session_->changed() == last_changed_ ? 0 : 1;
  comparison_.largest_difference = std::max(comparison_.largest_difference, drift.largest);
}

void Follower::end_level() {
  if (session_ != nullptr) {
    session_->read(displacement_);
  }
}

Comparison Follower::finish(const Conditions& conditions) {
  if (session_ != nullptr) {
    conclude(comparison_, conditions);
  }
  return comparison_;
}

const VectorField& Follower::specified(const ReferenceStep& step, const VectorField& before) {
  const Extent extent = step.level.extent;
  answer_ = VectorField(extent);
  for_each_site(extent, [&](int x, int y) {
    const SiteAnswer answer = specified_answer(step.level, before, step.number, x, y);
    answer_.x[extent.index(x, y)] = answer.x;
    answer_.y[extent.index(x, y)] = answer.y;
  });
  return answer_;
}

void Follower::judge_site(const ReferenceStep& step, const VectorField& before, const VectorField& expected,
                          std::size_t site) {
  const auto width = static_cast<std::size_t>(step.level.extent.width);
  Certificate certificate =
      certify(step.level, before, step.number, static_cast<int>(site % width), static_cast<int>(site / width),
              {displacement_.x[site], displacement_.y[site]});
  certificate.holds = certificate.holds && !exact_; // there is no rounding to explain it
  count_site(comparison_, certificate,
             [&] { return describe_difference(step, before, expected, displacement_, site); });
}

} // namespace hdmbench
