// A backend of one's own, verified: verify() leads it and the reference side by side and compares every site
// after every sweep. One that forgets a column is found out.

#include <backends/registry.hpp>
#include <harness/check/verify.hpp>
#include <kernels/data/gather.hpp>

#include <iostream>
#include <random>

using namespace hdmbench;

namespace {

/// Sweeps images by the thesis's energy, from column `first_column` on: 0 is right.
class MySession final : public Session {
public:
  explicit MySession(int first_column) : first_column_(first_column) {}

private:
  void do_load(const Level& level) override { level_ = level; }
  void do_write(const VectorField& displacement) override { field_ = displacement; }
  void do_read(VectorField& displacement) override { displacement = field_; }
  std::int64_t do_changed() override { return changed_; }
  void do_step(int first, int sweeps) override {
    for (int number = first; number < first + sweeps; ++number) {
      const VectorField before = field_;
      changed_ = 0;
      for_each_site(level_.extent, [&](int x, int y) {
        const auto moved = swept_site<HdmInFloat>(level_, before, number, std::max(x, first_column_), y);
        const std::size_t site = level_.extent.index(x, y);
        field_[0][site] = x < first_column_ ? before[0][site] : moved.x;
        field_[1][site] = x < first_column_ ? before[1][site] : moved.y;
        changed_ += field_[0][site] != before[0][site] || field_[1][site] != before[1][site] ? 1 : 0;
      });
    }
  }

  int first_column_;
  Level level_{};
  VectorField field_;
  std::int64_t changed_ = 0;
};

class MyBackend final : public Backend {
public:
  explicit MyBackend(int first_column) : first_column_(first_column) {}
  std::string_view name() const override { return first_column_ == 0 ? "mine" : "mine, wrong"; }
  std::string_view description() const override { return "the specification, site by site"; }
  std::vector<Device> devices() const override { return {{"a processor", "C++", true}}; }

private:
  std::unique_ptr<Session> do_open(std::size_t /*index*/, const SessionOptions& /*options*/) const override {
    return std::make_unique<MySession>(first_column_);
  }

  int first_column_;
};

/// Everything differs from site to site, and a third of the displacements is known.
Scene random_scene(Extent extent) {
  Scene scene;
  scene.name = "random";
  scene.schedule.iterations = 4;
  Level& full = scene.full;
  full = {.extent = extent,
          .target = VectorField(extent),
          .confidence = VectorField(extent),
          .modulus = ScalarField(extent)};
  std::mt19937 source(1);
  const auto uniform = [&] { return static_cast<float>(source() >> 8) * 0x1p-24F; };
  for (std::size_t site = 0; site < extent.sites(); ++site) {
    full.modulus.values[site] = 1.0F + 9.0F * uniform();
    for (std::size_t axis = 0; axis < 2; ++axis) {
      full.target[axis][site] = 4.0F * uniform() - 2.0F;
      full.confidence[axis][site] = uniform() < 0.3F ? 1.0F : 0.0F;
    }
  }
  full.penalty = 1000.0F; // else the observations move little
  set_inverse_modulus(full);
  return scene;
}

} // namespace

int main() {
  const MyBackend right(0);
  const MyBackend wrong(1);
  const auto known = make_backends();
  Progress progress;
  int failures = 0;
  for (const Comparison& one : verify(random_scene({33, 21}), find_backend(known, "scalar"),
                                      std::vector<const Backend*>{&right, &wrong}, {}, progress)) {
    std::cout << one.backend << ", " << name_of(one.mode) << ": " << name_of(one.verdict) << ' '
              << one.reason;
    if (one.first) {
      std::cout << "first at x = " << one.first->x << ", y = " << one.first->y << " in iteration "
                << one.first->iteration << " of level " << one.first->level;
    }
    std::cout << '\n';
    if (one.verdict != Verdict::skipped) {
      failures += one.verdict == (one.backend == right.name() ? Verdict::agree : Verdict::disagree) ? 0 : 1;
    }
  }
  return failures;
}
