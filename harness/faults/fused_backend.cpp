#include "harness/faults/fused_backend.hpp"

#include "backends/cpu_device.hpp"
#include "kernels/energy_macros.hpp"
#include "kernels/gather.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace hdmbench::faults {

namespace {

namespace fused {

/// Not yet rounded: rounded when it is used as a number, fused when it is added.
struct Product {
  float a;
  float b;
};

struct real {
  float value = 0.0F;

  real() = default;
  // Implicit, as energy.inc and update.inc write constants and results.
  real(int constant) : value(static_cast<float>(constant)) {}
  real(double constant) : value(static_cast<float>(constant)) {}
  real(float value_) : value(value_) {}
  real(Product product) : value(product.a * product.b) {}

  friend real operator+(real a, real b) { return a.value + b.value; }
  friend real operator-(real a, real b) { return a.value - b.value; }
  friend Product operator*(real a, real b) { return {a.value, b.value}; }
  friend bool operator<(real a, real b) { return a.value < b.value; }
  friend bool operator>(real a, real b) { return a.value > b.value; }
  friend bool operator<=(real a, real b) { return a.value <= b.value; }
  friend bool operator>=(real a, real b) { return a.value >= b.value; }
  friend bool operator==(real a, real b) { return a.value == b.value; }
};

real operator+(real a, Product b) {
  return std::fma(b.a, b.b, a.value);
}
real operator+(Product a, real b) {
  return b + a;
}
real operator-(real a, Product b) {
  return std::fma(-b.a, b.b, a.value);
}
real operator-(Product a, real b) {
  return std::fma(a.a, a.b, -b.value);
}

HDM_FUNCTION real abs(real a) {
  return std::abs(a.value);
}
HDM_FUNCTION real floor(real a) {
  return std::floor(a.value);
}

#include "kernels/energy.inc"
#include "kernels/update.inc"

} // namespace fused

class FusedSession final : public Session {
  void do_load(const Level& level) override {
    level_ = level;
    next_ = VectorField(level.extent);
    std::ranges::copy(level.steps.padded(), steps_.begin());
  }
  void do_write(const VectorField& displacement) override { current_ = displacement; }
  void do_read(VectorField& displacement) override { displacement = current_; }
  std::int64_t do_changed() override { return changed_; }

  void do_step(int first, int sweeps) override {
    for (int number = first; number < first + sweeps; ++number) {
      sweep(sweep_state(level_, number));
      std::swap(current_, next_);
    }
  }

  void sweep(const SweepState& state) {
    const fused::Sweep turn{state.colour, state.strength, state.number, state.seed};
    const int rule = static_cast<int>(level_.rule);
    const int colours = sweeps_per_iteration(level_.update);
    changed_ = 0;
    for (int y = 0; y < level_.extent.height; ++y) {
      for (int x = 0; x < level_.extent.width; ++x) {
        const std::size_t at = level_.extent.index(x, y);
        const fused::Displacement next = fused::swept_displacement(
            rule, colours, energy::converted<fused::Site>(energy::gather(level_, current_, x, y)), {x, y},
            turn, steps_.data(), level_.steps.count());
        next_.x[at] = next.x.value;
        next_.y[at] = next.y.value;
        changed_ += (next_.x[at] != current_.x[at] || next_.y[at] != current_.y[at]) ? 1 : 0;
      }
    }
  }

  Level level_;
  VectorField current_;
  VectorField next_;
  std::array<fused::real, StepSet::maximum_count> steps_;
  std::int64_t changed_ = 0;
};

class Fused final : public Backend {
public:
  std::string_view name() const override { return "fused"; }
  std::string_view description() const override { return "plain C++ with fused multiply-adds"; }
  std::vector<Device> devices() const override { return {cpu_device("1 thread")}; }

private:
  std::unique_ptr<Session> do_open(std::size_t /*index*/, const SessionOptions& /*options*/) const override {
    return std::make_unique<FusedSession>();
  }
};

} // namespace

std::unique_ptr<Backend> make_fused() {
  return std::make_unique<Fused>();
}

} // namespace hdmbench::faults
