#include "harness/ranks/message_passing.hpp"

#include "harness/ranks/launch.hpp"
#include "harness/solve/stopwatch.hpp"
#include "kernels/data/input_error.hpp"

#include <fmt/format.h>
#include <mpi.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdlib>
#include <limits>
#include <numeric>
#include <string_view>
#include <thread>

namespace hdmbench {

namespace {

std::string words(int error) {
  std::array<char, MPI_MAX_ERROR_STRING> text{};
  int length = 0;
  MPI_Error_string(error, text.data(), &length);
  return {text.data(), static_cast<std::size_t>(length)};
}

void require(int error, std::string_view call) {
  if (error != MPI_SUCCESS) {
    throw DeviceError(fmt::format("{}: {}", call, words(error)));
  }
}

/// MPI counts in int.
int count_of(std::size_t elements) {
  if (elements > static_cast<std::size_t>(std::numeric_limits<int>::max())) {
    throw DeviceError(
        fmt::format("a message of {} elements: MPI takes 2147483647; use more ranks", elements));
  }
  return static_cast<int>(elements);
}

class MpiFile final : public SharedFile {
public:
  explicit MpiFile(const std::filesystem::path& file) : name_(file.string()) {
    check(MPI_File_open(MPI_COMM_SELF, name_.c_str(), MPI_MODE_WRONLY, MPI_INFO_NULL, &file_));
  }
  ~MpiFile() override {
    if (file_ != MPI_FILE_NULL) {
      MPI_File_close(&file_);
    }
  }

  void write_at(std::uint64_t offset, std::span<const std::byte> bytes) override {
    MPI_Status status;
    const int count = count_of(bytes.size());
    check(MPI_File_write_at(file_, static_cast<MPI_Offset>(offset), bytes.data(), count, MPI_BYTE, &status));
    int written = 0;
    MPI_Get_count(&status, MPI_BYTE, &written);
    if (written != count) {
      throw InputError(fmt::format("{}: {} of {} bytes were written (disk full?)", name_, written, count));
    }
  }

  void close() override {
    check(MPI_File_sync(file_));
    check(MPI_File_close(&file_));
  }

private:
  void check(int error) const {
    if (error != MPI_SUCCESS) {
      throw InputError(fmt::format("{} cannot be written: {}", name_, words(error)));
    }
  }

  std::string name_;
  MPI_File file_ = MPI_FILE_NULL;
};

class MpiRanks final : public Ranks {
public:
  MpiRanks() {
    int provided = 0; // threads of a rank compute, one of them speaks
    require(MPI_Init_thread(nullptr, nullptr, MPI_THREAD_FUNNELED, &provided), "MPI_Init_thread");
    require(MPI_Comm_set_errhandler(MPI_COMM_WORLD, MPI_ERRORS_RETURN), "MPI_Comm_set_errhandler");
    MPI_Comm_rank(MPI_COMM_WORLD, &rank_);
    MPI_Comm_size(MPI_COMM_WORLD, &size_);
    require_that_all_answer();
    MPI_Comm machine = MPI_COMM_NULL;
    require(MPI_Comm_split_type(MPI_COMM_WORLD, MPI_COMM_TYPE_SHARED, rank_, MPI_INFO_NULL, &machine),
            "MPI_Comm_split_type");
    MPI_Comm_rank(machine, &rank_on_machine_);
    MPI_Comm_size(machine, &size_on_machine_);
    MPI_Comm_free(&machine);
  }
  ~MpiRanks() override { MPI_Finalize(); }

  int rank() const override { return rank_; }
  int size() const override { return size_; }
  int rank_on_machine() const override { return rank_on_machine_; }
  int size_on_machine() const override { return size_on_machine_; }
  Traffic traffic() const override { return traffic_; }

  std::vector<Parcel> exchange(std::span<const Transfer> ways, std::vector<Parcel> leaving,
                               int arrays) override {
    const Stopwatch watch(traffic_.seconds);
    std::vector<Parcel> arrived;
    for (const Transfer& way : ways) {
      if (is_here(way.to)) {
        const std::size_t values = way.sites.extent().sites() * static_cast<std::size_t>(arrays);
        arrived.push_back({.way = way, .values = std::vector<float>(values)});
      }
    }
    // Two ranks that have several ways between them send and receive in the order of the ways.
    std::vector<MPI_Request> requests;
    for (Parcel& parcel : arrived) {
      require(MPI_Irecv(parcel.values.data(), count_of(parcel.values.size()), MPI_FLOAT,
                        static_cast<int>(parcel.way.from), 0, MPI_COMM_WORLD, &requests.emplace_back()),
              "MPI_Irecv");
    }
    for (const Parcel& parcel : leaving) {
      require(MPI_Isend(parcel.values.data(), count_of(parcel.values.size()), MPI_FLOAT,
                        static_cast<int>(parcel.way.to), 0, MPI_COMM_WORLD, &requests.emplace_back()),
              "MPI_Isend");
      ++traffic_.messages;
      traffic_.bytes += static_cast<std::int64_t>(parcel.values.size() * sizeof(float));
    }
    require(MPI_Waitall(count_of(requests.size()), requests.data(), MPI_STATUSES_IGNORE), "MPI_Waitall");
    return arrived;
  }

  std::int64_t sum(std::int64_t own) override {
    std::int64_t all = 0;
    require(MPI_Allreduce(&own, &all, 1, MPI_INT64_T, MPI_SUM, MPI_COMM_WORLD), "MPI_Allreduce");
    return all;
  }

  double largest(double own) override {
    double all = 0.0;
    require(MPI_Allreduce(&own, &all, 1, MPI_DOUBLE, MPI_MAX, MPI_COMM_WORLD), "MPI_Allreduce");
    return all;
  }

  void broadcast(std::vector<std::byte>& bytes) override {
    std::uint64_t size = bytes.size();
    wait_patiently(
        [&](MPI_Request* request) { return MPI_Ibcast(&size, 1, MPI_UINT64_T, 0, MPI_COMM_WORLD, request); });
    bytes.resize(size);
    wait_patiently([&](MPI_Request* request) {
      return MPI_Ibcast(bytes.data(), count_of(bytes.size()), MPI_BYTE, 0, MPI_COMM_WORLD, request);
    });
  }

  std::vector<std::string> gather(const std::string& own) override {
    const int length = count_of(own.size());
    std::vector<int> lengths(is_first() ? static_cast<std::size_t>(size_) : 0);
    require(MPI_Gather(&length, 1, MPI_INT, lengths.data(), 1, MPI_INT, 0, MPI_COMM_WORLD), "MPI_Gather");
    std::vector<int> begins(lengths.size());
    std::exclusive_scan(lengths.begin(), lengths.end(), begins.begin(), 0);
    std::string all(static_cast<std::size_t>(std::reduce(lengths.begin(), lengths.end())), '\0');
    require(MPI_Gatherv(own.data(), length, MPI_CHAR, all.data(), lengths.data(), begins.data(), MPI_CHAR, 0,
                        MPI_COMM_WORLD),
            "MPI_Gatherv");
    std::vector<std::string> texts;
    for (std::size_t i = 0; i < lengths.size(); ++i) {
      texts.push_back(all.substr(static_cast<std::size_t>(begins[i]), static_cast<std::size_t>(lengths[i])));
    }
    return texts;
  }

  std::unique_ptr<SharedFile> open(const std::filesystem::path& file) override {
    return std::make_unique<MpiFile>(file);
  }

  void give_way() const override {
    if (!is_first()) {
      std::this_thread::sleep_for(std::chrono::milliseconds(300 + 20 * std::min(rank_, 50)));
    }
  }

  void end_all(int status) override {
    MPI_Abort(MPI_COMM_WORLD, status);
    std::_Exit(status);
  }

private:
  /// MPI's own waiting keeps the processor busy. Returns false where that took longer than `seconds`.
  template <typename Begin>
  static bool wait_patiently(const Begin& begin, double seconds = std::numeric_limits<double>::infinity()) {
    const auto began = std::chrono::steady_clock::now();
    MPI_Request request = MPI_REQUEST_NULL;
    require(begin(&request), "MPI_Ibcast or MPI_Ibarrier");
    int done = 0;
    for (int tries = 0; done == 0; ++tries) {
      require(MPI_Test(&request, &done, MPI_STATUS_IGNORE), "MPI_Test");
      if (tries > 100) {
        std::this_thread::sleep_for(std::chrono::microseconds(100));
      }
      if (std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count() > seconds) {
        return false;
      }
    }
    return true;
  }

  /// MPI_Init is over on all ranks. One that had no memory for messages within its machine then listens
  /// elsewhere, and what the others send it is lost.
  void require_that_all_answer() const {
    constexpr double seconds = 10.0;
    if (!wait_patiently([](MPI_Request* request) { return MPI_Ibarrier(MPI_COMM_WORLD, request); },
                        seconds)) {
      give_way();
      throw DeviceError(
          fmt::format("not all ranks answered within {:g} s after MPI had started them; has each "
                      "enough memory (ulimit -v)?",
                      seconds));
    }
  }

  int rank_ = 0;
  int size_ = 0;
  int rank_on_machine_ = 0;
  int size_on_machine_ = 0;
  Traffic traffic_;
};

} // namespace

std::unique_ptr<Ranks> Ranks::of_this_process() {
  return launched_together() > 1 ? std::make_unique<MpiRanks>() : nullptr;
}

} // namespace hdmbench
