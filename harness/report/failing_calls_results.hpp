#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

/// What test/failing_calls wrote, typed and checked.
namespace hdmbench::report {

class JsonReader;

/// One way to fail, for one call after the other, under one backend.
struct FailingCallsRow {
  std::size_t context = 0; ///< index into Results::contexts
  std::string backend;
  std::string api;            ///< "OpenGL"
  std::string kind;           ///< "GL_OUT_OF_MEMORY"
  std::int64_t calls = 0;     ///< of a run, that can fail so
  std::int64_t failed = 0;    ///< of them, a run each
  std::int64_t clean = 0;     ///< said the call and the reason, left nothing behind
  std::int64_t succeeded = 0; ///< right bits without the call
  std::int64_t went_on = 0;   ///< of the clean ones: the same session computed the right bits afterwards
  std::vector<std::string> unclean; ///< all others, in words
};

/// One element of "results". Throws InputError naming file and key for what is missing, mistyped or does not
/// add up.
[[nodiscard]] FailingCallsRow read_failing_calls(const JsonReader& json);

} // namespace hdmbench::report
