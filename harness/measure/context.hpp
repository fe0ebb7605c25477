#pragma once

#include <string>
#include <string_view>

namespace hdmbench {

class Fields;

/// Where, when and from what a result came about.
struct Context {
  std::string machine; ///< "AMD EPYC, 2 cores"
  std::string cpu;
  unsigned cores = 0;
  std::string architecture;
  std::string operating_system;
  std::string compiler;
  std::string flags;
  std::string commit;
  std::string version;
  std::string date;      ///< UTC, ISO 8601, so that texts sort as times
  std::string arguments; ///< of the command line, without the program's name: "verify square --size 300"
  bool quick = false;
};

void list_fields(Fields& fields, Context& context);

/// Of this program here and now.
[[nodiscard]] Context run_context(std::string_view arguments, bool quick);

} // namespace hdmbench
