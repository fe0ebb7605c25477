#pragma once

#include "harness/check/follower.hpp"
#include "kernels/data/pyramid.hpp"

#include <span>

namespace hdmbench {

/// Mode::pyramid, after all levels have been followed. `end` is the reference's last sweep, its level the
/// last one; where that has none, `before` is `after` and `changed` 0. The sessions are those of `followers`,
/// one backend's free one and, where active is not left out, its active one, and further ones for every
/// variant that is worth trying (Backend::variants()) unless options.variant names one. Without a verdict as
/// yet, or skipped.
[[nodiscard]] Comparison compare_in_one_piece(const Pyramid& pyramid, const ReferenceStep& end,
                                              std::span<Follower> followers, const Backend& backend,
                                              const SessionOptions& options);

} // namespace hdmbench
