#include "backends/scalar.hpp"
#include "backends/cpu_ceilings.hpp"
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
        sweep_by_rule(number, current_, current_);
      } else {
        sweep_by_rule(number, current_, next_);
        std::swap(current_, next_);
      }
    }
  }

  void sweep_by_rule(int number, const VectorField& from, VectorField& to) {
    switch (level_.rule) {
    case Rule::steps:
      return sweep_by_colours<energy::rule_steps>(number, from, to);
    case Rule::closed_form:
      return sweep_by_colours<energy::rule_closed_form>(number, from, to);
    case Rule::correction:
      return sweep_by_colours<energy::rule_correction>(number, from, to);
    case Rule::annealing:
      return sweep_by_colours<energy::rule_annealing>(number, from, to);
    }
  }

  template <int rule>
  void sweep_by_colours(int number, const VectorField& from, VectorField& to) {
    switch (sweeps_per_iteration(level_.update)) {
    case 2:
      return sweep<rule, 2>(number, from, to);
    case 4:
      return sweep<rule, 4>(number, from, to);
    default:
      return sweep<rule, 1>(number, from, to);
    }
  }

  /// from and to may be the same field: then a site sees its predecessors' new values. Rule and colours are
  /// constants, as update.inc wants them.
  template <int rule, int colours>
  void sweep(int number, const VectorField& from, VectorField& to) {
    const SweepState state = sweep_state(level_, number);
    const energy::Sweep turn{state.colour, state.strength, state.number, state.seed};
    const energy::real* steps = level_.steps.padded().data();
    const int step_count = level_.steps.count();
    changed_ = 0;
    for (int y = 0; y < level_.extent.height; ++y) {
      for (int x = 0; x < level_.extent.width; ++x) {
        const energy::Site site = energy::gather(level_, from, x, y);
        const energy::Position at{static_cast<float>(x), static_cast<float>(y)};
        const energy::Displacement next =
            energy::swept_displacement(rule, colours, site, at, turn, steps, step_count);
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
  int threads(const SessionOptions& /*options*/) const override { return 1; }
  bool skips() const override { return false; }
  /// Displacement there and back, target, confidence, modulus and its inverse.
  double bytes_per_update(SiteKind /*kind*/, int /*sweeps*/) const override { return 8 + 8 + 8 + 8 + 4 + 4; }

private:
  std::optional<Ceilings> do_measure_ceilings(std::size_t /*index*/,
                                              const SessionOptions& /*options*/) const override {
    return cpu_ceilings(1, openmp::baseline::multiply_add);
  }
  std::unique_ptr<Session> do_open(std::size_t /*index*/, const SessionOptions& /*options*/) const override {
    return std::make_unique<ScalarSession>();
  }
};

} // namespace

std::unique_ptr<Backend> make_scalar() {
  return std::make_unique<Scalar>();
}

} // namespace hdmbench
