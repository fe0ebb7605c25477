#include "harness/check/machine_code/programs.hpp"

#include "backends/session/device_backend.hpp"
#include "backends/session/elastic_steps.hpp"
#include "harness/scene/method.hpp"
#include "harness/solve/methods/elastic.hpp"
#include "harness/solve/solve.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <set>
#include <utility>

namespace hdmbench {

namespace {

using Kinds = std::set<ProgramKind>;

class NoArray final : public Array {
public:
  using Array::Array;
};

/// A GPU that computes nothing and keeps what it is asked to compile.
class Recorder final : public ComputeDevice {
public:
  Recorder(GpuTexts texts, Kinds& kinds) : kinds_(kinds) {
    constexpr std::size_t unlimited = std::numeric_limits<std::int32_t>::max();
    const bool has_planes = texts == GpuTexts::opencl;
    limits_ = {.elements = unlimited,
               .array_bytes = unlimited,
               .memory = unlimited,
               .groups_x = unlimited,
               .groups_y = unlimited,
               .group = 1024,
               .shared_bytes = has_planes ? std::size_t{0} : std::size_t{32} * 1024,
               .has_planes = has_planes};
  }

  const Device& description() const override { return description_; }
  const DeviceLimits& limits() const override { return limits_; }
  void write(const Array& /*to*/, std::size_t /*first*/, std::span<const std::byte> /*values*/) override {}
  /// Ones: by a residual of 0 a method would end.
  void read(const Array& /*from*/, std::size_t /*first*/, std::span<std::byte> values) override {
    const float one = 1.0F;
    for (std::size_t at = 0; at + sizeof one <= values.size(); at += sizeof one) {
      std::memcpy(&values[at], &one, sizeof one);
    }
  }
  std::unique_ptr<Program> compile(const ProgramKind& kind) override {
    kinds_.insert(kind);
    return std::make_unique<Program>();
  }
  ProgramText text_of(const ProgramKind& /*kind*/) const override { return {}; }
  void run(std::span<const Commands::value_type> /*commands*/) override {}
  void finish() override {}

private:
  std::unique_ptr<Array> make(std::size_t count, Kind kind) override {
    return std::make_unique<NoArray>(*this, count, kind);
  }

  Kinds& kinds_;
  Device description_{.name = "a GPU that is not there", .driver = ""};
  DeviceLimits limits_;
};

void record_sites(const Scene& scene, GpuTexts texts, Kinds& kinds) {
  Progress silent(false);
  for (const Work work : {Work::dense, Work::active}) {
    const auto session = make_device_session(std::make_unique<Recorder>(texts, kinds), work);
    (void)solve(scene, *session, silent); // a pyramid in one piece, then one level
    session->load(scene.full);
    session->write(VectorField(scene.extent()));
    session->step(1);
    (void)session->changed();
  }
}

void record_cells(const Scene& scene, GpuTexts texts, Kinds& kinds) {
  const auto session = make_elastic_session("", std::make_unique<Recorder>(texts, kinds));
  ElasticSolver solver(scene.full, scene.elastic, *session);
  solver.full_multigrid();
  solver.sweep();
  (void)solver.cycle();
  (void)solver.conjugate_gradients();
  (void)solver.conjugate_gradients(); // the first has no direction to keep
  (void)solver.displacement();
}

/// The shipped law, in tissue without fibres and with some.
void record_laws(const Scene& scene, GpuTexts texts, Kinds& kinds) {
  const auto session = make_elastic_session("", std::make_unique<Recorder>(texts, kinds));
  Level level = scene.full;
  session->load(ElasticBody{level, scene.elastic, Springs::none});
  level.law_parameter = ScalarField(level.extent);
  const VectorField displacement(level.extent);
  VectorField force;
  (void)session->law_forces(LawForces(level, scene.elastic), displacement, force);
  level.fibre = VectorField(level.extent);
  level.fibre_compression = ScalarField(level.extent);
  (void)session->law_forces(LawForces(level, scene.elastic), displacement, force);
}

/// 0 where the kind has no such constant.
int constant(const ProgramKind& kind, std::string_view name) {
  const auto found = std::ranges::find(kind.constants, name, &ProgramKind::Constant::name);
  return found == kind.constants.end() ? 0 : found->value;
}

std::string sweep_name(const ProgramKind& kind) {
  constexpr std::array<std::string_view, 3> rules{"steps", "closed form", "annealing"};
  const auto rule = static_cast<std::size_t>(constant(kind, "RULE"));
  return fmt::format("{} {} candidates {} colours class {}{}", rules.at(rule), constant(kind, "STEP_COUNT"),
                     constant(kind, "COLOURS"), constant(kind, "CLASS"),
                     constant(kind, "ACTIVE") != 0 ? " active" : "");
}

std::string elastic_name(const ProgramKind& kind) {
  constexpr std::array<std::string_view, 10> steps{"relax",       "relax from zero", "residual", "restrict",
                                                   "interpolate", "correct",         "solve",    "advance",
                                                   "products",    "squares"};
  if (constant(kind, "TOGETHER") != 0) {
    return constant(kind, "BOXES") != 0 ? "coarsest levels of boxes" : "coarsest levels";
  }
  std::string name(steps.at(static_cast<std::size_t>(constant(kind, "STEP"))));
  for (const auto& [flag, says] : {std::pair{"HAS_LOAD", " load"},
                                   {"IS_IMAGE", " image"},
                                   {"BY_LIST", " beside masked cells"},
                                   {"BOXES", " of boxes"}}) {
    name += constant(kind, flag) != 0 ? says : "";
  }
  return constant(kind, "HALVED") == 7 ? name : name + " of short sides";
}

std::string law_name(const ProgramKind& kind) {
  constexpr std::array<std::string_view, 3> steps{"cells", "sites", "least"};
  return fmt::format("{}{}", steps.at(static_cast<std::size_t>(constant(kind, "STEP"))),
                     constant(kind, "FIBRES") != 0 ? " with fibres" : "");
}

GpuProgram described(const ProgramKind& kind, GpuTexts texts) {
  constexpr std::array<std::string_view, 6> files{"sweep",   "levels", "coarse_levels",
                                                  "elastic", "laws",   "loops"};
  constexpr std::array<std::string_view, 3> passes{"sample", "project", "count"};
  std::string name;
  switch (kind.kernel) {
  case Kernel::sweep:
    name = sweep_name(kind);
    break;
  case Kernel::levels:
    name = passes.at(static_cast<std::size_t>(constant(kind, "PASS")));
    break;
  case Kernel::coarse_levels:
    name = fmt::format("{} candidates{}", constant(kind, "STEP_COUNT"),
                       constant(kind, "STOPS_AT_REST") != 0 ? " until rest" : "");
    break;
  case Kernel::elastic:
    name = elastic_name(kind);
    break;
  case Kernel::laws:
    name = law_name(kind);
    break;
  case Kernel::loops:
    break;
  }
  return {.kind = kind,
          .kernel = std::move(name),
          .text = fmt::format("{}.{}", files.at(static_cast<std::size_t>(kind.kernel)),
                              texts == GpuTexts::opencl ? "cl" : "comp")};
}

} // namespace

std::vector<GpuProgram> gpu_programs(GpuTexts texts) {
  Kinds kinds;
  // Tiles of every class, conditions that lie on the sites and some that cut cells; an image has more than 64
  // tiles, and a volume has some without border.
  for (const auto& [name, size] : {std::pair{"random", Extent{256, 256}},
                                   {"square", Extent{256, 256}},
                                   {"circular", Extent{256, 256}},
                                   {"cube", Extent{192, 48, 12}},
                                   {"ball", Extent{192, 48, 12}}}) {
    for (const RegisteredEnergy* const energy : registered_energies()) {
      Scene usual = load_scene(name, {.size = size});
      use_energy(usual, *energy);
      if (energy->is_of_cells()) {
        record_cells(usual, texts, kinds);
        usual.full.sides[1] = 2.0;
        record_cells(usual, texts, kinds);
        record_laws(usual, texts, kinds);
        continue;
      }
      std::set<std::pair<Rule, Update>>
          seen; // a method that differs in its candidates only asks for nothing new
      for (const Method& method : energy->methods) {
        Scene scene = usual;
        use_method(scene, method, 1);
        const Update update = scene.full.update;
        if (update != Update::sequential && seen.emplace(scene.schedule.rule, update).second) {
          record_sites(scene, texts, kinds);
        }
      }
    }
  }
  std::vector<GpuProgram> programs;
  std::ranges::transform(kinds, std::back_inserter(programs),
                         [&](const ProgramKind& kind) { return described(kind, texts); });
  return programs;
}

} // namespace hdmbench
