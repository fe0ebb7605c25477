#include "harness/tools/tune.hpp"
#include "harness/cli/arguments.hpp"
#include "harness/judge/truths.hpp"
#include "harness/scene/images/images.hpp"
#include "harness/solve/solve.hpp"

namespace hdmbench::commands {

namespace {

struct Arguments {
  SceneArguments scene;
  TuneOptions search;
  std::string method = "simplex";
  std::vector<double> range;
  std::string truth = "fem";
  std::filesystem::path mask;
};

/// What a solution is measured against.
struct Truth {
  ReferenceField displacement;         ///< pixels
  std::vector<std::uint8_t> counted{}; ///< not 0 where the truth is known; empty: everywhere
};

Truth read_truth(const Arguments& arguments, Extent extent) {
  Image<VectorField> read = read_displacement(arguments.truth);
  if (read.pixels.extent != extent) {
    throw InputError(fmt::format("{}: is {} x {} pixels, the scene is {} x {}", arguments.truth,
                                 read.pixels.extent.width, read.pixels.extent.height, extent.width,
                                 extent.height));
  }
  validate(read.pixels, extent, "the truth");
  Truth truth{.displacement = ReferenceField(read.pixels)};
  if (!arguments.mask.empty()) {
    const ScalarField mask = read_scalar(arguments.mask).pixels;
    if (mask.extent != extent) {
      throw InputError(fmt::format("the mask of the truth is {} x {} pixels, the scene is {} x {}",
                                   mask.extent.width, mask.extent.height, extent.width, extent.height));
    }
    std::ranges::transform(mask.values, std::back_inserter(truth.counted),
                           [](float defined) { return static_cast<std::uint8_t>(defined != 0.0F); });
    if (std::ranges::count(truth.counted, 1) == 0) {
      throw InputError("the truth is defined at no pixel: its mask is 0 everywhere");
    }
  }
  return truth;
}

void print(const Tuning& tuning, double penalty) {
  json rows = json::array();
  for (std::size_t i = 0; i < tuning.evaluations.size(); ++i) {
    const Evaluation& evaluation = tuning.evaluations[i];
    const ObservationWeight weight{.penalty = penalty, .prior_weight = evaluation.prior_weight};
    rows.push_back({{"alpha", fmt::format("{:.5f}", evaluation.prior_weight)},
                    {"product", weight.product()},
                    {"rmsd", fmt::format("{:.5f}", evaluation.rmsd)},
                    {"which", i == tuning.best ? "best" : (i < tuning.scanned ? "scan" : "")}});
  }
  fmt::print("{}", table_text(rows, "alpha|product:K (1 - alpha) / alpha|rmsd:RMSD [px]|which:"));
}

int run_tune(Arguments& arguments, Call& call) {
  const bool against_elements = arguments.truth == "fem";
  if (against_elements) {
    refuse_idle(*call.command, {"--mask"}, "it belongs to a truth from a file, --truth FILE.nrrd");
  }
  Scene scene = arguments.scene.load();
  TuneOptions search = arguments.search;
  search.method = arguments.method == "simplex" ? SearchMethod::simplex : SearchMethod::annealing;
  if (!arguments.range.empty()) {
    search.low = arguments.range[0];
    search.high = arguments.range[1];
  }
  const auto registry = make_backends();
  const Backend& backend = arguments.scene.choose(registry, scene);
  Progress progress;
  progress.describe(fmt::format("tune {}: the truth", scene.name));
  const Truth truth = against_elements ? Truth{find_finite_elements(scene.full, scene.poisson)}
                                       : read_truth(arguments, scene.extent());
  const auto session = backend.open(arguments.scene.session);
  int evaluations = 0;
  const double penalty = scene.weight.penalty;
  const Tuning tuning = tune_prior_weight(
      [&](double alpha) {
        progress.describe(
            fmt::format("tune {}: evaluation {}, alpha = {:.4g}", scene.name, ++evaluations, alpha));
        set_weight(scene, {.penalty = penalty, .prior_weight = alpha});
        Progress silent(false);
        return rmsd(ReferenceField(solve(scene, *session, silent).displacement), truth.displacement,
                    truth.counted);
      },
      search);
  progress.clear();

  const Evaluation& best = tuning.evaluations[tuning.best];
  fmt::print("{}\n{} x {} pixels, K = {:.6g}, {} on {}, against {}\n\n", scene.title, scene.extent().width,
             scene.extent().height, penalty, tuning.matters() ? arguments.method : "scan", backend.name(),
             against_elements ? fmt::format("finite elements (nu = {})", scene.poisson) : arguments.truth);
  print(tuning, penalty);
  if (tuning.matters()) {
    fmt::print("\n  alpha = {:.5f}: RMSD {:.5f} px (the largest seen is {:.3g} px above)\n",
               best.prior_weight, best.rmsd, tuning.spread());
  } else {
    fmt::print(
        "\n  alpha does not matter here: from {} to {} the RMSD changes by {:.2g} px, less than {:.0e}\n",
        search.low, search.high, tuning.spread(), Tuning::flat);
  }
  return success;
}

} // namespace

void add_tune(CLI::App& program, Call& call) {
  const auto [command, own] =
      declare(program, call, "tune",
              "Find the prior weight alpha of (3.17) that brings the solution nearest to a truth (thesis "
              "A.7, (A.8)): a scan of\nfive alphas, then the downhill simplex or simulated annealing over "
              "log(alpha / (1 - alpha)).",
              run_tune);
  own.scene.add_scene_to(command);
  remove_options(command, {"--prior-weight"}); // it is what is looked for
  own.scene.add_backend_to(command);
  add_option(command, "--search", own.method, "simplex (Nelder and Mead) or annealing (thesis Alg. 1)")
      ->check(CLI::IsMember({"simplex", "annealing"}));
  add_option(command, "--evaluations", own.search.evaluations, "Solutions after the scan, about, at most")
      ->check(CLI::Range(1, 100000));
  add_option(command, "--range", own.range, "alpha is sought in low,high (default: 0.01,0.99)")
      ->delimiter(',')
      ->expected(2);
  add_option(command, "--truth", own.truth,
             "fem (finite elements, plane stress, the scene's Poisson ratio), or a displacement image "
             "in millimetres");
  add_option(command, "--mask", own.mask, "Image that is 0 where the truth from a file is not defined");
}

} // namespace hdmbench::commands
