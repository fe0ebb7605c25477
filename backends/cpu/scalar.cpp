#include "backends/cpu/cpu.hpp"
#include "backends/cpu/elastic_serial.hpp"
#include "backends/shared/arithmetic.hpp"
#include "backends/shared/energy_programs.hpp"
#include "kernels/specification/language.hpp"

#include <cmath>

namespace hdmbench {

namespace {

using real = float;
using std::exp;
using std::sqrt;

#include "kernels/specification/probe.inc"

class ScalarSession final : public Session {
  void do_load(const Level& level) override {
    level_ = level;
    current_ = VectorField(level.extent);
    next_ = VectorField(level.extent);
  }

  void do_write(const VectorField& displacement) override { current_ = displacement; }
  void do_read(VectorField& displacement) override { displacement = current_; }
  std::int64_t do_changed() override { return changed_; }

  void do_step(int first, int sweeps) override {
    const auto sweep = programs_of(*level_.energy).scalar_sweep;
    for (int number = first; number < first + sweeps; ++number) {
      if (level_.update == Update::sequential) {
        changed_ = sweep(level_, number, current_, current_);
      } else {
        changed_ = sweep(level_, number, current_, next_);
        std::swap(current_, next_);
      }
    }
  }

  Level level_;
  VectorField current_;
  VectorField next_;
  std::int64_t changed_ = 0;
};

class Scalar final : public Backend, public ArithmeticProgram {
public:
  std::string_view language() const override { return "C++"; }
  std::vector<float> evaluate(std::size_t /*device*/, std::span<const ArithmeticCase> cases) const override {
    return evaluate_in_cpp(cases);
  }

  std::string_view name() const override { return "scalar"; }
  std::string_view description() const override { return "plain C++, one thread: the reference for bits"; }
  bool supports(Update /*update*/) const override { return true; }
  std::vector<Device> devices() const override { return {cpu_device("1 thread")}; }
  int threads(const SessionOptions& /*options*/) const override { return 1; }
  bool skips() const override { return false; }
  bool takes_volumes() const override { return true; }
  bool has_elastic() const override { return true; }
  /// Displacement there and back, target, confidence, modulus and its inverse.
  double bytes_per_update(SiteKind /*kind*/, int /*sweeps*/) const override { return 8 + 8 + 8 + 8 + 4 + 4; }

private:
  std::unique_ptr<ElasticSession> do_open_elastic(std::size_t /*index*/,
                                                  const SessionOptions& /*options*/) const override {
    return std::make_unique<ElasticSerial<float>>();
  }
  std::optional<Ceilings> do_measure_ceilings(std::size_t /*index*/,
                                              const SessionOptions& /*options*/) const override {
    return cpu_ceilings(1, openmp::baseline::multiply_add);
  }
  std::unique_ptr<Session> do_open(std::size_t /*index*/, const SessionOptions& /*options*/) const override {
    return std::make_unique<ScalarSession>();
  }
};

} // namespace

std::vector<float> evaluate_in_cpp(std::span<const ArithmeticCase> cases) {
  std::vector<float> results;
  results.reserve(cases.size());
  for (const ArithmeticCase& one : cases) {
    results.push_back(probed(one[5], one[0], one[1], one[2], one[3], one[4]));
  }
  return results;
}

std::unique_ptr<Backend> make_scalar() {
  return std::make_unique<Scalar>();
}

} // namespace hdmbench
