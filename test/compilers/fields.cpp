// fields: what the CPU's backends compute on a processor for which nothing else of the program is compiled. A
// line a backend, energy and extent: a hash of every field on the way, as harness/check/golden has it.

#include "backends/cpu/cpu.hpp"
#include "test/random_level.hpp"

#include <bit>
#include <cinttypes>
#include <cstdio>

namespace hdmbench {
namespace {

/// FNV-1a over the bits of numbers, -0 as 0, low byte first.
class Hash {
public:
  void add(float value) {
    auto word = value == 0.0F ? 0U : std::bit_cast<std::uint32_t>(value);
    for (int byte = 0; byte < 4; ++byte, word >>= 8) {
      hash_ = (hash_ ^ (word & 0xff)) * 0x100000001b3;
    }
  }
  void add(const VectorField& field) {
    for (std::size_t axis = 0; axis < field.extent.axes(); ++axis) {
      for (const float value : field[axis]) {
        add(value);
      }
    }
  }
  [[nodiscard]] std::uint64_t value() const { return hash_; }

private:
  std::uint64_t hash_ = 0xcbf29ce484222325;
};

/// All rules, on numbers of every kind.
std::uint64_t thesis_fields(const Backend& backend, Extent extent) {
  Hash hash;
  std::uint64_t seed = 0;
  for (const Rule rule : test::all_rules) {
    for (const auto texture : {test::Texture::smooth, test::Texture::tie_rich, test::Texture::extreme}) {
      const test::Problem problem = test::random_problem(extent, texture, ++seed, {}, rule);
      const auto session = backend.open({.device = {}, .threads = 3});
      session->load(problem.level);
      session->write(problem.start);
      for (int sweep = 0; sweep < 5; ++sweep) {
        session->step(1);
        VectorField field;
        session->read(field);
        hash.add(field);
      }
    }
  }
  return hash.value();
}

/// Two V-cycles, and what conjugate gradients take beside.
std::uint64_t elastic_fields_of(const Backend& backend, Extent extent) {
  using enum ElasticField;
  Hash hash;
  const test::Problem problem = test::random_problem(extent, test::Texture::smooth, 7);
  ElasticHierarchy hierarchy = make_elastic_hierarchy({problem.level});
  const int coarsest = static_cast<int>(hierarchy.levels.size()) - 1;
  const auto session = backend.open_elastic({.device = {}, .threads = 3});
  session->load(std::move(hierarchy));
  session->write(0, displacement, problem.start);
  for (int cycle = 0; cycle < 2; ++cycle) {
    session->relax(0, displacement);
    session->restrict_residual(0, displacement);
    for (int level = 1; level < coarsest; ++level) {
      session->relax_from_zero(level);
      session->relax(level, correction);
      session->restrict_residual(level, correction);
    }
    session->solve_coarsest();
    for (int level = coarsest - 1; level > 0; --level) {
      session->correct(level, correction);
    }
    session->correct(0, displacement);
    session->forces(displacement, load);
    session->advance(direction, load, 0.37F, direction);
    hash.add(session->dot(load, direction));
    for (const ElasticField one : {displacement, load, direction}) {
      VectorField field;
      session->read(0, one, field);
      hash.add(field);
    }
  }
  return hash.value();
}

void print(const Backend& backend) {
  for (const Extent extent : {Extent{67, 45}, Extent{19, 14, 11}}) {
    const auto line = [&](const char* energy, std::uint64_t hash) {
      std::printf("%s %s %dx%dx%d %016" PRIx64 "\n", std::string(backend.name()).c_str(), energy,
                  extent.width, extent.height, extent.depth, hash);
    };
    line("hdm", thesis_fields(backend, extent));
    line("elastic", elastic_fields_of(backend, extent));
  }
}

} // namespace
} // namespace hdmbench

int main() {
  hdmbench::print(*hdmbench::make_scalar());
  hdmbench::print(*hdmbench::make_openmp());
}
