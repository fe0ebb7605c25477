#pragma once

#include "harness/applications/picture.hpp"
#include "harness/scene/images/images.hpp"
#include "harness/scene/sites.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <random>
#include <string>
#include <string_view>
#include <vector>

/// Small random files that the commands of the program read.
namespace hdmbench::test {

namespace fs = std::filesystem;
using Words = std::vector<std::string>;

/// The same draws on every machine.
class Draw {
public:
  explicit Draw(int seed) : engine_(static_cast<std::uint64_t>(seed)) {}
  int operator()(int low, int high) {
    return low + static_cast<int>(engine_() % static_cast<std::uint64_t>(high - low + 1));
  }
  bool once_in(int times) { return (*this)(1, times) == 1; }
  template <typename Values>
  auto one_of(const Values& values) {
    return *std::next(values.begin(), (*this)(0, static_cast<int>(values.size()) - 1));
  }

private:
  std::mt19937_64 engine_;
};

/// What a case reads: images of a person before and after, scenes, lists, results.
class Inputs {
public:
  Inputs(const fs::path& folder, const std::string& results, Draw& draw) : folder_(folder), draw_(draw) {
    write_pictures();
    for (int number = 0; number < 2; ++number) {
      scenes_.push_back(write(fmt::format("scene-{}.toml", number), scene_text()));
    }
    scenes_.push_back(write("person.toml", "[image]\nlabels = \"labels.nrrd\"\npicture = \"source.nrrd\"\n" +
                                               std::string(tissues)));
    (void)write("nodes.txt", "1,0,0,0.5,0\n2,10,0,0.5,1\n3,0,10,0,0\n4,10,10,1,1\n");
    (void)write("elements.txt", "1,1,2,4,3\n");
    (void)write("results.json", results);
  }

  [[nodiscard]] std::string scene() { return draw_.one_of(scenes_); }
  [[nodiscard]] std::string file(const std::string& name) const { return (folder_ / name).string(); }
  [[nodiscard]] Words all() const {
    Words names;
    for (const auto& entry : fs::directory_iterator(folder_)) {
      names.push_back(entry.path().string());
    }
    std::ranges::sort(names);
    return names;
  }
  /// Their bytes by name.
  [[nodiscard]] std::map<std::string, std::string> bytes() const {
    std::map<std::string, std::string> result;
    for (const std::string& name : all()) {
      std::ifstream stream(name, std::ios::binary);
      result[name] = std::string(std::istreambuf_iterator<char>(stream), {});
    }
    return result;
  }

  /// No target and no start is further than that, pixels.
  static constexpr int farthest = 8;

private:
  static constexpr std::string_view tissues =
      "[[tissue]]\nlabel = 0\nmodulus = 10.0\n[[tissue]]\nlabel = 1\nmodulus = 20.0\n";

  std::string write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name, std::ios::binary) << text;
    return file(name);
  }

  void write_pictures() {
    const Extent extent{40, 40};
    ScalarField source(extent);
    ScalarField target(extent);
    ScalarField region(extent);
    VectorField positions(extent);
    LabelField labels{extent, std::vector<int>(extent.sites())};
    GaussianNoise random(1);
    for_each_site(extent, [&](int x, int y) {
      const std::size_t site = extent.index(x, y);
      const auto gray = [&](double u, double v) {
        return static_cast<float>((120.0 + 60.0 * std::sin(0.6 * u) * std::cos(0.5 * v)) /
                                  (1.0 + std::exp(2.0 * (std::hypot(u - 20, v - 20) - 15.0))));
      };
      source.values[site] = gray(x, y);
      target.values[site] = gray(x - 0.02 * x * y / 10.0, y + 0.5) + static_cast<float>(random());
      labels.values[site] = std::hypot(x - 20, y - 20) < 16 ? 1 : 0;
      region.values[site] = std::hypot(x - 21, y - 19) < 6 ? 1.0F : 0.0F;
      positions.x[site] = static_cast<float>(x) + 0.5F;
      positions.y[site] = static_cast<float>(y);
    });
    write_scalar(folder_ / "source.nrrd", source, 1.0);
    write_scalar(folder_ / "target.nrrd", target, 1.0);
    write_scalar(folder_ / "region.nrrd", region, 1.0);
    write_vector(folder_ / "positions.nrrd", positions, 1.0);
    write_labels(folder_ / "labels.nrrd", labels, 1.0);
  }

  std::string number(double low, double high) {
    return fmt::format("{:.4f}", low + (high - low) * draw_(0, 1000) / 1000.0);
  }

  std::string conditions() {
    std::string text;
    for (int count = draw_(1, 3); count > 0; --count) {
      const std::string where = draw_.one_of(Words{"left", "right", "top", "bottom", "border"});
      text += fmt::format("[[condition]]\nwhere = \"{}\"\n", where);
      text += draw_.once_in(4) ? fmt::format("outward = {}\n", number(-farthest, farthest))
                               : fmt::format("dx = {}\ndy = {}\n", number(-farthest, farthest),
                                             number(-farthest, farthest));
      text += draw_.once_in(3) ? fmt::format("confidence = {}\n", number(0.0, 1.0)) : "";
    }
    return text;
  }

  std::string scene_text() {
    std::string text = fmt::format("size = [{}, {}]\n", draw_(1, 24), draw_(1, 24));
    text += draw_.once_in(3) ? fmt::format("spacing = {}\n", number(0.1, 3.0)) : "";
    text += draw_.once_in(3) ? fmt::format("poisson = {}\n", number(-0.5, 0.5)) : "";
    const bool elastic = draw_.once_in(4);
    text += elastic ? "energy = \"elastic\"\n"
                    : fmt::format("penalty = {}\n[schedule]\niterations = {}\nalignment = \"{}\"\n",
                                  number(0.1, 1000.0), draw_(0, 30), draw_.one_of(Words{"corner", "center"}));
    if (draw_.once_in(3)) {
      text += fmt::format("[random]\nseed = {}\nmodulus = [1.0, {}]\ndisplacement = {}\nobserved = {}\n",
                          draw_(0, 99), number(1.0, 1000.0), number(0.0, farthest), number(0.0, 1.0));
    } else {
      text += fmt::format(
          "[[shape]]\nkind = \"everything\"\nlabel = 0\n[[shape]]\nkind = \"ellipse\"\nlabel = 1\n"
          "centre = [{}, 0.5]\nsize = [0.4, {}]\n{}",
          number(0.0, 1.0), number(0.1, 1.0), tissues);
    }
    return text + conditions();
  }

  fs::path folder_;
  Draw& draw_;
  Words scenes_;
};

} // namespace hdmbench::test
