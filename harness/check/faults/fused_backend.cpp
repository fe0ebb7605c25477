#include "harness/check/faults/fused_backend.hpp"

#include "backends/cpu/elastic_serial.hpp"
#include "backends/cpu/processor.hpp"
#include "harness/check/energy_proofs.hpp"
#include "harness/check/fused_real.hpp"

#include <utility>

namespace hdmbench::faults {

namespace {

class FusedSession final : public Session {
  void do_load(const Level& level) override {
    level_ = level;
    next_ = VectorField(level.extent);
  }
  void do_write(const VectorField& displacement) override { current_ = displacement; }
  void do_read(VectorField& displacement) override { displacement = current_; }
  std::int64_t do_changed() override { return changed_; }

  void do_step(int first, int sweeps) override {
    for (int number = first; number < first + sweeps; ++number) {
      sweep(number);
      std::swap(current_, next_);
    }
  }

  void sweep(int number) {
    const auto swept = proofs_of(*level_.energy).fused_answer;
    changed_ = 0;
    for (int y = 0; y < level_.extent.height; ++y) {
      for (int x = 0; x < level_.extent.width; ++x) {
        const std::size_t at = level_.extent.index(x, y);
        const SiteAnswer next = swept(level_, current_, number, x, y);
        next_.x[at] = next.x;
        next_.y[at] = next.y;
        changed_ += (next_.x[at] != current_.x[at] || next_.y[at] != current_.y[at]) ? 1 : 0;
      }
    }
  }

  Level level_;
  VectorField current_;
  VectorField next_;
  std::int64_t changed_ = 0;
};

class Fused final : public Backend {
public:
  std::string_view name() const override { return "fused"; }
  std::string_view description() const override { return "plain C++ with fused multiply-adds"; }
  std::vector<Device> devices() const override { return {cpu_device("1 thread")}; }
  bool has_elastic() const override { return true; }

private:
  std::unique_ptr<Session> do_open(std::size_t /*index*/, const SessionOptions& /*options*/) const override {
    return std::make_unique<FusedSession>();
  }
  std::unique_ptr<ElasticSession> do_open_elastic(std::size_t /*index*/,
                                                  const SessionOptions& /*options*/) const override {
    return std::make_unique<ElasticSerial<fused::real>>();
  }
};

} // namespace

std::unique_ptr<Backend> make_fused() {
  return std::make_unique<Fused>();
}

} // namespace hdmbench::faults
