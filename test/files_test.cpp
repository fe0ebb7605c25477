// What is read and where it is written: links, pipes, devices, modes, full disks.

#include "test/files.hpp"

#include <sys/resource.h>
#include <sys/stat.h>

#include <csignal>
#include <thread>

namespace hdmbench {
namespace {

using test::refusal;

class Files : public ImageFiles {
protected:
  void SetUp() override {} // these are no images
};

TEST_F(Files, AreReplacedWithTheirMode) {
  const fs::path file = write("a.json", "old");
  fs::permissions(file, fs::perms::owner_read | fs::perms::owner_write | fs::perms::group_write);
  write_text(file, "new");
  EXPECT_EQ(read_file(file), "new");
  EXPECT_EQ(fs::status(file).permissions(),
            fs::perms::owner_read | fs::perms::owner_write | fs::perms::group_write);
  EXPECT_THAT(files(), ElementsAre("a.json"));
  fs::permissions(file, fs::perms::owner_read);
  EXPECT_THAT(refusal([&] { write_text(file, "newer"); }), HasSubstr("a.json: is read-only"));
  EXPECT_EQ(read_file(file), "new");
}

TEST_F(Files, AreWrittenWhereLinksLead) {
  fs::create_directory(path("elsewhere"));
  const fs::path file = write("elsewhere/a.json", "old");
  fs::create_symlink("elsewhere/a.json", path("link"));
  fs::create_symlink("link", path("link-to-link"));
  fs::create_symlink(path("elsewhere") / "b.json", path("dangling"));
  write_text(path("link-to-link"), "new");
  write_text(path("dangling"), "made");
  EXPECT_TRUE(fs::is_symlink(path("link")) && fs::is_symlink(path("link-to-link")));
  EXPECT_EQ(read_file(file), "new");
  EXPECT_EQ(read_file(path("elsewhere/b.json")), "made");
  fs::create_symlink("loop", path("loop"));
  EXPECT_THAT(refusal([&] { write_text(path("loop"), "new"); }), HasSubstr("symbolic links"));
  EXPECT_THAT(refusal([&] { write_text(path("loop") / "a.json", "new"); }), HasSubstr("symbolic links"));
}

TEST_F(Files, ThatArePipesAndDevicesAreWrittenTo) {
  ASSERT_EQ(mkfifo(path("pipe").c_str(), 0600), 0);
  std::string received;
  std::thread reader([&] {
    std::ifstream stream(path("pipe"));
    received.assign(std::istreambuf_iterator<char>(stream), {});
  });
  const std::string text(100'000, 'x'); // more than a pipe holds
  write_text(path("pipe"), text);
  reader.join();
  EXPECT_EQ(received, text);
  EXPECT_TRUE(fs::is_fifo(path("pipe")));
  write_text("/dev/null", text);
  EXPECT_TRUE(fs::is_character_file("/dev/null"));
  EXPECT_THAT(refusal([&] { write_text("/dev/full", text); }), HasSubstr("/dev/full: cannot be written"));
}

TEST_F(Files, ThatCannotBeWrittenWholeLeaveNothing) {
  const fs::path file = write("a.json", "old");
  EXPECT_THROW(write_atomically(file,
                                [&](const fs::path& partial) {
                                  std::ofstream(partial) << "half";
                                  throw InputError("no more");
                                }),
               InputError);
  const auto handler = std::signal(SIGXFSZ, SIG_IGN); // as main() does
  rlimit before{};
  getrlimit(RLIMIT_FSIZE, &before);
  const rlimit small{.rlim_cur = 1000, .rlim_max = before.rlim_max};
  setrlimit(RLIMIT_FSIZE, &small);
  const std::string why = refusal([&] { write_text(file, std::string(100'000, 'x')); });
  setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, handler);
  EXPECT_THAT(why, HasSubstr("a.json: cannot be written: File too large"));
  EXPECT_EQ(read_file(file), "old");
  EXPECT_THAT(files(), ElementsAre("a.json"));
}

} // namespace
} // namespace hdmbench
