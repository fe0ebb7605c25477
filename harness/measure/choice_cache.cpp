#include "harness/measure/choice_cache.hpp"

#include "harness/measure/context.hpp"
#include "harness/measure/device_row.hpp"
#include "harness/scene/file_output.hpp"
#include "harness/scene/row_fields.hpp"
#include "kernels/data/input_error.hpp"

#include <build_information.hpp>
#include <commit.hpp>
#include <fmt/format.h>

#include <cstdlib>
#include <fstream>

namespace hdmbench {

namespace {

constexpr int schema = 1;

/// As it stands in the file.
struct KeptChoice {
  std::array<std::string, 6> key; ///< in the order of list_fields()
  Choice choice;
};

void list_fields(Fields& fields, KeptChoice& row) {
  constexpr std::array<std::string_view, 6> names{"backend", "device", "driver", "version", "commit", "of"};
  for (std::size_t i = 0; i < names.size(); ++i) {
    fields(names[i], row.key[i]);
  }
  fields("choice", row.choice);
}

void note(const std::filesystem::path& file, std::string_view what) {
  std::fputs(fmt::format("hdmbench: {} is not used: {}\n", file.string(), what).c_str(), stderr);
}

std::filesystem::path folder_in(const char* variable) {
  const char* const value = std::getenv(variable);
  const std::filesystem::path folder = value == nullptr ? "" : value;
  return folder.is_absolute() ? folder : std::filesystem::path(); // others are to be ignored
}

} // namespace

std::filesystem::path choice_cache_file() {
  const std::filesystem::path cache = folder_in("XDG_CACHE_HOME");
  const std::filesystem::path home = folder_in("HOME");
  if (cache.empty() && home.empty()) {
    return {};
  }
  return (cache.empty() ? home / ".cache" : cache) / "hdmbench" / "choices.json";
}

ChoiceCache::Key ChoiceCache::key_of(std::string_view backend, const Device& device, std::string_view what) {
  return {std::string(backend),       device.name,      device.driver, std::string(build::version),
          std::string(build::commit), std::string(what)};
}

std::map<ChoiceCache::Key, Choice> ChoiceCache::read() const {
  std::map<Key, Choice> found;
  std::ifstream stream(file_);
  if (!stream) {
    return found;
  }
  try {
    const auto whole = nlohmann::json::parse(stream);
    if (whole.at("schema") != schema || !whole.at("choices").is_array()) {
      throw InputError("it has another schema");
    }
    const auto& rows = whole.at("choices");
    for (std::size_t i = 0; i < rows.size(); ++i) {
      KeptChoice kept;
      read_json_row(rows[i], JsonPlace{file_, "choices"}.element(i), kept);
      found.emplace(std::move(kept.key), std::move(kept.choice));
    }
  } catch (const nlohmann::json::exception& error) {
    note(file_, error.what());
    found.clear();
  } catch (const InputError& error) {
    note(file_, error.what());
    found.clear();
  }
  return found;
}

std::optional<Choice> ChoiceCache::find(std::string_view backend, const Device& device,
                                        std::string_view what) {
  if (!choices_) {
    choices_ = read();
  }
  const auto kept = choices_->find(key_of(backend, device, what));
  return kept == choices_->end() ? std::nullopt : std::optional(kept->second);
}

void ChoiceCache::keep(std::string_view backend, const Device& device, const Choice& choice) {
  std::map<Key, Choice> all = read(); // another process may have added some
  Choice dated = choice;
  dated.measured = run_context("", false).date;
  all.insert_or_assign(key_of(backend, device, choice.what), std::move(dated));
  // Of other builds of this program nobody will ask again.
  std::erase_if(all, [](const auto& entry) {
    return entry.first[3] != build::version || entry.first[4] != build::commit;
  });
  nlohmann::json whole{{"schema", schema}, {"choices", nlohmann::json::array()}};
  for (const auto& [key, kept] : all) {
    whole["choices"].push_back(to_json_row(KeptChoice{.key = key, .choice = kept}));
  }
  choices_ = std::move(all);
  try {
    std::filesystem::create_directories(file_.parent_path());
    write_text(file_, whole.dump(1) + "\n");
  } catch (const std::filesystem::filesystem_error& error) {
    note(file_, error.what());
  } catch (const InputError& error) {
    note(file_, error.what());
  }
}

} // namespace hdmbench
