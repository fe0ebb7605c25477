#include "backends/cpu/cpu_device.hpp"

#include <fstream>
#include <string>

namespace hdmbench {

Device cpu_device(std::string_view driver) {
  std::ifstream file("/proc/cpuinfo");
  std::string line;
  std::string name = "CPU";
  while (std::getline(file, line)) {
    const auto colon = line.find(": ");
    if (line.starts_with("model name") && colon != std::string::npos) {
      name = line.substr(colon + 2);
      break;
    }
  }
  return {.name = name, .driver = std::string(driver), .is_software = false};
}

} // namespace hdmbench
