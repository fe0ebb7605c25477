#pragma once

#include "harness/report/results.hpp"

#include <array>
#include <cstddef>
#include <span>
#include <string>
#include <string_view>

/// The chart of speed against accuracy as inline SVG. Both axes are logarithmic.
namespace hdmbench::report {

/// What a chart can show across and up; tradeoff.js switches between them by these indices.
inline constexpr std::size_t costs = 2;  ///< seconds, fine-sweep equivalents
inline constexpr std::size_t errors = 3; ///< RMSD to FEM nu 0, FEM with the scene's nu, the fixed point
inline constexpr std::array<std::string_view, costs> cost_names{"seconds", "fine-sweep equivalents"};
inline constexpr std::array<std::string_view, errors> error_names{"FEM, ν = 0", "FEM, ν of the scene",
                                                                  "the fixed point"};

/// What nobody could see on a logarithmic axis stands at its end: RMSD in pixels.
inline constexpr double least_error = 1e-4;

/// "fem, ν = 0" or "cascade".
[[nodiscard]] std::string tradeoff_name(const TradeoffRow& row);

/// Six hexadecimal digits, chosen for a white ground.
[[nodiscard]] std::string tradeoff_colour(std::string_view method);

/// An SVG path around 0, 0 with a radius of about 5, by the place of `backend` among `backends`; empty: a
/// rival.
[[nodiscard]] std::string_view backend_shape(std::string_view backend, std::span<const std::string> backends);

/// Every row is a mark: ok where it belongs, unverified there with a cross, failed and skipped as crosses in
/// a strip at the right edge. Curves join the efforts of a method on one backend, a staircase is the Pareto
/// front over the rows that are ok. Shows seconds against FEM nu 0; the other views wait for tradeoff.js.
/// `backends`: all that the page shows, so that each has its shape everywhere.
[[nodiscard]] std::string tradeoff_chart(std::span<const TradeoffRow> rows,
                                         std::span<const std::string> backends, std::string_view title);

} // namespace hdmbench::report
