#include "harness/judge/continuum.hpp"

#include "harness/cli/arguments.hpp"

#include <array>
#include <numeric>

namespace hdmbench::commands {

namespace {

struct Arguments {
  std::vector<int> sizes{50, 75, 100, 150, 200, 300, 400, 600};
  SceneArguments place; ///< backend and session
  bool quick = false;
};

/// Moduli of the inclusion over that around it.
constexpr std::array contrasts{0.1, 3.0, 10.0, 100.0};

int run_continuum(Arguments& arguments, Call& call) {
  if (arguments.quick) {
    arguments.sizes = {50, 100, 200};
  }
  std::ranges::sort(arguments.sizes);
  const auto registry = make_backends();
  const Backend& backend = find_backend(registry, arguments.place.backend);
  Progress progress;
  progress.set_total(contrasts.size() * std::inner_product(arguments.sizes.begin(), arguments.sizes.end(),
                                                           arguments.sizes.begin(), 0.0));
  json rows = json::array();
  for (const double contrast : contrasts) {
    const json more =
        measure_continuum(contrast, arguments.sizes, backend, arguments.place.session, progress);
    rows.insert(rows.end(), more.begin(), more.end());
  }
  progress.clear();
  fmt::print(
      "A sheet with a round inclusion, stretched by 50 px, whose displacement is known in closed form. RMSD\n"
      "in pixels. Discretisation: finite elements on the pixels, direct and in double, from the closed "
      "form.\n"
      "Algebraic: our field at its usual effort from these finite elements; float32: when it rests. Order:\n"
      "of discretisation, since the first size.\n\n{}",
      table_text(rows, "contrast|size|discretisation.rmsd:discretisation|order|algebraic.rmsd:algebraic|"
                       "rounding.rmsd:float32|total.rmsd:our field in all|total.largest:largest"));
  call.write(std::move(rows), arguments.quick);
  return success;
}

} // namespace

void add_continuum(CLI::App& program, Call& call) {
  const auto [command, own] =
      declare(program, call, "continuum",
              "How far a mesh of pixels is from the continuum: a round inclusion whose displacement is "
              "known exactly,\non meshes of several sizes; errors of discretisation, of the solver and "
              "of float32 apart.",
              run_continuum);
  CLI::Option* const sizes =
      add_option(command, "--sizes", own.sizes, "Sides of the images, several with commas")
          ->delimiter(',')
          ->check(CLI::Range(8, 4096));
  own.place.add_backend_to(command);
  add_flag(command, "--quick", own.quick, "Three sizes to 200; the results say so")->excludes(sizes);
  add_json(command, call);
}

} // namespace hdmbench::commands
