#pragma once

#include <string>
#include <string_view>
#include <vector>

/// The arithmetic that the specification means rounds to nearest and keeps subnormal numbers. Both are
/// switches of the processor, one set for each thread, and a library can change them for the thread that
/// loads it: what is linked by gcc -Ofast makes subnormal numbers zeros for the whole program. Then the
/// reference itself would compute something else.
namespace hdmbench {

/// What is not as it should be in this thread, for people: "subnormal results are 0"; empty: nothing. Asks
/// the arithmetic itself.
[[nodiscard]] std::string changes_of_arithmetic();

/// Around code that is not ours. The arithmetic of this thread is as it should be from the beginning on and
/// after the end. What a backend has changed in between is kept for changed_arithmetic().
class KeptArithmetic {
public:
  /// `whose`: a backend, whose driver is called.
  explicit KeptArithmetic(std::string_view whose);
  KeptArithmetic(const KeptArithmetic&) = delete;
  KeptArithmetic& operator=(const KeptArithmetic&) = delete;
  ~KeptArithmetic();

private:
  std::string whose_;
};

/// What a driver of the backend has changed in this process so far, as changes_of_arithmetic() has it.
[[nodiscard]] std::string changed_arithmetic(std::string_view backend);
/// A sentence for each backend of which that is so.
[[nodiscard]] std::vector<std::string> all_changed_arithmetic();

} // namespace hdmbench
