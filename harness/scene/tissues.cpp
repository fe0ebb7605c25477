#include "harness/scene/laws.hpp"
#include "harness/scene/method.hpp"
#include "harness/scene/scene_content.hpp"
#include "harness/scene/walls.hpp"
#include "kernels/data/elastic/conditions.hpp"
#include "kernels/data/input_error.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <set>
#include <utility>

/// What the [[tissue]] tables of a scene say: moduli, densities, void, laws of large strains.
namespace hdmbench {

namespace {

/// Reads the law of large strains that a table states; none: it states none.
std::optional<TissueLaw> read_law(TomlReader& table) {
  if (!table.has("law")) {
    return std::nullopt;
  }
  const RegisteredLaw& law = *registered_laws()[table.choice("law", law_names())];
  return TissueLaw{law.text,
                   law.key.empty() ? law.parameter : static_cast<float>(table.get<double>(law.key))};
}

/// The law of tissues that state none. `law`: SceneOptions::law.
TissueLaw usual_law(const std::optional<TissueLaw>& of_file, const Content& content, std::string_view law) {
  if (law.empty() || (law == law_as_needed && of_file)) {
    return of_file.value_or(TissueLaw{});
  }
  const bool is_as_needed = law == law_as_needed;
  const RegisteredLaw& named =
      **std::ranges::find(registered_laws(), is_as_needed ? "neo-hookean" : law, &RegisteredLaw::name);
  const bool meets_another = std::ranges::any_of(content.laws, [&](const auto& own) {
    return own.second.text != nullptr && own.second.text != named.text;
  });
  return is_as_needed && meets_another ? TissueLaw{} : TissueLaw{named.text, named.parameter};
}

/// Void weighs nothing, and what goes on through it does so by the linear law, which nothing turns over.
void read_void(TomlReader& table, Tissue& tissue) {
  if (tissue.density.value_or(0.0) > 0.0) {
    table.fail("density", "must be 0 where modulus is: void weighs nothing");
  }
  if (tissue.law && tissue.law->text != nullptr) {
    table.fail("law", "must be \"linear\" where modulus is 0: void has none");
  }
  if (tissue.fibres) {
    table.fail("fibre_modulus", "has no effect where modulus is 0: void has no fibres");
  }
  tissue.density = 0.0;
  tissue.law = TissueLaw{};
}

/// "0, 2, 3 (120 pixels)": the labels without a tissue; empty where each has one.
std::string labels_without(const std::map<int, Tissue>& tissues, const LabelField& labels) {
  std::set<int> missing;
  const auto pixels = std::ranges::count_if(labels.values, [&](int label) {
    const bool is_missing = !tissues.contains(label);
    if (is_missing) {
      missing.insert(label);
    }
    return is_missing;
  });
  return missing.empty() ? "" : fmt::format("{} ({} pixels)", fmt::join(missing, ", "), pixels);
}

} // namespace

std::map<int, Tissue> read_tissues(TomlReader& scene, bool shown) {
  std::map<int, Tissue> tissues;
  for (TomlReader& table : scene.tables("tissue")) {
    Tissue tissue{.modulus = static_cast<float>(table.get<double>("modulus"))};
    (void)table.has("name");
    (void)table.has("source");
    table.read("density", tissue.density);
    tissue.law = read_law(table);
    tissue.fibres = read_fibres(table);
    if (tissue.modulus == 0.0F) {
      read_void(table, tissue);
    }
    if (double gray = 0.0; shown) {
      table.read("gray", gray);
      tissue.gray = static_cast<float>(gray);
    }
    const int label = table.get<int>("label");
    table.finish();
    if (!tissues.emplace(label, tissue).second) {
      table.fail("label", fmt::format("{} has a tissue already", label));
    }
  }
  return tissues;
}

void assign_tissues(TomlReader& scene, const std::map<int, Tissue>& tissues, Content& content,
                    bool needs_picture) {
  const Extent extent = content.labels.extent;
  content.segmented = true;
  content.modulus = ScalarField(extent);
  needs_picture = needs_picture && is_inspected(extent);
  if (needs_picture) {
    content.picture = ScalarField(extent);
  }
  std::set<int> idle;
  std::ranges::transform(tissues, std::inserter(idle, idle.end()), &std::pair<const int, Tissue>::first);
  auto tissue = tissues.end();
  for (std::size_t i = 0; i < content.labels.values.size(); ++i) {
    const int label = content.labels.values[i];
    if (tissue == tissues.end() || tissue->first != label) {
      tissue = tissues.find(label);
      idle.erase(label);
    }
    if (tissue == tissues.end()) {
      scene.fail("tissue",
                 fmt::format("none has the label {} of the pixel {}: the labels {} have no [[tissue]]", label,
                             extent.place(i), labels_without(tissues, content.labels)));
    }
    content.modulus.values[i] = tissue->second.modulus;
    if (needs_picture) {
      content.picture.values[i] = tissue->second.gray;
    }
  }
  for (const auto& [label, of_label] : tissues) {
    if (of_label.law) {
      content.laws.emplace(label, *of_label.law);
    }
    if (of_label.fibres && !idle.contains(label)) {
      content.fibres.emplace(label, *of_label.fibres);
    }
    if (of_label.density) {
      content.densities.emplace(label, *of_label.density);
    }
  }
  for (const int label : idle) {
    content.idle.push_back(fmt::format("{} {}, which no pixel has", idle_tissue, label));
  }
}

namespace {

/// Makes sites void that have tissue: void weighs nothing, has no fibres, and no wall holds it.
void make_void(const std::vector<bool>& empty, Level& level) {
  const auto clear = [&](std::vector<float>& of_sites) {
    for (std::size_t site = 0; site < of_sites.size(); ++site) {
      of_sites[site] = empty[site] ? 0.0F : of_sites[site];
    }
  };
  clear(level.modulus.values);
  std::ranges::for_each(level.force.planes, clear);
  std::ranges::for_each(level.fibre.planes, clear);
  std::ranges::for_each(level.springs, clear);
  std::ranges::for_each(level.walls, clear);
}

/// Makes specks void that nothing holds: else a single voxel in the air would be why there is no answer.
/// Returns, as of Scene::idle, what became of them.
std::vector<std::string> without_specks(Level& level) {
  const Specks specks = loose_specks(level);
  if (specks.parts == 0) {
    return {};
  }
  std::vector<bool> empty(level.extent.sites());
  for (const std::size_t site : specks.sites) {
    empty[site] = true;
  }
  make_void(empty, level);
  const std::size_t axes = level.extent.axes();
  return {fmt::format("tissue of {} speck{} in void, {} {}{} in all, which nothing holds and which is void "
                      "(fewer than {} each)",
                      specks.parts, specks.parts == 1 ? "" : "s", specks.sites.size(),
                      axes == 3 ? "voxel" : "pixel", specks.sites.size() == 1 ? "" : "s",
                      fewest_sites_of_part(axes))};
}

} // namespace

std::vector<std::string> fill_void(TomlReader& scene, const RegisteredEnergy& energy, Level& level) {
  std::vector<float>& moduli = level.modulus.values;
  const auto is_void = [](float modulus) { return modulus == 0.0F; };
  if (std::ranges::none_of(moduli, is_void)) {
    return {};
  }
  if (!energy.is_of_cells()) {
    scene.fail("tissue", fmt::format("of modulus 0 is void, which the {} energy does not know; give energy = "
                                     "\"elastic\"",
                                     energy.name));
  }
  if (has_laws(level) && level.has_walls) { // then cells with a corner in void carry nothing
    std::vector<bool> empty(moduli.size());
    std::transform(moduli.begin(), moduli.end(), empty.begin(), is_void);
    make_void(with_bumps(empty, level), level);
  }
  std::vector<std::string> idle = without_specks(level);
  const float stiffest = std::ranges::max(moduli);
  const float filling = 0.5F * void_share * stiffest;
  if (!(filling > 0.0F && std::isfinite(1.0F / filling))) {
    scene.fail("tissue",
               "of modulus 0 is void: some pixel needs a tissue that is not, of at least 1e-30 MPa");
  }
  for (std::size_t site = 0; site < moduli.size(); ++site) {
    if (is_void(moduli[site])) {
      moduli[site] = filling;
      if (has_laws(level)) { // what goes on through void does so by the linear law, which nothing turns over
        level.law_parameter.values[site] = TissueLaw{}.parameter;
      }
    }
  }
  return idle;
}

void apply_laws(TomlReader& scene, const Content& content, const RegisteredEnergy& energy,
                const std::string& law, Level& level) {
  const TissueLaw usual = usual_law(read_law(scene), content, law);
  const Law* text = usual.text;
  for (const auto& [label, own] : content.laws) {
    if (text != nullptr && own.text != nullptr && own.text != text) {
      scene.fail("tissue",
                 fmt::format("of label {} has a law of another text than others have: tissues of one "
                             "image have one, or are linear",
                             label));
    }
    text = own.text != nullptr ? own.text : text;
  }
  if (text == nullptr) {
    return;
  }
  if (!energy.takes_laws) {
    throw InputError(fmt::format("a law of large strains is nothing that the {} energy knows; give energy = "
                                 "\"elastic\", or --energy elastic",
                                 energy.name));
  }
  level.law = text;
  level.law_parameter = ScalarField(level.extent, usual.parameter);
  if (content.laws.empty()) {
    return;
  }
  int label = 0; // of the site before: neighbours mostly have the same
  float of_label = usual.parameter;
  for (std::size_t site = 0; site < level.extent.sites(); ++site) {
    if (site == 0 || content.labels.values[site] != label) {
      label = content.labels.values[site];
      const auto own = content.laws.find(label);
      of_label = own == content.laws.end() ? usual.parameter : own->second.parameter;
    }
    level.law_parameter.values[site] = of_label;
  }
}

} // namespace hdmbench
