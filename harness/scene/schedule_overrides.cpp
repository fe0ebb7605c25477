#include "harness/scene/schedule_overrides.hpp"

#include "harness/scene/laws.hpp"
#include "harness/scene/method.hpp"
#include "harness/scene/schedule_keys.hpp"
#include "kernels/data/input_error.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace hdmbench {

std::string option_of(std::string_view key) {
  std::string name = fmt::format("--{}", key);
  std::ranges::replace(name, '_', '-');
  return name;
}

void ScheduleOverrides::choose_energy(std::string_view name) {
  const bool as_needed = name == "auto";
  energy = as_needed ? &energy_near(ReferenceSolution::finite_elements) : &find_energy(name);
  law = as_needed ? law_as_needed : "";
}

const RegisteredEnergy*
ScheduleOverrides::energy_to_be(const std::optional<std::string>& other_method) const {
  const auto own_method = given.find("method");
  if (energy != nullptr || (!other_method && own_method == given.end())) {
    return energy;
  }
  return &energy_of(find_method(other_method ? *other_method : own_method->second));
}

void ScheduleOverrides::apply(Scene& scene, const std::optional<std::string>& other_method) const {
  if (!law.empty() && !plans) {
    throw InputError("--energy auto takes the law of large strains where an accuracy needs it: it belongs to "
                     "run --accuracy, give --energy elastic here");
  }
  if (energy != nullptr) {
    use_energy(scene, *energy);
  }
  const auto own_method = given.find("method");
  const bool has_method = other_method || own_method != given.end();
  if (has_method) {
    use_method(scene, find_method(other_method ? *other_method : own_method->second, energy));
  }
  if (scene.extent().axes() == 3 && !(takes_energies && scene.energy->takes_volumes)) {
    throw InputError(fmt::format(
        "{} is a volume, and {}", scene.name,
        takes_energies
            ? fmt::format("the {} energy takes images only; give --energy elastic", scene.energy->name)
            : "this command takes images only"));
  }
  if (scene.energy->is_of_cells() && !takes_energies) {
    throw InputError(fmt::format("{} would have the {} energy, which this command does not know; run, "
                                 "verify, bench, tradeoff and accuracy do",
                                 scene.name, scene.energy->name));
  }
  if (given.contains("poisson") && !scene.energy->is_of_cells() && !meets_truths) {
    throw InputError(
        "--poisson has no effect here: the thesis's energy has no Poisson's ratio; give --energy "
        "elastic, or leave it out");
  }
  if (has_laws(scene.full) && (has_method || given.contains("iterations"))) {
    throw InputError(fmt::format("{} has tissues with a law of large strains, which non-linear conjugate "
                                 "gradients solve to an accuracy; leave --method and --iterations out, and "
                                 "give --accuracy where another one than 0.01px is wanted",
                                 scene.name));
  }
  require_memory(scene);
  scene.exact = scene.exact && !has_method && energy == nullptr;
  for (const ScheduleKey& key : schedule_keys()) {
    if (const auto value = given.find(key.name); value != given.end()) {
      try {
        set_key(scene, key, value->second);
      } catch (const InputError& error) {
        throw InputError(fmt::format("{} {}: {}", option_of(key.name), value->second, error.what()));
      }
      scene.exact = scene.exact && key.keeps_exactness; // the file vouches for nothing else
    }
  }
  scene.exact = scene.exact && scene.full.update != Update::sequential;
}

} // namespace hdmbench
