#include "harness/judge/atlas/entry.hpp"

#include "harness/judge/atlas/families.hpp"
#include "kernels/data/input_error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

namespace hdmbench::atlas {

const std::vector<Entry>& entries() {
  static const std::vector<Entry> all = [] {
    std::vector<Entry> joined;
    for (auto* const group : {pyramid_entries, step_entries, material_entries, condition_entries,
                              model_entries, elastic_entries}) {
      std::ranges::move(group(), std::back_inserter(joined));
    }
    return joined;
  }();
  return all;
}

const Entry& find_entry(std::string_view name) {
  const auto found = std::ranges::find(entries(), name, &Entry::name);
  if (found == entries().end()) {
    std::string names;
    for (const Entry& entry : entries()) {
      names += fmt::format("{}{}", names.empty() ? "" : ", ", entry.name);
    }
    throw InputError(fmt::format("the atlas has no entry \"{}\"; its entries are {}", name, names));
  }
  return *found;
}

} // namespace hdmbench::atlas
