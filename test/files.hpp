#pragma once

#include "harness/scene/files.hpp"
#include "harness/scene/images/images.hpp"
#include "kernels/data/input_error.hpp"
#include "test/suite.hpp"

namespace hdmbench::test {

/// A folder for the files of a test.
class TemporaryFolder : public TemporaryDirectory {
public:
  [[nodiscard]] std::filesystem::path write(std::string_view name, std::string_view text) const {
    const auto file = path() / name;
    std::ofstream(file, std::ios::binary) << text;
    return file;
  }
};

/// The bytes of the files in a folder, by name; none where there is no such folder.
inline std::map<std::string, std::string> files_in(const std::filesystem::path& folder) {
  std::map<std::string, std::string> files;
  if (std::filesystem::exists(folder)) {
    for (const auto& entry : std::filesystem::directory_iterator(folder)) {
      std::ifstream stream(entry.path(), std::ios::binary);
      files[entry.path().filename()].assign(std::istreambuf_iterator<char>(stream), {});
    }
  }
  return files;
}

/// What the error says that `call` throws; "accepted" where there is none.
template <typename Error = InputError, typename Call>
std::string refusal(const Call& call) {
  try {
    call();
  } catch (const Error& error) {
    return error.what();
  }
  return "accepted";
}

} // namespace hdmbench::test

namespace hdmbench {

namespace fs = std::filesystem;

inline void expect_refusal(const std::function<void()>& call, std::string_view part) {
  const std::string words = test::refusal(call);
  EXPECT_NE(words.find(part), std::string::npos) << "expected \"" << part << "\" in: " << words;
  EXPECT_EQ(words.find('\n'), std::string::npos) << words;
}

inline std::string content(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

/// Tests that read and write files; skipped in a build that cannot.
class ImageFiles : public testing::Test {
protected:
  void SetUp() override {
    if (!have_images()) {
      GTEST_SKIP() << "built without ITK (HDMBENCH_IMAGES=OFF)";
    }
  }

  [[nodiscard]] fs::path path(std::string_view name) const { return folder_.path() / name; }

  fs::path write(std::string_view name, std::string_view bytes) const { return folder_.write(name, bytes); }

  fs::path write_nrrd(std::string_view name, std::string_view type, std::string_view sizes,
                      std::string_view pixels, std::string_view more = "") const {
    const auto dimension = 1 + std::ranges::count(sizes, ' ');
    return write(name, fmt::format("NRRD0004\ntype: {}\ndimension: {}\n{}sizes: {}\nencoding: ascii\n\n{}\n",
                                   type, dimension, more, sizes, pixels));
  }

  /// The first `share` of a file's bytes under another name.
  fs::path cut(const fs::path& file, double share, std::string_view name) const {
    const std::string whole = content(file);
    return write(name,
                 std::string_view(whole).substr(0, static_cast<std::size_t>(share * double(whole.size()))));
  }

  /// Names of the files and folders, in alphabetical order.
  [[nodiscard]] std::vector<std::string> files() const {
    std::set<std::string> names;
    for (const auto& entry : fs::directory_iterator(folder_.path())) {
      names.insert(entry.path().filename());
    }
    return {names.begin(), names.end()};
  }

private:
  test::TemporaryFolder folder_;
};

inline VectorField some_displacement(Extent extent) {
  VectorField field(extent);
  std::mt19937 random(1);
  for (std::vector<float>& component : field.planes) {
    std::ranges::generate(component,
                          [&random] { return static_cast<float>(random() % 2001) * 0.05F - 50.0F; });
  }
  return field;
}

} // namespace hdmbench
