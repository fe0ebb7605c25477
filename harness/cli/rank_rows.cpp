#include "harness/cli/rank_rows.hpp"

#include <unistd.h>

#include <array>

namespace hdmbench::commands {

std::string machine_name() {
  std::array<char, 256> name{};
  return gethostname(name.data(), name.size() - 1) == 0 ? name.data() : "";
}

} // namespace hdmbench::commands
