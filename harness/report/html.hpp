#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

/// Texts for an HTML page: escaping, numbers, anchors, embedded files.
namespace hdmbench::report {

/// For element content and quoted attributes. Control characters become U+FFFD, except tab and newline.
[[nodiscard]] std::string escape(std::string_view text);

/// Three significant digits, never an exponent: "0.0412", "1.27", "67.0", "1056".
[[nodiscard]] std::string seconds_text(double seconds);

/// "52.8×" from 10 down to "1.04×", "531×".
[[nodiscard]] std::string speed_up_text(double speed_up);

/// Digits in groups of three, split by a narrow no-break space.
[[nodiscard]] std::string count_text(std::int64_t count);

/// "300 × 600" with no-break spaces.
[[nodiscard]] std::string size_text(std::int64_t width, std::int64_t height);

/// "1 comparison", "2 comparisons".
[[nodiscard]] std::string plural(std::int64_t count, std::string_view noun);

/// Unique ids of one page.
class Anchors {
public:
  /// Letters, digits and hyphens of `text`, numbered where it was given before.
  [[nodiscard]] std::string unique(std::string_view text);

private:
  std::map<std::string, int> given_;
};

/// <h2> or <h3> with an anchor that links to itself. `title` is plain text.
[[nodiscard]] std::string heading(int level, std::string_view id, std::string_view title);

/// <details>: `content` folded under `summary`, both HTML; nothing where there is no content.
[[nodiscard]] std::string folded(std::string_view summary, std::string_view content, bool open = false);

/// Opens a table in a box of its own that scrolls, with one row of headings: to be closed by table_end. A
/// heading that begins with '>' stands over numbers, to the right. `headings` are HTML.
[[nodiscard]] std::string table_start(std::string_view css_class,
                                      const std::vector<std::string_view>& headings);
inline constexpr std::string_view table_end = "</tbody></table></div>\n";

/// A PNG file as a data URI together with its size in pixels.
struct EmbeddedPng {
  std::string uri;
  std::uint32_t width = 0;
  std::uint32_t height = 0;
};
/// Throws InputError naming the file where it is missing or not PNG.
[[nodiscard]] EmbeddedPng embed_png(const std::filesystem::path& file);

[[nodiscard]] std::string base64(std::string_view bytes);

} // namespace hdmbench::report
