#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

/// What `bench --compare --json` wrote, typed and checked.
namespace hdmbench::report {

class JsonReader;

/// The timings of one computation before and after.
struct CompareRow {
  std::size_t context = 0; ///< index into Results::contexts
  std::string scene;
  std::int64_t width = 0;
  std::int64_t height = 0;
  std::string backend;
  std::string device;
  std::string method;
  std::optional<std::int64_t> threads;
  std::string old_commit; ///< these three: empty or none where the file does not tell
  std::string new_commit;
  std::optional<double> tolerance; ///< 0.05: a ratio up to 1.05 is borne
  bool interleaved = false;        ///< both sides measured in turn
  std::vector<double> old_seconds; ///< raw samples
  std::vector<double> new_seconds;
  std::string remark;
  bool compared = false; ///< false: what follows is not there, the remark says why
  std::string verdict;   ///< comparison::change_names
  double ratio = 1.0;    ///< new over old
  double ratio_low = 1.0;
  double ratio_high = 1.0;
  double coverage = 0.0; ///< of [ratio_low, ratio_high]
  double p = 1.0;
  double old_spread = 0.0; ///< relative
  double new_spread = 0.0;
  double largest_good_spread = 0.0; ///< with more, a change of the tolerance's size is easily overlooked
  bool slower_than_tolerated = false;

  [[nodiscard]] bool noisy() const {
    return compared && (old_spread > largest_good_spread || new_spread > largest_good_spread);
  }
};

/// One element of "results". Throws InputError naming file and key for what is missing, mistyped or
/// contradicts itself: a ratio outside its interval, a regression that is not called slower.
[[nodiscard]] CompareRow read_compare(const JsonReader& json);

} // namespace hdmbench::report
