// A backend of one's own, verified: verify() leads it and the reference side by side and compares every site
// after every sweep. One that forgets a column is found out.

#include <backends/registry.hpp>
#include <harness/check/verify.hpp>
#include <kernels/data/gather.hpp>

#include <iostream>
#include <random>

using namespace hdmbench;

/// Sweeps images by the thesis's energy, from column `first_column` on: 0 is right.
struct MySession final : Session {
  explicit MySession(int first_column_) : first_column(first_column_) {}
  void do_load(const Level& loaded) override { level = loaded; }
  void do_write(const VectorField& displacement) override { field = displacement; }
  void do_read(VectorField& displacement) override { displacement = field; }
  std::int64_t do_changed() override { return changed; }
  void do_step(int first, int sweeps) override {
    for (int number = first; number < first + sweeps; ++number) {
      const VectorField before = field;
      changed = 0;
      for_each_site(level.extent, [&](int x, int y) {
        if (x >= first_column) {
          const auto moved = swept_site<HdmInFloat>(level, before, number, x, y);
          const std::size_t site = level.extent.index(x, y);
          changed += moved.x != field[0][site] || moved.y != field[1][site] ? 1 : 0;
          field[0][site] = moved.x;
          field[1][site] = moved.y;
        }
      });
    }
  }

  int first_column;
  Level level{};
  VectorField field;
  std::int64_t changed = 0;
};

struct MyBackend final : Backend {
  explicit MyBackend(int first_column_) : first_column(first_column_) {}
  std::string_view name() const override { return first_column == 0 ? "mine" : "mine, wrong"; }
  std::string_view description() const override { return "the specification, site by site"; }
  std::vector<Device> devices() const override { return {{"a processor", "C++", true}}; }
  std::unique_ptr<Session> do_open(std::size_t, const SessionOptions&) const override {
    return std::make_unique<MySession>(first_column);
  }

  int first_column;
};

int main() {
  Scene scene; // a modulus for every site, and a third of the displacements known
  Level& level = scene.full;
  const Extent extent = level.extent = {33, 21};
  level.modulus = ScalarField(extent);
  level.target = level.confidence = VectorField(extent);
  level.penalty = 1000.0F;
  std::mt19937 source(1);
  for (std::size_t site = 0; site < extent.sites(); ++site) {
    level.modulus.values[site] = 1.0F + static_cast<float>(source() % 10);
    for (std::size_t axis = 0; axis < 2; ++axis) {
      level.target[axis][site] = 0.1F * static_cast<float>(source() % 40);
      level.confidence[axis][site] = source() % 3 == 0 ? 1.0F : 0.0F;
    }
  }
  set_inverse_modulus(level);
  const auto known = make_backends();
  const MyBackend right(0);
  const MyBackend wrong(1);
  const std::vector<const Backend*> mine{&right, &wrong};
  Progress progress;
  int failures = 0;
  for (const Comparison& one : verify(scene, find_backend(known, "scalar"), mine, {}, progress)) {
    std::cout << one.backend << ", " << name_of(one.mode) << ": " << name_of(one.verdict) << ' ' << one.reason
              << (one.first ? "; first at x = " + std::to_string(one.first->x) : "") << '\n';
    const Verdict expected = one.backend == right.name() ? Verdict::agree : Verdict::disagree;
    failures += one.verdict == Verdict::skipped || one.verdict == expected ? 0 : 1;
  }
  return failures;
}
