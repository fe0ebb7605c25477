#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

/// What `verify --json` wrote, typed and checked.
namespace hdmbench::report {

class JsonReader;

enum class Verdict { agree, certified, disagree, mistrusted, skipped };

enum class Tier { none, certified, bitwise, exact }; // the strongest last
inline constexpr std::array<std::string_view, 4> tier_names{"none", "certified", "bitwise", "exact"};

struct FirstDifference {
  std::int64_t level = 0;
  std::int64_t iteration = 0;
  std::int64_t x = 0;
  std::int64_t y = 0;
  std::string more; ///< whatever else the file tells about it: "reference 0.1, found 0.2"
};

struct VerifyRow {
  std::size_t context = 0; ///< index into Results::contexts
  std::string scene;
  std::int64_t width = 0;
  std::int64_t height = 0;
  std::string backend;
  std::string device;
  std::string method; ///< empty where the file does not tell
  std::string mode;
  std::int64_t levels = 0;
  std::int64_t iterations = 0;
  std::int64_t sites_compared = 0;
  std::int64_t sites_differing = 0;
  std::int64_t certified_ties = 0;
  std::int64_t uncertified = 0;
  std::int64_t not_finite = 0; ///< differing sites that are NaN or infinite; 0 where the file does not tell
  std::int64_t counts_differing = 0; ///< iterations whose number of changed sites was wrong; 0 as above
  std::optional<double> max_abs_difference; ///< pixels; none: not finite
  std::optional<FirstDifference> first_difference;
  Tier tier = Tier::none;
  Verdict verdict = Verdict::skipped;
  std::string reason;
};

/// One element of "results". Throws InputError naming file and key for what is missing, mistyped or
/// contradicts itself: a row that "agrees" with differing sites.
[[nodiscard]] VerifyRow read_verify(const JsonReader& json);

} // namespace hdmbench::report
