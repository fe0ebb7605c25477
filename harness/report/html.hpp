#pragma once

#include <cstddef>
#include <string>
#include <string_view>

/// Texts for an HTML page.
namespace hdmbench::report {

/// For element content and quoted attributes of HTML and XML. Control characters become U+FFFD, except tab
/// and newline.
[[nodiscard]] std::string escape(std::string_view text);

[[nodiscard]] std::string base64(std::string_view bytes);

} // namespace hdmbench::report
