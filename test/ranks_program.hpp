#pragma once

#include "test/program.hpp"
#include "test/temporary_folder.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <string_view>

namespace hdmbench::test {

/// Before the program: mpirun for root in a container, with more ranks than processors. Without the search
/// for network cards, and without the second between SIGTERM and SIGKILL: these take longer than most runs.
/// mpirun's hwloc is not to ask OpenCL's drivers, of which PoCL aborts it where there is no /sys.
inline const std::string mpirun =
    "HWLOC_COMPONENTS=-opencl OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 OMPI_MCA_pml=ob1 "
    "OMPI_MCA_btl=self,vader,tcp "
    "OMPI_MCA_odls_base_sigkill_timeout=0 '" HDMBENCH_MPIEXEC "' --oversubscribe ";

inline std::string on_ranks(int ranks) {
  return fmt::format("{}-n {}", mpirun, ranks);
}

/// Empty where there is no such file.
inline std::string bytes(const std::filesystem::path& file) {
  std::ostringstream text;
  text << std::ifstream(file, std::ios::binary).rdbuf();
  return text.str();
}

inline std::size_t files_in(const std::filesystem::path& folder) {
  return std::filesystem::exists(folder)
             ? static_cast<std::size_t>(std::distance(std::filesystem::directory_iterator(folder), {}))
             : 0;
}

/// Several processes of the program. Skipped where the build has no MPI.
class RankProgram : public testing::Test {
protected:
  void SetUp() override {
    if (std::string_view(HDMBENCH_MPIEXEC).empty()) {
      GTEST_SKIP() << "this build has no MPI (-DHDMBENCH_MPI=ON, libopenmpi-dev)";
    }
  }

  [[nodiscard]] std::string path(const std::string& name) const { return (folder_.path() / name).string(); }

  TemporaryFolder folder_;
};

} // namespace hdmbench::test
