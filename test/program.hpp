#pragma once

#include <sys/wait.h>

#include <array>
#include <cstdio>
#include <string>

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

} // namespace hdmbench::test
