#include "harness/report/tradeoff_chart.hpp"

#include "harness/judge/tradeoff/front.hpp"
#include "harness/report/html.hpp"
#include "harness/report/plot_style.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <vector>

namespace hdmbench::report {

namespace {

constexpr double width = 620.0;
constexpr double height = 430.0;
constexpr Margins margins{60.0, 84.0, 14.0, 46.0};
constexpr double right_edge = width - margins.right;
constexpr double bottom_edge = height - margins.bottom;

struct Colour {
  std::string_view method;
  std::string_view digits;
};
/// The thesis's candidates in blues and greens, minimisers in warm colours, the elastic energy's methods in
/// pinks, rivals in grays.
constexpr std::array method_colours{
    Colour{"icm", "0067a8"},
    Colour{"icm-6", "3f9bd8"},
    Colour{"icm-thesis-steps", "7b8fb5"},
    Colour{"sequential", "00795a"},
    Colour{"coloured", "4f8f00"},
    Colour{"four-coloured", "8a9a1c"},
    Colour{"closed-form", "c66a00"},
    Colour{"cascade", "c4122f"},
    Colour{"annealing", "8c6239"},
    Colour{"multigrid", "6a2fc0"},
    Colour{"krylov", "b8298f"},
    Colour{"fem", "111418"},
    Colour{"fem-cg", "4d545c"},
    Colour{"fem-coarse", "7d858e"},
    Colour{"fixed-point", "2f5f6b"},
    Colour{"interpolation", "94876f"},
    Colour{"fem-amg", "5a6f8c"},
    Colour{"as-needed", "b07a00"},
    Colour{"full-multigrid", "e0218a"},
    Colour{"conjugate-gradients", "8f0f56"},
    Colour{"sweeps", "d78fb4"},
    Colour{"as-needed-elastic", "0b8f88"},
};

constexpr std::array<std::string_view, 7> shapes{
    "M4.5 0A4.5 4.5 0 1 1-4.5 0A4.5 4.5 0 1 1 4.5 0Z", // circle, square, triangles, diamond, pentagon, bar
    "M-4-4H4V4H-4Z",
    "M0-5.4L5 3.6H-5Z",
    "M0 5.4L5-3.6H-5Z",
    "M0-5.6L5.6 0L0 5.6L-5.6 0Z",
    "M0-5.4L5.1-1.7L3.2 4.4H-3.2L-5.1-1.7Z",
    "M-5.4-2.6H5.4V2.6H-5.4Z",
};
constexpr std::string_view rival_shape = "M-1.8-5.2H1.8V-1.8H5.2V1.8H1.8V5.2H-1.8V1.8H-5.2V-1.8H-1.8Z";

std::optional<double> cost(const TradeoffRow& row, std::size_t which) {
  return which == 0 ? row.seconds_median : row.fine_sweep_equivalents;
}

std::optional<double> error(const TradeoffRow& row, std::size_t which) {
  return which == 0 ? row.to_fem_nu0 : which == 1 ? row.to_fem : row.to_fixed_point;
}

bool is_placed(const TradeoffRow& row) {
  return (row.status == PointStatus::ok || row.status == PointStatus::unverified) &&
         row.seconds_median.value_or(0.0) > 0.0 && row.to_fem_nu0 && row.to_fem && row.to_fixed_point;
}

/// A logarithmic axis from `low` at `begin` to `high` at `end`.
class Axis {
public:
  Axis(const Interval& values, double begin, double end) : begin_(begin), end_(end) {
    const double low = values.empty() ? 0.1 : values.low();
    const double high = values.empty() ? 1.0 : values.high();
    low_ = std::log10(low) - 0.08;
    high_ = std::max(std::log10(high) + 0.08, low_ + 0.5);
  }

  [[nodiscard]] double at(double value) const {
    return begin_ + (end_ - begin_) * (std::log10(value) - low_) / (high_ - low_);
  }

  /// Powers of ten, also 2 and 5 times them over few decades.
  [[nodiscard]] std::vector<double> tics() const {
    std::vector<double> result;
    const std::vector<double> factors = high_ - low_ > 2.2 ? std::vector{1.0} : std::vector{1.0, 2.0, 5.0};
    for (int decade = static_cast<int>(std::floor(low_)); decade <= static_cast<int>(high_) + 1; ++decade) {
      for (const double factor : factors) {
        const double value = factor * std::pow(10.0, decade);
        if (std::log10(value) >= low_ && std::log10(value) <= high_) {
          result.push_back(value);
        }
      }
    }
    return result;
  }

private:
  double begin_;
  double end_;
  double low_ = 0.0;  ///< decades
  double high_ = 0.0; ///< decades
};

std::string hidden_unless(bool shown) {
  return shown ? "" : " display=\"none\"";
}

class Chart {
public:
  Chart(std::span<const TradeoffRow> rows, std::span<const std::string> backends, std::string_view title)
      : rows_(rows), backends_(backends), title_(title) {
    std::array<Interval, costs> across;
    std::array<Interval, errors> up;
    for (const TradeoffRow& row : rows) {
      for (std::size_t i = 0; i < costs && is_placed(row); ++i) {
        if (cost(row, i).value_or(0.0) > 0.0) {
          across[i].include(*cost(row, i));
        }
      }
      for (std::size_t i = 0; i < errors && is_placed(row); ++i) {
        up[i].include(std::max(*error(row, i), least_error));
      }
    }
    for (const Interval& values : across) {
      across_.emplace_back(values, margins.left, right_edge);
    }
    for (const Interval& values : up) {
      up_.emplace_back(values, bottom_edge, margins.top);
    }
  }

  [[nodiscard]] std::string svg() {
    std::string html = fmt::format("<svg viewBox=\"0 0 {:g} {:g}\" role=\"img\" aria-label=\"{}: RMSD over "
                                   "cost, both logarithmic; every "
                                   "mark is a row of the table below\">\n",
                                   width, height, escape(title_));
    for (std::size_t i = 0; i < costs; ++i) {
      html += across_axis(i);
    }
    for (std::size_t i = 0; i < errors; ++i) {
      html += up_axis(i);
    }
    html += fmt::format("<path class=\"frame\" d=\"M{0:g} {1:g}V{2:g}H{3:g}\"/>\n", margins.left, margins.top,
                        bottom_edge, right_edge);
    html += strip();
    for (std::size_t x = 0; x < costs; ++x) {
      for (std::size_t y = 0; y < errors; ++y) {
        html += front(x, y);
      }
    }
    return html + series() + marks() + "</svg>\n";
  }

private:
  [[nodiscard]] std::string across_axis(std::size_t which) const {
    std::string html =
        fmt::format("<g class=\"axis\" data-across=\"{}\"{}>", which, hidden_unless(which == 0));
    for (const double tic : across_[which].tics()) {
      html += fmt::format("<path d=\"M{0:.1f} {1:g}V{2:g}\"/><text x=\"{0:.1f}\" y=\"{3:g}\" "
                          "text-anchor=\"middle\">{4:g}</text>",
                          across_[which].at(tic), margins.top, bottom_edge, bottom_edge + 17.0, tic);
    }
    return html + fmt::format("<text x=\"{:.1f}\" y=\"{:g}\" text-anchor=\"middle\">{}</text></g>\n",
                              0.5 * (margins.left + right_edge), height - 8.0, cost_names[which]);
  }

  [[nodiscard]] std::string up_axis(std::size_t which) const {
    std::string html = fmt::format("<g class=\"axis\" data-up=\"{}\"{}>", which, hidden_unless(which == 0));
    for (const double tic : up_[which].tics()) {
      const bool is_least = std::abs(tic / least_error - 1.0) < 1e-9;
      html += fmt::format("<path d=\"M{0:g} {1:.1f}H{2:g}\"/><text x=\"{3:g}\" y=\"{4:.1f}\" "
                          "text-anchor=\"end\">{5}{6:g}</text>",
                          margins.left, up_[which].at(tic), right_edge, margins.left - 6.0,
                          up_[which].at(tic) + 4.0, is_least ? "≤\u2009" : "", tic);
    }
    const double middle = 0.5 * (margins.top + bottom_edge);
    return html + fmt::format("<text transform=\"translate(13 {:g}) rotate(-90)\" "
                              "text-anchor=\"middle\">RMSD to {} [px]</text></g>\n",
                              middle, error_names[which]);
  }

  [[nodiscard]] std::string strip() const {
    if (std::ranges::all_of(rows_, is_placed)) {
      return {};
    }
    return fmt::format("<rect class=\"strip\" x=\"{:g}\" y=\"{:g}\" width=\"{:g}\" height=\"{:g}\"/>"
                       "<text class=\"axis\" x=\"{:g}\" y=\"{:g}\" text-anchor=\"middle\">no result</text>\n",
                       right_edge + 8.0, margins.top, margins.right - 14.0, bottom_edge - margins.top,
                       right_edge + 1.0 + margins.right / 2.0, bottom_edge + 17.0);
  }

  /// Where a row stands; nothing in a view for which it has no figure.
  [[nodiscard]] std::optional<double> x_of(const TradeoffRow& row, std::size_t which) const {
    const auto value = cost(row, which);
    return is_placed(row) && value.value_or(0.0) > 0.0 ? std::optional(across_[which].at(*value))
                                                       : std::nullopt;
  }
  [[nodiscard]] double y_of(const TradeoffRow& row, std::size_t which) const {
    return up_[which].at(std::max(*error(row, which), least_error));
  }

  [[nodiscard]] std::string front(std::size_t x, std::size_t y) const {
    std::vector<const TradeoffRow*> counted;
    std::vector<CostAndError> points;
    for (const TradeoffRow& row : rows_) {
      if (row.status == PointStatus::ok && x_of(row, x)) {
        counted.push_back(&row);
        points.push_back({*cost(row, x), *error(row, y)});
      }
    }
    std::string path;
    std::string labels;
    double label_end = 0.0;
    double label_line = 0.0;
    for (const std::size_t i : pareto_front(points)) {
      const double at_x = *x_of(*counted[i], x);
      const double at_y = y_of(*counted[i], y);
      path += path.empty() ? fmt::format("M{:.1f} {:g}V{:.1f}", at_x, margins.top, at_y)
                           : fmt::format("H{:.1f}V{:.1f}", at_x, at_y);
      const std::string name = tradeoff_name(*counted[i]);
      const double length = 6.2 * static_cast<double>(name.size());
      const bool turned = at_x + 9.0 + length > right_edge;
      const double start = turned ? at_x - 9.0 - length : at_x + 9.0;
      if (start > label_end || std::abs(at_y - label_line) > 13.0) { // else it would lie on the one before
        labels +=
            fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"{}\">{}</text>",
                        turned ? at_x - 9.0 : at_x + 9.0, at_y - 5.0, turned ? "end" : "start", escape(name));
        label_end = start + length;
        label_line = at_y;
      }
    }
    if (path.empty()) {
      return {};
    }
    return fmt::format("<g class=\"front\" data-view=\"{} {}\"{}><path d=\"{}H{:g}\"/>{}</g>\n", x, y,
                       hidden_unless(x == 0 && y == 0), path, right_edge, labels);
  }

  /// Curves through the efforts of a method on one backend; tradeoff.js moves them with the marks.
  [[nodiscard]] std::string series() {
    std::map<std::string, std::vector<const TradeoffRow*>> members;
    for (const TradeoffRow& row : rows_) {
      if (row.status == PointStatus::ok && is_placed(row)) {
        members[key_of(row)].push_back(&row);
      }
    }
    std::string html;
    for (const auto& [key, all] : members) {
      if (all.size() < 2) {
        continue;
      }
      std::string path;
      for (const TradeoffRow* const row : all) {
        path += fmt::format("{}{:.1f} {:.1f}", path.empty() ? 'M' : 'L', *x_of(*row, 0), y_of(*row, 0));
      }
      html += fmt::format("<path class=\"series\" data-series=\"{}\" data-method=\"{}\" data-backend=\"{}\" "
                          "stroke=\"#{}\" d=\"{}\"/>\n",
                          escape(key), escape(all.front()->method), escape(all.front()->backend),
                          tradeoff_colour(all.front()->method), path);
    }
    return html;
  }

  static std::string key_of(const TradeoffRow& row) { return tradeoff_name(row) + '|' + row.backend; }

  [[nodiscard]] std::string marks() {
    std::string html;
    int without = 0; // place in the strip
    for (const TradeoffRow& row : rows_) {
      std::array<std::string, costs> x;
      std::array<std::string, errors> y;
      double first_x = 0.0;
      double first_y = 0.0;
      if (is_placed(row)) {
        for (std::size_t i = 0; i < costs; ++i) {
          const auto at = x_of(row, i);
          x[i] = at ? fmt::format("{:.1f}", *at) : "-";
        }
        for (std::size_t i = 0; i < errors; ++i) {
          y[i] = fmt::format("{:.1f}", y_of(row, i));
        }
        first_x = *x_of(row, 0);
        first_y = y_of(row, 0);
      } else {
        constexpr int per_column = 28;
        first_x = right_edge + 17.0 + 12.0 * (without / per_column);
        first_y = margins.top + 12.0 + 13.0 * (without % per_column);
        ++without;
        x.fill(fmt::format("{:.1f}", first_x));
        y.fill(fmt::format("{:.1f}", first_y));
      }
      html += mark(row, first_x, first_y, fmt::format("{} {}", x[0], x[1]),
                   fmt::format("{} {} {}", y[0], y[1], y[2]));
    }
    return html;
  }

  [[nodiscard]] std::string mark(const TradeoffRow& row, double x, double y, const std::string& all_x,
                                 const std::string& all_y) const {
    const bool is_cross =
        row.status == PointStatus::failed || row.status == PointStatus::skipped || !is_placed(row);
    std::string drawn;
    if (!is_cross) {
      drawn = fmt::format("<path d=\"{}\"/>", backend_shape(row.backend, backends_));
    }
    if (row.status != PointStatus::ok) {
      drawn += "<path class=\"cross\" d=\"M-4-4L4 4M4-4L-4 4\"/>";
    }
    return fmt::format(
        "<g class=\"mark {}\" transform=\"translate({:.1f} {:.1f})\" data-x=\"{}\" data-y=\"{}\" "
        "data-method=\"{}\" data-backend=\"{}\" data-series=\"{}\" color=\"#{}\"><title>{}</title>"
        "{}</g>\n",
        name_of(row.status), x, y, all_x, all_y, escape(row.method), escape(row.backend),
        row.status == PointStatus::ok ? escape(key_of(row)) : "", tradeoff_colour(row.method),
        escape(description(row)), drawn);
  }

  /// Three lines: what, its figures or why it has none, and the command.
  static std::string description(const TradeoffRow& row) {
    std::string text = fmt::format(
        "{}, {}{}{}", tradeoff_name(row), row.effort, row.backend.empty() ? "" : " on " + row.backend,
        row.status == PointStatus::ok ? "" : fmt::format(": {}", name_of(row.status)));
    text += '\n';
    if (row.status != PointStatus::ok) {
      text += row.reason + (is_placed(row) ? "; " : "");
    }
    if (is_placed(row)) {
      text += fmt::format("{} s", seconds_text(*row.seconds_median));
      if (row.fine_sweep_equivalents) {
        text += fmt::format(", {:.3g} fine-sweep equivalents", *row.fine_sweep_equivalents);
      }
      text += fmt::format(
          "; RMSD {:.4g} px to FEM ν = 0, {:.4g} px to FEM ν = {:.2g}, {:.4g} px to the fixed point",
          *row.to_fem_nu0, *row.to_fem, row.poisson, *row.to_fixed_point);
    }
    return text + '\n' + row.command;
  }

  std::span<const TradeoffRow> rows_;
  std::span<const std::string> backends_;
  std::string title_;
  std::vector<Axis> across_;
  std::vector<Axis> up_;
};

} // namespace

std::string tradeoff_name(const TradeoffRow& row) {
  return row.poisson_used ? fmt::format("{}, ν = {:.2g}", row.method, *row.poisson_used) : row.method;
}

std::string tradeoff_colour(std::string_view method) {
  const auto* const found = std::ranges::find(method_colours, method, &Colour::method);
  return found == method_colours.end() ? "6e6e6e" : std::string(found->digits);
}

std::string_view backend_shape(std::string_view backend, std::span<const std::string> backends) {
  if (backend.empty()) {
    return rival_shape;
  }
  std::vector<std::string_view> ours(backends.begin(), backends.end());
  std::erase(ours, "");
  const auto place = static_cast<std::size_t>(std::ranges::find(ours, backend) - ours.begin());
  return shapes.at(place % shapes.size());
}

std::string tradeoff_chart(std::span<const TradeoffRow> rows, std::span<const std::string> backends,
                           std::string_view title) {
  return Chart(rows, backends, title).svg();
}

} // namespace hdmbench::report
