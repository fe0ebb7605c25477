#include "harness/measure/choices.hpp"

#include "harness/measure/median.hpp"
#include "harness/measure/result_file.hpp"
#include "harness/scene/file_output.hpp"
#include "harness/scene/row_fields.hpp"
#include "kernels/data/input_error.hpp"

#include <build_information.hpp>
#include <commit.hpp>
#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>

namespace hdmbench {

std::string describe(const Choice& choice) {
  std::string line = choice.what;
  for (const Choice::Option& option : choice.options) {
    line += fmt::format("{} {} {:.2f} ms", &option == &choice.options.front() ? ":" : ",", option.name,
                        median(option.seconds) * 1e3);
  }
  const std::string when =
      choice.measured.empty() ? "" : fmt::format(" (kept, measured {})", choice.measured);
  return fmt::format("{}: {}{}", line, choice.options[choice.chosen].name, when);
}

static void list_fields(Fields& fields, Choice::Option& option) {
  fields("name", option.name);
  fields("seconds", option.seconds);
}

static void require_consistent(const Choice::Option& option) {
  refuse_if(option.seconds.empty(), "seconds", "is empty");
}

void list_fields(Fields& fields, Choice& choice) {
  fields("what", choice.what);
  fields("options", choice.options);
  std::string chosen = fields.reading() ? "" : choice.options[choice.chosen].name;
  fields("chosen", chosen);
  const auto found = std::ranges::find(choice.options, chosen, &Choice::Option::name);
  refuse_if(found == choice.options.end(), "chosen", "is none of the options");
  fields.if_any("measured", choice.measured);
  choice.chosen = static_cast<std::size_t>(found - choice.options.begin());
}

void list_fields(Fields& fields, DeviceRow& row) {
  fields("backend", row.backend);
  fields("description", row.description);
  fields("updates", row.updates);
  fields("available", row.available);
  fields("device", row.device);
  fields("driver", row.driver);
  fields("software", row.software);
  fields("reason", row.reason);
  fields.newer("choices", row.choices);
}

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
  } catch (const std::exception& error) { // not JSON, or not ours
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
  } catch (const std::exception& error) { // it cannot be written
    note(file_, error.what());
  }
}

} // namespace hdmbench
