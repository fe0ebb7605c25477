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

  void do_step(int iterations) override {
    for (int i = 0; i < iterations; ++i) {
      if (level_.update == Update::sequential) {
        sweep(current_, current_);
      } else {
        sweep(current_, next_);
        std::swap(current_, next_);
      }
    }
  }

  /// from and to may be the same field: then a site sees its predecessors' new values.
  void sweep(const VectorField& from, VectorField& to) {
    changed_ = 0;
    for (int y = 0; y < level_.extent.height; ++y) {
      for (int x = 0; x < level_.extent.width; ++x) {
        const energy::Site site = energy::gather(level_, from, x, y);
        const energy::Displacement next =
            energy::improved_displacement(site, level_.steps.padded().data(), level_.steps.count());
        changed_ += (next.x != site.dx.centre || next.y != site.dy.centre) ? 1 : 0;
        const std::size_t at = level_.extent.index(x, y);
        to.x[at] = next.x;
        to.y[at] = next.y;
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
