#include "backends/scalar.hpp"
#include "backends/cpu_device.hpp"

#include "kernels/gather.hpp"

namespace hdmbench {

namespace {

/// The specification read aloud: one thread, one site after the other.
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
    for (int number = first; number < first + sweeps; ++number) {
      if (level_.update == Update::sequential) {
        sweep(number, current_, current_);
      } else {
        sweep(number, current_, next_);
        std::swap(current_, next_);
      }
    }
  }

  /// from and to may be the same field: then a site sees its predecessors' new values.
  void sweep(int number, const VectorField& from, VectorField& to) {
    const SweepState state = sweep_state(level_, number);
    const energy::Sweep sweep{state.colour, state.strength, state.number, state.seed};
    const int rule = static_cast<int>(level_.rule);
    const int colours = sweeps_per_iteration(level_.update);
    changed_ = 0;
    for (int y = 0; y < level_.extent.height; ++y) {
      for (int x = 0; x < level_.extent.width; ++x) {
        const energy::Site site = energy::gather(level_, from, x, y);
        const energy::Position at{static_cast<float>(x), static_cast<float>(y)};
        const energy::Displacement next = energy::swept_displacement(
            rule, colours, site, at, sweep, level_.steps.padded().data(), level_.steps.count());
        changed_ += (next.x != site.dx.centre || next.y != site.dy.centre) ? 1 : 0;
        const std::size_t index = level_.extent.index(x, y);
        to.x[index] = next.x;
        to.y[index] = next.y;
      }
    }
  }

  Level level_;
  VectorField current_;
  VectorField next_;
  std::int64_t changed_ = 0;
};

class Scalar final : public Backend {
public:
  std::string_view name() const override { return "scalar"; }
  std::string_view description() const override { return "plain C++, one thread: the reference for bits"; }
  bool supports(Update /*update*/) const override { return true; }
  std::vector<Device> devices() const override { return {cpu_device("1 thread")}; }

private:
  std::unique_ptr<Session> do_open(std::size_t /*index*/, const SessionOptions& /*options*/) const override {
    return std::make_unique<ScalarSession>();
  }
};

} // namespace

std::unique_ptr<Backend> make_scalar() {
  return std::make_unique<Scalar>();
}

} // namespace hdmbench
