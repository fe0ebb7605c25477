// Result files: what the report reads.

#include "harness/report/results.hpp"
#include "test/fuzz/input.hpp"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace hdmbench;
  fuzz::expect_an_answer([&] {
    const auto file = fuzz::file_with("results.json", fuzz::as_text(data, size));
    (void)report::load_results({&file, 1});
  });
  return 0;
}
