#include "backends/cpu/cpu.hpp"
#include "backends/cpu/elastic_serial.hpp"

namespace hdmbench {

std::unique_ptr<ElasticSession> make_elastic_scalar() {
  return std::make_unique<ElasticSerial<float>>();
}

} // namespace hdmbench
