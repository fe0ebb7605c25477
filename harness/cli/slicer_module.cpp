#include "harness/cli/slicer_module.hpp"

#include "harness/cli/commands.hpp"

#include <build_information.hpp>
#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <vector>

namespace hdmbench::commands {

namespace {

std::string escaped(std::string_view text) {
  std::string result;
  for (const char c : text) {
    result += c == '&'    ? std::string("&amp;")
              : c == '<'  ? std::string("&lt;")
              : c == '>'  ? std::string("&gt;")
              : c == '"'  ? std::string("&quot;")
              : c == '\n' ? std::string(" ")
                          : std::string(1, c);
  }
  return result;
}

std::string element(int depth, std::string_view name, std::string_view text) {
  return fmt::format("{:{}}<{}>{}</{}>\n", "", 2 * depth, name, escaped(text), name);
}

/// "leave_one_out" of "--leave-one-out".
std::string identifier(const CLI::Option& option) {
  std::string name = option.get_lnames().empty() ? option.get_name() : option.get_lnames().front();
  std::ranges::replace(name, '-', '_');
  return name;
}

/// "leave one out".
std::string label_of(const CLI::Option& option) {
  std::string label = identifier(option);
  std::ranges::replace(label, '_', ' ');
  return label;
}

/// An element of Slicer's, with its attributes, and whether it is an input or an output; neither is empty.
struct Parameter {
  std::string element;
  std::string attributes{};
  std::string channel{};
  std::vector<std::string> choices{};
};

std::vector<std::string> choices_of(const std::string& type) {
  std::vector<std::string> choices;
  const std::size_t begin = type.find('{');
  for (std::size_t at = begin; at < type.size() && type[at] != '}';) {
    const std::size_t end = type.find_first_of(",}", at + 1);
    choices.push_back(type.substr(at + 1, end - at - 1));
    at = end;
  }
  return choices;
}

/// What is no flag. Slicer passes every number and every choice that it shows, so one without a default,
/// which would not be passed here, is a text that may stay empty.
Parameter parameter_of(const CLI::Option& option) {
  const std::string type = option.get_type_name();
  const bool is_list = option.get_items_expected_max() > 1;
  const std::string multiple = is_list ? " multiple=\"true\"" : "";
  const std::map<std::string_view, Parameter> files{
      {"FOLDER", {"directory", "", "output"}},
      {"FILE", {"file", "", "output"}},
      {"FILE:IMAGE", {"image", " type=\"scalar\" fileExtensions=\".nrrd\"", "output"}},
      {"FILE:TRANSFORM", {"transform", " type=\"nonlinear\" fileExtensions=\".h5\"", "output"}},
      {"TOML", {"file", " fileExtensions=\".toml\"" + multiple, "input"}},
      {"IMAGE", {"image", " type=\"scalar\"" + multiple, "input"}},
      {"LABELS", {"image", " type=\"label\"" + multiple, "input"}},
      {"POINTS", {"pointfile", " fileExtensions=\".fcsv\" coordinateSystem=\"lps\"" + multiple, "input"}},
      {"TRANSFORM", {"transform", " fileExtensions=\".h5\"" + multiple, "input"}}};
  if (const auto file = files.find(type); file != files.end()) {
    return file->second;
  }
  const bool has_default = !option.get_default_str().empty() && !is_list;
  if (const auto choices = choices_of(type); !choices.empty() && has_default) {
    return {.element = "string-enumeration", .choices = choices};
  }
  return {.element = !has_default                                          ? "string"
                     : type.starts_with("INT") || type.starts_with("UINT") ? "integer"
                     : type.starts_with("FLOAT")                           ? "double"
                                                                           : "string"};
}

std::string text_of(const CLI::Option& option, int index) {
  const bool is_flag = option.get_items_expected_max() == 0;
  const Parameter parameter = is_flag ? Parameter{"boolean"} : parameter_of(option);
  std::string text = fmt::format("    <{}{}>\n", parameter.element, parameter.attributes);
  text += element(3, "name", identifier(option));
  text += option.get_positional() ? element(3, "index", std::to_string(index))
                                  : element(3, "longflag", "--" + identifier(option));
  text += element(3, "description", option.get_description());
  text += element(3, "label", label_of(option));
  if (const std::string value = is_flag ? "false" : option.get_default_str(); !value.empty()) {
    text += element(3, "default", value);
  }
  if (!parameter.channel.empty()) {
    text += element(3, "channel", parameter.channel);
  }
  for (const std::string& choice : parameter.choices) {
    text += element(3, "element", choice);
  }
  return text + fmt::format("    </{}>\n", parameter.element);
}

} // namespace

std::string slicer_description(const CLI::App& command) {
  const std::string help = command.get_description();
  const std::size_t first = help.find('\n');
  std::string text = "<?xml version=\"1.0\" encoding=\"utf-8\"?>\n<executable>\n";
  text += element(1, "category", "Registration.hdmbench");
  text += element(1, "title", fmt::format("hdmbench {}", command.get_name()));
  text += element(1, "description", help.substr(first == std::string::npos ? 0 : first + 1));
  text += element(1, "version", build::version);
  text += element(1, "license", "MIT");
  std::vector<std::string> groups{"Positionals"};
  for (const CLI::Option* const option : command.get_options()) {
    if (std::ranges::find(groups, option->get_group()) == groups.end()) {
      groups.push_back(option->get_group());
    }
  }
  int index = 0;
  for (const std::string& group : groups) {
    std::string of_group;
    for (const CLI::Option* const option : command.get_options()) {
      const bool is_here = option->get_positional() ? group == groups.front() : option->get_group() == group;
      if (is_here && option != command.get_help_ptr() && identifier(*option) != "xml") {
        of_group += text_of(*option, option->get_positional() ? index++ : 0);
      }
    }
    if (!of_group.empty()) {
      const bool is_usual = group == groups.front() || group == "Options";
      text += fmt::format("  <parameters{}>\n", is_usual ? "" : " advanced=\"true\"");
      text += element(2, "label", group == groups.front() ? "What it reads" : group);
      text += element(2, "description", group == groups.front() ? "Input" : group);
      text += of_group + "  </parameters>\n";
    }
  }
  return text + "</executable>";
}

void add_slicer_description(CLI::App& command) {
  command.option_defaults()->group("Options");
  command
      .add_flag_callback(
          "--xml", [&command] { throw CLI::CallForVersion(slicer_description(command), 0); },
          "Print what 3D Slicer asks its modules for, and stop")
      ->trigger_on_parse();
}

void take_underscores(const CLI::App& command, std::span<char*> words) {
  for (char* const word : words) {
    std::string name(std::string_view(word).substr(0, std::string_view(word).find('=')));
    if (!name.starts_with("--") || command.get_option_no_throw(name) != nullptr) {
      continue;
    }
    std::ranges::replace(name, '_', '-');
    if (command.get_option_no_throw(name) != nullptr) {
      std::ranges::copy(name, word);
    }
  }
}

} // namespace hdmbench::commands
