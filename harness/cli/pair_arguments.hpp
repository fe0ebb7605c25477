#pragma once

#include "harness/cli/arguments.hpp"

#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace hdmbench::commands {

/// Two pictures and what is known of them.
struct PictureData {
  Scene scene;
  ScalarField source; ///< gray values of both 0 ... 255, on one scale
  ScalarField target;
  ScalarField region;    ///< not 0: of interest; empty where none was asked for
  Placement placement{}; ///< of the source; the scene's where the file cannot say
};

/// Arguments of the commands that compare two pictures.
struct PairArguments {
  std::filesystem::path source;
  std::filesystem::path target;
  std::filesystem::path region; ///< empty: none
  std::filesystem::path output = "hdmbench-output";
  SceneArguments scene;

  /// `detects`: then a region is required, and there is one way to solve.
  void add_to(CLI::App& command, Call& call, bool detects);
  /// Throws InputError where the two, the scene and the region do not belong together: other sizes or
  /// spacings, no overlap, one gray value, no labels, an empty region.
  [[nodiscard]] PictureData load() const;
  /// Makes the folder and sees that files can be written and are none of the inputs, before long work.
  /// Throws InputError.
  void require_output(std::span<const std::string> files) const;
};

/// Writes pictures into the output folder; the rows of `register` and `detect` name them.
class Pictures {
public:
  /// Their names are as the result file `results` has them.
  Pictures(std::filesystem::path folder, std::filesystem::path results)
      : folder_(std::move(folder)), results_(std::move(results)) {}

  void gray(const std::string& name, const std::string& caption, const ScalarField& picture);
  /// Red above 0 and blue below, full at `largest`; over `ground`, where there is one.
  void signed_values(const std::string& name, const std::string& caption, const ScalarField& values,
                     double largest, const ScalarField& ground = {});
  /// [{caption, file: relative to the result file}, ...]
  [[nodiscard]] const json& written() const { return written_; }

private:
  [[nodiscard]] std::filesystem::path file(const std::string& name, const std::string& caption);

  std::filesystem::path folder_;
  std::filesystem::path results_;
  json written_ = json::array();
};

} // namespace hdmbench::commands
