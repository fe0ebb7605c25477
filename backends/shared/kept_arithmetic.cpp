#include "backends/shared/kept_arithmetic.hpp"

#include <fmt/format.h>

#include <array>
#include <cfenv>
#include <limits>
#include <map>
#include <mutex>

namespace hdmbench {

namespace {

/// What the driver of each backend has changed.
struct Changes {
  std::mutex guard;
  std::map<std::string, std::string, std::less<>> found;
};

Changes& changes() {
  static Changes all;
  return all;
}

/// Volatile, so that the processor computes and not the compiler.
template <typename Real>
bool is_zero_below(Real factor) {
  volatile Real smallest = std::numeric_limits<Real>::min();
  volatile Real below = smallest * factor;
  return below == Real(0);
}

/// Looks at a product: a comparison would take a subnormal operand for 0, too.
bool subnormal_operands_are_zero() {
  volatile float operand = std::numeric_limits<float>::denorm_min();
  volatile float product = operand * 0x1p100F;
  return product == 0.0F;
}

} // namespace

std::string changes_of_arithmetic() {
  const std::array<const char*, 3> texts{
      is_zero_below(0.5F) || is_zero_below(0.5) ? "subnormal results are 0" : "",
      subnormal_operands_are_zero() ? "subnormal operands are 0" : "",
      std::fegetround() != FE_TONEAREST ? "results are not rounded to nearest" : ""};
  std::string all;
  for (const std::string text : texts) {
    all += (all.empty() || text.empty() ? "" : ", ") + text;
  }
  return all;
}

KeptArithmetic::KeptArithmetic(std::string_view whose) : whose_(whose) {
  std::fesetenv(FE_DFL_ENV);
}

KeptArithmetic::~KeptArithmetic() {
  const std::string found = changes_of_arithmetic();
  std::fesetenv(FE_DFL_ENV);
  if (!found.empty()) {
    const std::lock_guard lock(changes().guard);
    changes().found.try_emplace(whose_, found);
  }
}

std::string changed_arithmetic(std::string_view backend) {
  const std::lock_guard lock(changes().guard);
  const auto found = changes().found.find(backend);
  return found == changes().found.end() ? "" : found->second;
}

std::vector<std::string> all_changed_arithmetic() {
  const std::lock_guard lock(changes().guard);
  std::vector<std::string> sentences;
  for (const auto& [backend, found] : changes().found) {
    sentences.push_back(fmt::format("a driver of {} has changed the arithmetic of the whole program ({}); it "
                                    "was set back each time",
                                    backend, found));
  }
  return sentences;
}

} // namespace hdmbench
