#pragma once

#include "harness/check/verify.hpp"

namespace hdmbench {

/// As verify(), of a scene with the elastic energy: its method runs on `reference`, and every session takes
/// each step of it (sweep, residual, transfer, sum) at the same time. Two modes:
///
/// resync: what a step made is compared on all sites, and mended where it differs. A difference is certified
/// where it lies within the bound of rounding (bounded_real.hpp, of the texts themselves) of what the step
/// was made from; where all arithmetic of a site is exact that bound is 0. Comparison::counts_differing are
/// sums over the image (ElasticSession::dot) beyond their bound.
///
/// pyramid: the method runs on the backend alone and nothing is read until it ends. Where the result differs
/// it is certified if it is, to the bit, what the same backend makes when every step is waited for, and
/// all steps of resync were certified.
[[nodiscard]] std::vector<Comparison> verify_elastic(const Scene& scene, const Backend& reference,
                                                     std::span<const Backend* const> backends,
                                                     const VerifyOptions& options, Progress& progress);

} // namespace hdmbench
