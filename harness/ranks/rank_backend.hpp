#pragma once

#include "backends/backend.hpp"
#include "harness/check/whole_method.hpp"
#include "harness/ranks/crew.hpp"

#include <string>

namespace hdmbench {

/// Several ranks as one backend, on the first of them: what verifies a backend verifies them. Devices and
/// orders of update are those of the backend of the first rank.
class RankBackend final : public Backend, public WholeMethod {
public:
  /// Crew and `first` must outlive it. `fault`: a name of faults::rank_faults(), or empty.
  RankBackend(Crew& crew, const Backend& first, std::string backends, Sharing sharing,
              std::string fault = {});

  /// "openmp on 4 ranks".
  std::string_view name() const override { return name_; }
  std::string_view description() const override { return "a backend on several ranks"; }
  bool supports(Update update) const override {
    return update != Update::sequential && first_.supports(update);
  }
  std::vector<Device> devices() const override { return first_.devices(); }
  bool has_elastic() const override { return first_.has_elastic(); }

  VectorField solve(const Scene& scene) const override;

  /// "openmp", without the ranks.
  [[nodiscard]] const std::string& backends() const { return backends_; }
  [[nodiscard]] int ranks() const { return sharing_.pieces; }
  /// Whether no rounding excuses a difference: what processors compute has the bits of scalar.
  [[nodiscard]] bool has_bits_of_scalar() const { return first_.threads({}) > 0; }

private:
  std::unique_ptr<Session> do_open(std::size_t index, const SessionOptions& options) const override;

  std::unique_ptr<ElasticSession> do_open_elastic(std::size_t index,
                                                  const SessionOptions& options) const override;

  Crew& crew_;
  const Backend& first_;
  std::string backends_;
  Sharing sharing_;
  std::string fault_;
  std::string name_;
};

} // namespace hdmbench
