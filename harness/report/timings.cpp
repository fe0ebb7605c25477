#include "harness/report/timings.hpp"

#include "reference/published.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <tuple>

namespace hdmbench::report {

namespace {

std::vector<std::string> scenes_in_order(const std::vector<BenchRow>& rows) {
  std::vector<std::string> measured;
  for (const BenchRow& row : rows) {
    if (std::ranges::find(measured, row.scene) == measured.end()) {
      measured.push_back(row.scene);
    }
  }
  const auto published = published_timings();
  std::ranges::stable_sort(measured, {}, [&](const std::string& scene) {
    return std::ranges::find(published, scene, &PublishedTiming::scene) - published.begin();
  });
  return measured;
}

std::vector<SceneTimings::Size> sizes_of(const std::string& scene, const std::vector<BenchRow>& rows) {
  std::vector<SceneTimings::Size> sizes;
  const auto add = [&](SceneTimings::Size size) {
    if (std::ranges::find(sizes, size) == sizes.end()) {
      sizes.push_back(size);
    }
  };
  for (const BenchRow& row : rows) {
    if (row.scene == scene) {
      add({row.width, row.height});
    }
  }
  for (const PublishedTiming& published : published_timings()) {
    if (published.scene == scene) {
      add({published.size, published.size});
    }
  }
  std::ranges::stable_sort(sizes, {}, [](const SceneTimings::Size& size) {
    return std::tuple(size.width * size.height, size.width);
  });
  return sizes;
}

void withhold_where_verify_disagrees(BenchRow& row, const std::vector<VerifyRow>& verify) {
  const bool disagrees = std::ranges::any_of(verify, [&](const VerifyRow& check) {
    return check.verdict == Verdict::disagree && check.scene == row.scene && check.backend == row.backend &&
           check.device.name == row.device;
  });
  if (row.counts() && disagrees) {
    row.valid = false;
    row.speed_up_over_scalar.reset();
    row.reason = "disagrees with scalar on this scene, see above";
  }
}

// The n-th distinct backend and device of the machine, whatever the scene, by a method: sites left out are
// the same method.
std::size_t colour_of(const std::vector<BenchRow>& rows, const BenchRow& row) {
  using Key = std::tuple<std::string, std::string, std::string>;
  const auto key_of = [](const BenchRow& any) {
    return Key{any.backend, any.device, dense_method(any.method, any.work == Work::active)};
  };
  std::vector<Key> keys;
  const Key wanted = key_of(row);
  for (const BenchRow& other : rows) {
    const Key key = key_of(other);
    if (key == wanted) {
      break;
    }
    if (std::ranges::find(keys, key) == keys.end()) {
      keys.push_back(key);
    }
  }
  return keys.size();
}

bool has_more_threads(const BenchRow& other, const BenchRow& row) {
  return other.scene == row.scene && other.width == row.width && other.height == row.height &&
         other.backend == row.backend && other.device == row.device && other.method == row.method &&
         other.threads > row.threads;
}

void add_row(SceneTimings& timings, const BenchRow& row, std::size_t colour) {
  // A row that was skipped may have no device: it stands on its backend's line where there is one with this
  // size free.
  const auto line = std::ranges::find_if(timings.lines, [&](const SceneTimings::Line& candidate) {
    return candidate.backend == row.backend && candidate.method == row.method &&
           (candidate.device == row.device ||
            ((candidate.device.empty() || row.device.empty()) &&
             SceneTimings::find(candidate, {row.width, row.height}) == nullptr));
  });
  if (line == timings.lines.end()) {
    timings.lines.push_back({row.backend, row.device, row.method, colour, row.work == Work::active, {row}});
    return;
  }
  if (line->device.empty()) {
    line->device = row.device;
    line->colour = colour;
  }
  // Two rows of one file for the same size: the last one counts.
  std::erase_if(line->rows, [&](const BenchRow& other) {
    return other.width == row.width && other.height == row.height;
  });
  line->rows.push_back(row);
}

} // namespace

const BenchRow* SceneTimings::find(const Line& line, const Size& size) {
  const auto found = std::ranges::find_if(
      line.rows, [&](const BenchRow& row) { return row.width == size.width && row.height == size.height; });
  return found == line.rows.end() ? nullptr : &*found;
}

std::string SceneTimings::label_of(const Line& line) const {
  const std::string method = dense_method(line.method, line.active);
  const bool other_methods = std::ranges::any_of(
      lines, [&](const Line& other) { return dense_method(other.method, other.active) != method; });
  return line.backend + (other_methods ? ", " + method : "") + (line.active ? ", active" : "");
}

std::string SceneTimings::name_of(const Line& line) const {
  const bool other_devices = std::ranges::any_of(
      lines, [&](const Line& other) { return other.backend == line.backend && other.device != line.device; });
  return label_of(line) + (other_devices ? ", " + line.device : "");
}

std::string dense_method(const std::string& method, bool active) {
  constexpr std::string_view suffix = "-active";
  const bool strip = active && method.ends_with(suffix);
  return method.substr(0, method.size() - (strip ? suffix.size() : 0));
}

std::vector<SceneTimings> scene_timings(const Results& results, const std::string& machine) {
  const std::vector<BenchRow> rows = results.of(results.bench, machine);
  const std::vector<VerifyRow> verify = results.of(results.verify, machine);
  std::vector<SceneTimings> scenes;
  for (const std::string& scene : scenes_in_order(rows)) {
    SceneTimings timings{scene, sizes_of(scene, rows), {}};
    for (BenchRow row : rows) {
      const bool most_threads =
          std::ranges::none_of(rows, [&](const BenchRow& other) { return has_more_threads(other, row); });
      if (row.scene == scene && most_threads) {
        const std::size_t colour = colour_of(rows, row);
        withhold_where_verify_disagrees(row, verify);
        add_row(timings, row, colour);
      }
    }
    scenes.push_back(std::move(timings));
  }
  return scenes;
}

std::vector<SizeSeries> size_series(const SceneTimings& timings, Quantity quantity) {
  const auto value_of = [&](const BenchRow& row) {
    return quantity == Quantity::seconds             ? row.seconds_median
           : quantity == Quantity::msites_per_second ? row.msites_per_second
                                                     : row.bytes_per_site;
  };
  std::vector<SizeSeries> all;
  for (const SceneTimings::Line& line : timings.lines) {
    SizeSeries series{timings.name_of(line), false, line.active, line.colour, {}};
    for (const SceneTimings::Size& size : timings.sizes) {
      const BenchRow* const row = SceneTimings::find(line, size);
      const auto value = row != nullptr && row->counts() ? value_of(*row) : std::nullopt;
      if (value.value_or(0.0) > 0.0) {
        const bool sampled = quantity == Quantity::seconds;
        series.sizes.push_back(
            {size.width, size.height, *value, sampled ? row->seconds : std::vector<double>{}});
      }
    }
    if (!series.sizes.empty()) {
      all.push_back(std::move(series));
    }
  }
  if (all.empty() || quantity != Quantity::seconds) {
    return all;
  }
  SizeSeries gpu{"thesis GPU", true, false, 0, {}};
  SizeSeries cpu{"thesis CPU", true, false, 0, {}};
  for (const PublishedTiming& published : published_timings()) {
    if (published.scene == timings.scene) {
      gpu.sizes.push_back({published.size, published.size, published.gpu_seconds, {}});
      cpu.sizes.push_back({published.size, published.size, published.cpu_seconds, {}});
    }
  }
  for (SizeSeries& series : std::array{std::move(gpu), std::move(cpu)}) {
    if (!series.sizes.empty()) {
      all.push_back(std::move(series));
    }
  }
  return all;
}

std::string thesis_table(const std::string& scene) {
  const auto published = published_timings();
  const auto found = std::ranges::find(published, scene, &PublishedTiming::scene);
  return found == published.end() ? "" : fmt::format("Table {}", found->table);
}

} // namespace hdmbench::report
