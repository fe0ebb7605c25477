#include "harness/ranks/message_passing.hpp"

#include "backends/shared/stopwatch.hpp"

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

class MpiRanks final : public Ranks {
public:
  MpiRanks() {
    int provided = 0; // threads of a rank compute, one of them speaks
    require(MPI_Init_thread(nullptr, nullptr, MPI_THREAD_FUNNELED, &provided), "MPI_Init_thread");
    require(MPI_Comm_set_errhandler(MPI_COMM_WORLD, MPI_ERRORS_RETURN), "MPI_Comm_set_errhandler");
    MPI_Comm_rank(MPI_COMM_WORLD, &rank_);
    MPI_Comm_size(MPI_COMM_WORLD, &size_);
    require_that_all_answer();
    require(MPI_Comm_dup(MPI_COMM_WORLD, &ending_), "MPI_Comm_dup");
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

  std::vector<Message> exchange(std::span<const Transfer> ways, std::vector<Message> leaving, int arrays,
                                Purpose /*purpose*/) override {
    const Stopwatch watch(traffic_.seconds);
    std::vector<Message> arrived;
    for (const Transfer& way : ways) {
      if (way.to == static_cast<std::size_t>(rank_)) {
        const std::size_t values = way.sites.extent().sites() * static_cast<std::size_t>(arrays);
        arrived.push_back({.way = way, .values = std::vector<float>(values)});
      }
    }
    // Two ranks that have several ways between them send and receive in the order of the ways.
    std::vector<MPI_Request> requests;
    for (Message& message : arrived) {
      require(MPI_Irecv(message.values.data(), count_of(message.values.size()), MPI_FLOAT,
                        static_cast<int>(message.way.from), 0, MPI_COMM_WORLD, &requests.emplace_back()),
              "MPI_Irecv");
    }
    for (const Message& message : leaving) {
      require(MPI_Isend(message.values.data(), count_of(message.values.size()), MPI_FLOAT,
                        static_cast<int>(message.way.to), 0, MPI_COMM_WORLD, &requests.emplace_back()),
              "MPI_Isend");
      ++traffic_.messages;
      traffic_.bytes += static_cast<std::int64_t>(message.values.size() * sizeof(float));
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

  /// Each but the first one waits a little longer than the one before it, so that where not all end one
  /// speaks and ends the others.
  bool all_end() const override { return all_come_within(0.3 + 0.02 * std::min(rank_, 50)); }

  void end_all(int status) override {
    MPI_Abort(MPI_COMM_WORLD, status);
    std::_Exit(status);
  }

private:
  /// Whether all ranks call this.
  [[nodiscard]] bool all_come_within(double seconds) const {
    const Clock clock;
    MPI_Request request = MPI_REQUEST_NULL;
    int done = MPI_Ibarrier(ending_, &request) == MPI_SUCCESS ? 0 : -1;
    while (done == 0 && clock.seconds() < seconds &&
           MPI_Test(&request, &done, MPI_STATUS_IGNORE) == MPI_SUCCESS) {
      std::this_thread::sleep_for(std::chrono::microseconds(100));
    }
    return done > 0;
  }

  /// MPI_Init is over on all ranks. One that had no memory for messages within its machine then listens
  /// elsewhere, and what the others send it is lost.
  void require_that_all_answer() const {
    constexpr double seconds = 10.0;
    if (!all_come_within(seconds + 0.02 * std::min(rank_, 50))) {
      throw DeviceError(fmt::format("not all ranks answered within {:g} s after MPI had started them; has "
                                    "each enough memory (ulimit -v)?",
                                    seconds));
    }
  }

  MPI_Comm ending_ = MPI_COMM_WORLD; ///< for all_come_within() alone: others may be in another call
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
