#pragma once

#include <cstddef>
#include <string>
#include <string_view>

/// Texts for an HTML page.
namespace hdmbench::report {

/// For element content and quoted attributes of HTML and XML, of what is printable().
[[nodiscard]] std::string escape(std::string_view text);

[[nodiscard]] std::string base64(std::string_view bytes);

} // namespace hdmbench::report
