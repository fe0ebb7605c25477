#pragma once

#include "backends/shared/subprocess.hpp"

#include <cstdio>
#include <string>

#include <fcntl.h>
#include <unistd.h>

namespace hdmbench::test {

/// Catches what this process, its libraries included, writes to stdout or stderr while the object exists.
class CapturedStream {
public:
  explicit CapturedStream(std::FILE* stream)
      : stream_(stream), before_(dup(fileno(stream))),
        ours_(open(file_.path().c_str(), O_WRONLY | O_APPEND)) {
    std::fflush(stream_);
    dup2(ours_, fileno(stream_));
  }
  CapturedStream(const CapturedStream&) = delete;
  CapturedStream& operator=(const CapturedStream&) = delete;
  ~CapturedStream() {
    std::fflush(stream_);
    dup2(before_, fileno(stream_));
    close(ours_);
    close(before_);
  }

  /// All of it since this was last asked.
  [[nodiscard]] std::string take() {
    std::fflush(stream_);
    std::string text = file_text(file_.path());
    return ftruncate(ours_, 0) == 0 ? text : text + " and more";
  }

private:
  MemoryFile file_;
  std::FILE* stream_;
  int before_;
  int ours_;
};

} // namespace hdmbench::test
