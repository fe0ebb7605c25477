#include "harness/report/report.hpp"

#include "harness/measure/result_file.hpp"
#include "harness/report/html.hpp"
#include "harness/report/results.hpp"
#include "harness/report/table.hpp"
#include "harness/report/verdict.hpp"
#include "harness/scene/files.hpp"
#include "harness/scene/names.hpp"
#include "harness/scene/row_fields.hpp"
#include "kernels/data/input_error.hpp"
#include "report_assets/chart_script.hpp"
#include "report_assets/elements_script.hpp"
#include "report_assets/folded_script.hpp"
#include "report_assets/page_parts.hpp"
#include "report_assets/page_style.hpp"
#include "report_assets/report_script.hpp"
#include "report_assets/report_text.hpp"
#include "report_assets/sections_script.hpp"

#include <commit.hpp>
#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <map>
#include <random>
#include <set>
#include <utility>
#include <vector>

namespace hdmbench {

namespace {

using nlohmann::json;
using Path = std::filesystem::path;

/// A list of more numbers is for programs, not for a page.
constexpr std::size_t longest_list = 100;

bool stays_out(const json& value) {
  return value.is_array() && !value.empty() &&
         (value.front().is_array() || (value.size() > longest_list && !value.front().is_object()));
}

/// What the page carries: numbers with seven digits; objects of a list as {"keys", "rows"}, so that a key
/// stands there once. As deep as a result file, which read_results limits.
// NOLINTNEXTLINE(misc-no-recursion)
json packed(const json& value) {
  if (value.is_number_float()) {
    return std::strtod(fmt::format("{:.7g}", value.get<double>()).c_str(), nullptr);
  }
  if (value.is_object()) {
    json object = json::object();
    for (const auto& [key, item] : value.items()) {
      if (!stays_out(item)) {
        object[key] = packed(item);
      }
    }
    return object;
  }
  if (!value.is_array()) {
    return value;
  }
  json list = json::array();
  std::ranges::transform(value, std::back_inserter(list), packed);
  if (list.size() < 2 || !std::ranges::all_of(list, &json::is_object)) {
    return list;
  }
  std::set<std::string> keys;
  for (const json& object : list) {
    for (const auto& [key, item] : object.items()) {
      keys.insert(key);
    }
  }
  json rows = json::array();
  for (const json& object : list) {
    json row = json::array();
    for (const std::string& key : keys) {
      row.push_back(object.value(key, json()));
    }
    rows.push_back(std::move(row));
  }
  return {{"keys", keys}, {"rows", std::move(rows)}};
}

/// The pictures of a page by folder and name, as data URIs.
struct Pictures {
  std::map<std::string, std::string> uris;
  std::set<std::string> named; ///< by results

  /// Takes each picture that `value` names: a text that ends in .png or .jpg. Components of a difference and
  /// Jacobians are not shown.
  // NOLINTNEXTLINE(misc-no-recursion)
  void add_named(const json& value, const Path& folder, const std::string& prefix, bool is_shown = true) {
    static const std::set<std::string> not_shown{"x", "y", "jacobian"};
    if (value.is_string() && is_picture(value.get<std::string>())) {
      named.insert(prefix + value.get<std::string>());
      if (is_shown) {
        add(folder, value.get<std::string>(), prefix);
      }
    }
    if (value.is_structured()) {
      for (const auto& [key, item] : value.items()) {
        add_named(item, folder, prefix, !not_shown.contains(key));
      }
    }
  }
  /// Takes what else lies in the folder.
  void add_loose(const Path& folder, const std::string& prefix) {
    std::set<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(folder)) {
      names.insert(entry.path().filename().string());
    }
    for (const std::string& name : names) {
      if (is_picture(name) && !named.contains(prefix + name)) {
        add(folder, name, prefix);
      }
    }
  }

private:
  static bool is_picture(std::string_view name) { return name.ends_with(".png") || name.ends_with(".jpg"); }

  void add(const Path& folder, const std::string& name, const std::string& prefix) {
    constexpr std::size_t most = 1'500'000; // characters of all, half of what a page may have
    std::error_code ignored;
    if (uris.contains(prefix + name) || !std::filesystem::is_regular_file(folder / name, ignored)) {
      return;
    }
    const std::string bytes = read_file(folder / name);
    const bool is_png = bytes.starts_with("\x89PNG\r\n\x1A\n");
    if ((!is_png && !bytes.starts_with("\xFF\xD8\xFF")) || size_ + bytes.size() * 4 / 3 > most) {
      return;
    }
    size_ += bytes.size() * 4 / 3;
    uris[prefix + name] =
        fmt::format("data:image/{};base64,{}", is_png ? "png" : "jpeg", report::base64(bytes));
  }

  std::size_t size_ = 0;
};

/// Commits between the one that made results and the program's own; null where it is none of these.
json commits_ago(const std::string& commit) {
  constexpr std::size_t length = 12;
  const std::size_t at =
      commit.size() < length ? std::string_view::npos : build::history.find(commit.substr(0, length));
  return at == std::string_view::npos ? json() : json(at / (length + 1));
}

json page_data(const report::Results& results) {
  json files = json::array();
  Pictures pictures;
  std::map<Path, std::string> folders;
  for (const report::Source& source : results) {
    const Path folder = source.file.parent_path();
    const std::string prefix = folders.try_emplace(folder, fmt::format("{}/", folders.size())).first->second;
    pictures.add_named(source.results, folder, prefix);
    files.push_back({{"file", source.file.filename().string()},
                     {"folder", prefix},
                     {"command", source.command},
                     {"context", source.context},
                     {"replaced", source.replaced},
                     {"commits_ago", commits_ago(source.context.commit)},
                     {"results", packed(source.results)}});
  }
  for (const auto& [folder, prefix] : folders) {
    pictures.add_loose(folder.empty() ? Path(".") : folder, prefix);
  }
  json machines = json::array();
  for (const std::string& machine : machines_of(results)) {
    machines.push_back(report::verdict_of(results, machine));
    machines.back()["name"] = machine;
  }
  return {{"files", files},
          {"machines", machines},
          {"pictures", pictures.uris},
          {"named", pictures.named},
          {"published", published()}};
}

/// For a script element, which a "<" inside a text could end.
std::string script_text(const json& data) {
  std::string text;
  for (const char letter : json_text(data)) {
    text += letter == '<' ? std::string("\\u003c") : std::string(1, letter);
  }
  return text;
}

std::string page_html(const report::Results& results) {
  std::random_device random;
  const std::string nonce = fmt::format("{:08x}{:08x}{:08x}", random(), random(), random());
  std::string scripts =
      fmt::format("<script nonce=\"{}\">const PAGE = {};</script>\n", nonce, sources::page_parts);
  for (const std::string_view script :
       {sources::elements_script, sources::chart_script, sources::sections_script, sources::folded_script,
        sources::report_script}) {
    scripts += fmt::format("<script nonce=\"{}\">{}</script>\n", nonce, script);
  }
  return fmt::format(
      fmt::runtime(sources::report_text), fmt::arg("nonce", nonce),
      fmt::arg("title", report::escape("hdmbench on " + joined(machines_of(results), " and "))),
      fmt::arg("style", sources::page_style), fmt::arg("data", script_text(page_data(results))),
      fmt::arg("scripts", scripts));
}

} // namespace

void write_report(std::span<const Path> results, const Path& page) {
  require_writable(page);
  write_text(page, page_html(report::load_results(results)));
}

} // namespace hdmbench
