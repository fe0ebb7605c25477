#include "harness/applications/detection.hpp"
#include "harness/applications/picture.hpp"
#include "harness/applications/registration.hpp"
#include "harness/cli/arguments.hpp"
#include "harness/judge/diagnosis/diagnosis.hpp"
#include "harness/judge/registration/ways.hpp"
#include "harness/scene/images/images.hpp"

#include <cmath>

namespace hdmbench {
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(Detection, noise, unexplained_before, unexplained, largest, x, y, radius,
                                   contrast, position_deviation, contrast_deviation)
}

namespace hdmbench::commands {

namespace {

/// Any contrast that the search tries explains as much.
bool is_undetermined(const Detection& found) {
  return !(found.contrast_deviation < largest_logarithm);
}

/// The search ended at its limit: it may be more.
bool is_at_limit(const Detection& found) {
  return std::abs(std::log(found.contrast)) > 0.999 * largest_logarithm;
}

/// How much stiffer or softer, as far as the search can tell.
std::string contrast_text(const Detection& found) {
  const double most = std::exp(largest_logarithm);
  if (is_undetermined(found)) {
    return fmt::format("any modulus from 1/{0:.0f} to {0:.0f} times the label's: it cannot be told", most);
  }
  const auto end = [&](double logarithm) {
    return std::exp(std::clamp(std::log(found.contrast) + logarithm, -largest_logarithm, largest_logarithm));
  };
  const std::string range =
      fmt::format("{:.3g} ... {:.3g}", end(-found.contrast_deviation), end(found.contrast_deviation));
  return is_at_limit(found) ? fmt::format("{} the label's modulus, where the search ends ({})",
                                          found.contrast > 1.0 ? fmt::format("{:.0f} times or more", most)
                                                               : fmt::format("1/{:.0f} or less of", most),
                                          range)
                            : fmt::format("{:.3g} times the label's modulus ({})", found.contrast, range);
}

std::string verdict(bool chance_found_it, const Detection& found) {
  if (chance_found_it) {
    return "Nothing that chance does not find as well.";
  }
  return is_undetermined(found) ? "More than chance is unexplained, but not by stiffer or softer tissue: "
                                  "the deformation does not tell its modulus."
                                : "More than chance found: tissue there is not as its label says.";
}

constexpr double strong = 4.0; // standard deviations that are full colour

struct Arguments : PairArguments {
  DetectionOptions detection;
};

int run_detect(Arguments& arguments, Call& call) {
  const PictureData data = arguments.load();
  const auto registry = make_backends();
  const Backend& backend = arguments.scene.choose(registry, data.scene);
  const Device device = backend.device(arguments.scene.session);
  arguments.require_output(
      std::vector<std::string>{"modulus.nrrd", "detection.nrrd", "source.png", "detection.png"});
  const auto session = backend.open_elastic(arguments.scene.session);
  if (session == nullptr) {
    throw InputError(fmt::format("{} has no elastic energy, which detect solves with", backend.name()));
  }
  Progress progress;
  // The pictures are looked at inside the region too: it is the modulus there that is not known.
  const IteratedRegistration registered =
      register_iteratively(data.source, data.target, data.scene, {}, {}, *session, progress);
  const Similarity after = similarity(data.source, pulled_back(data.target, registered.displacement));
  for (const Warning& warning :
       diagnose(data.source, data.target, similarity(data.source, data.target), after)) {
    if (warning.kind == no_likeness) {
      throw InputError(fmt::format("detect: {} {}", warning.message, warning.advice));
    }
  }
  const Detection found = detect_modulus(data.source, data.target, registered.displacement, data.region,
                                         data.scene, arguments.detection, *session, progress);
  progress.clear();

  const auto as_much_by_chance =
      std::ranges::count_if(found.by_chance, [&](double most) { return most >= std::abs(found.largest); });
  json row = found;
  row.update(row_of(data.scene));
  row.update({{"placement", data.placement},
              {"backend", backend.name()},
              {"device", device.name},
              {"seconds", registered.seconds + found.seconds},
              {"registration_seconds", registered.seconds},
              {"region_sites", std::ranges::count_if(data.region.values, [](float v) { return v != 0.0F; })},
              {"simulations", found.by_chance.size()},
              {"as_much_by_chance", as_much_by_chance},
              {"largest_by_chance", std::ranges::max(found.by_chance)},
              {"contrast_undetermined", is_undetermined(found)},
              {"contrast_at_limit", is_at_limit(found)}});
  const auto name = [&](const char* file) { return beside(call.json, arguments.output, file); };
  write_scalar(arguments.output / "modulus.nrrd", found.modulus, data.scene.spacing, data.placement);
  write_scalar(arguments.output / "detection.nrrd", found.significance, data.scene.spacing, data.placement);
  row["modulus"] = name("modulus.nrrd");
  row["detection"] = name("detection.nrrd");
  Pictures pictures(arguments.output, call.json);
  pictures.gray("source", "source", data.source);
  pictures.signed_values(
      "detection",
      "significance over the source: red stiffer than the label says, blue softer, full at 4 "
      "standard deviations",
      found.significance, strong, data.source);
  row["pictures"] = pictures.written();

  fmt::print(
      "{}\n\n{} of {}\n\n", data.scene.title,
      row_text(
          "  {region_sites} sites of the region; error of the displacement, as white noise, {noise:.3g} px\n"
          "  unexplained by the labels' moduli {unexplained_before:.3g} px, by those found "
          "{unexplained:.3g} px\n"
          "  most significant {largest:.3g} standard deviations; by chance as much in "
          "{as_much_by_chance} of {simulations} simulations with nothing hidden, at most "
          "{largest_by_chance:.3g}\n"
          "  explained best by a disc at x = {x:.1f}, y = {y:.1f} (+- {position_deviation:.3g}), radius "
          "{radius:.1f} px,",
          row),
      contrast_text(found));
  fmt::print("  {}\n\n{}  {}: MPa; beside it detection.nrrd, standard deviations\n",
             verdict(as_much_by_chance > 0, found),
             row_text("  {seconds:.3g} s ({registration_seconds:.3g} of them the registration)\n", row),
             (arguments.output / "modulus.nrrd").string());
  call.write(json::array({without_nulls(row)}));
  return success;
}

} // namespace

void add_detect(CLI::App& program, Call& call) {
  const auto [command, own] = declare(
      program, call, "detect",
      "Where is tissue stiffer or softer than its label says? (thesis Algorithm 7)\nRegisters the two "
      "pictures, then finds the moduli in the region that explain the deformation.\nWrites "
      "DIR/modulus.nrrd and DIR/detection.nrrd.",
      run_detect);
  own.add_to(command, call, true);
  add_option(command, "--simulations", own.detection.pairs,
             "Pairs of pictures with nothing hidden that are registered too: what is found in them is chance")
      ->check(CLI::Range(3, 1000));
}

} // namespace hdmbench::commands
