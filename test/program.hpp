#pragma once

#include "test/suite.hpp"

#include <nlohmann/json.hpp>
#include <sys/wait.h>

namespace hdmbench::test {

struct Outcome {
  int status;
  std::string output; ///< standard output and standard error
};

/// Runs the program as a user would. `environment` stands before it: "NAME=VALUE".
inline Outcome hdmbench(const std::string& arguments, const std::string& environment = "") {
  const std::string command = environment + " '" HDMBENCH_PROGRAM "' " + arguments + " 2>&1";
  FILE* pipe = popen(command.c_str(), "r");
  std::string output;
  std::array<char, 4096> buffer{};
  for (std::size_t n = 0; (n = std::fread(buffer.data(), 1, buffer.size(), pipe)) > 0;) {
    output.append(buffer.data(), n);
  }
  const int code = pclose(pipe);
  return {WIFEXITED(code) ? WEXITSTATUS(code) : 128, output};
}

inline nlohmann::json read_json(const std::filesystem::path& file) {
  return nlohmann::json::parse(std::ifstream(file));
}

/// Runs it and expects of the exit status and of what it says; `says` is a matcher.
inline Outcome expect_run(int status, const std::string& arguments,
                          const testing::Matcher<std::string>& says = testing::_,
                          const std::string& environment = "") {
  Outcome outcome = hdmbench(arguments, environment);
  EXPECT_EQ(outcome.status, status) << arguments << '\n' << outcome.output;
  EXPECT_THAT(outcome.output, testing::AllOf(says, testing::Not(testing::HasSubstr("internal error"))))
      << arguments;
  return outcome;
}

} // namespace hdmbench::test
