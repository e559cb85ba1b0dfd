// SPDX-License-Identifier: Apache-2.0
#include "core/file.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <set>

#include "tests/support/slept.hpp"

namespace gyrotherm {
namespace {

namespace fs = std::filesystem;

/// A temporary folder for one test.
class Files : public testing::Test {
 protected:
  Files() { fs::create_directories(folder_); }
  ~Files() override { fs::remove_all(folder_); }
  [[nodiscard]] std::string in(const std::string& name) const { return (folder_ / name).string(); }
  [[nodiscard]] std::set<std::string> names() const {
    std::set<std::string> found;
    for (const auto& entry : fs::directory_iterator(folder_)) found.insert(entry.path().filename().string());
    return found;
  }
  const fs::path folder_ = fs::path(testing::TempDir()) / ("files-" + std::to_string(::getpid()));
};

mode_t mode_of(const std::string& path) {
  struct stat facts {};
  return ::lstat(path.c_str(), &facts) == 0 ? facts.st_mode & 07777 : 0;
}

/// Returns "read", or the text of the fault. Fails the test if reading takes more than one second of processor time or
/// sleeps for as long.
std::string read_result(const std::string& path, std::size_t most = kLargestText) {
  const tests::SleepMeter meter;
  const auto worked = std::clock();
  const auto read = read_text_file(path, most);
  EXPECT_LT(std::clock() - worked, CLOCKS_PER_SEC) << path;
  EXPECT_LT(meter.slept(), std::chrono::seconds(1)) << path;
  if (read) return "read";
  EXPECT_EQ(read.error().kind, FaultKind::bad_file);
  return text(read.error());
}

using ReadFile = Files;
using ReplaceFile = Files;
using OwnFile = Files;

TEST_F(ReadFile, ReturnsWrittenText) {
  const std::string text("a\0b\r\n°", 7);
  ASSERT_TRUE(replace_text_file(in("f"), "old, and longer than what replaces it"));
  ASSERT_TRUE(replace_text_file(in("f"), text));
  EXPECT_EQ(read_text_file(in("f")).value(), text);
  EXPECT_EQ(names(), std::set<std::string>{"f"});
}

TEST_F(ReadFile, NamesMissingFile) {
  EXPECT_EQ(read_result("/nowhere/at/all.toml"), "/nowhere/at/all.toml: cannot be read: No such file or directory");
  EXPECT_EQ(read_text_file_if_any(in("none")).value(), std::nullopt);
}

TEST_F(ReadFile, RefusesPipesDevicesAndFolders) {
  ASSERT_EQ(::mkfifo(in("pipe").c_str(), 0600), 0);
  EXPECT_EQ(read_result(in("pipe")), in("pipe") + ": is a pipe, expected a regular file");
  EXPECT_EQ(read_result("/dev/zero"), "/dev/zero: is a device, expected a regular file");
  EXPECT_EQ(read_result(folder_.string()), folder_.string() + ": is a folder, expected a regular file");
  fs::create_symlink(in("pipe"), in("link"));
  EXPECT_EQ(read_result(in("link")), in("link") + ": is a pipe, expected a regular file");
  EXPECT_FALSE(read_text_file_if_any(in("pipe")));
}

TEST_F(ReadFile, RefusesFilesOfKernel) {
  EXPECT_EQ(read_result("/proc/self/mem"), "/proc/self/mem: cannot be read: Input/output error");
  EXPECT_NE(read_result("/proc/self/status").find("its size was 0 bytes, but more bytes were read"), std::string::npos);
  EXPECT_NE(read_result("/sys/kernel/mm/transparent_hugepage/enabled", 100'000).find("cannot be read"),
            std::string::npos);
}

TEST_F(ReadFile, ChecksSizeBeforeReading) {
  std::ofstream(in("sparse")).close();
  fs::resize_file(in("sparse"), 1ULL << 40);
  EXPECT_EQ(read_result(in("sparse")),
            in("sparse") + ":1:1: the file has 1099511627776 bytes, expected at most 4000000");
  fs::resize_file(in("sparse"), 100);
  EXPECT_EQ(read_result(in("sparse"), 99), in("sparse") + ":1:1: the file has 100 bytes, expected at most 99");
  EXPECT_EQ(read_result(in("sparse"), 100), "read");
  std::ofstream(in("run.db")) << kSqliteBeginning << std::string(100, 'x');
  EXPECT_EQ(
      read_result(in("run.db"), 99),
      in("run.db") + ":1:1: is an SQLite file, as records are, of 115 bytes, expected another file of at most 99");
}

TEST_F(ReadFile, FollowsLinkOnlyIfPermitted) {
  ASSERT_TRUE(replace_text_file(in("f"), "x"));
  fs::create_symlink("f", in("link"));
  EXPECT_EQ(read_text_file(in("link")).value(), "x");
  const auto refused = open_regular_file(in("link"), Links::refused);
  ASSERT_FALSE(refused);
  EXPECT_EQ(text(refused.error()), in("link") + ": is a link, expected a regular file");
  fs::create_symlink("nowhere", in("dangling"));
  EXPECT_FALSE(read_text_file_if_any(in("dangling"))) << "a dangling link is not a missing file";
  EXPECT_FALSE(read_text_file_if_any(in("link"), kLargestText, Links::refused));
}

TEST_F(ReplaceFile, FailsWhenPathIsNotWritable) {
  for (const std::string path : {"/nowhere/at/all.toml", folder_.c_str(), "/dev/null"}) {
    const auto written = replace_text_file(path, "x");
    ASSERT_FALSE(written) << path;
    EXPECT_EQ(written.error().kind, FaultKind::storage);
    EXPECT_EQ(written.error().where, path);
  }
  EXPECT_TRUE(fs::is_character_file("/dev/null"));
}

TEST_F(ReplaceFile, ReplacesTargetAndKeepsLink) {
  fs::create_directory(in("elsewhere"));
  ASSERT_TRUE(replace_text_file(in("elsewhere/target"), "old"));
  fs::create_symlink("elsewhere/target", in("link"));
  ASSERT_TRUE(replace_text_file(in("link"), "new"));
  EXPECT_TRUE(fs::is_symlink(in("link")));
  EXPECT_EQ(read_text_file(in("elsewhere/target")).value(), "new");
}

/// Earlier versions used these names for temporary files. Another program may have created a link with such a name.
TEST_F(ReplaceFile, FollowsNoLinkWithNameOfTemporaryFile) {
  ASSERT_TRUE(replace_text_file(in("precious"), "precious"));
  for (const char* name : {"f.part", "g.part"}) fs::create_symlink("precious", in(name));
  ASSERT_TRUE(replace_text_file(in("f"), "x"));
  ASSERT_TRUE(replace_own_file(in("g"), "x"));
  EXPECT_EQ(read_text_file(in("precious")).value(), "precious");
  EXPECT_EQ(names(), (std::set<std::string>{"f", "f.part", "g", "g.part", "precious"}));
}

TEST_F(ReplaceFile, AcceptsLongNameAndNameWithoutFolder) {
  const std::string longest(255, 'n');
  EXPECT_TRUE(replace_text_file(in(longest), "x"));
  EXPECT_TRUE(replace_own_file(in(longest), "y"));
  EXPECT_EQ(read_text_file(in(longest)).value(), "y");
  const auto before = fs::current_path();
  fs::current_path(folder_);
  EXPECT_TRUE(replace_text_file("here", "x"));
  EXPECT_TRUE(replace_own_file("here too", "x"));
  fs::current_path(before);
  EXPECT_TRUE(fs::exists(in("here")) && fs::exists(in("here too")));
}

TEST_F(OwnFile, ReplacesLinkWithoutFollowingIt) {
  ASSERT_TRUE(replace_text_file(in("precious"), "precious"));
  for (const std::string target : {"precious", "nowhere"}) {
    fs::remove(in("status"));
    fs::create_symlink(target, in("status"));
    ASSERT_TRUE(replace_own_file(in("status"), "mine", Syncing::not_awaited));
    EXPECT_FALSE(fs::is_symlink(in("status")));
    EXPECT_EQ(read_text_file(in("status")).value(), "mine");
  }
  EXPECT_EQ(read_text_file(in("precious")).value(), "precious");
  ASSERT_EQ(::mkfifo(in("pipe").c_str(), 0600), 0);
  EXPECT_TRUE(replace_own_file(in("pipe"), "mine"));
  EXPECT_FALSE(replace_own_file(folder_.string(), "mine"));
  EXPECT_EQ(names(), (std::set<std::string>{"pipe", "precious", "status"}));
}

TEST_F(OwnFile, IsForOwnerAndGroupUnlessUmaskExcludesGroup) {
  for (const mode_t mask : {0000, 0022, 0027, 0077}) {
    const auto before = ::umask(mask);
    EXPECT_TRUE(replace_own_file(in("own"), "x"));
    fs::remove(in("named"));
    EXPECT_TRUE(replace_text_file(in("named"), "x"));
    ::umask(before);
    EXPECT_EQ(mode_of(in("own")), mask == 0077 ? 0600u : 0640u) << mask;
    EXPECT_EQ(mode_of(in("named")), 0644u & ~mask) << mask;
  }
}

TEST_F(Files, AreWrittenWhollyDespiteSignal) {
  const std::string text(100'000'000, '.');
  const auto writer = ::fork();
  ASSERT_GE(writer, 0);
  if (writer == 0) {
    [[maybe_unused]] const auto written = replace_text_file(in("table.csv"), text);
    ::_exit(0);
  }
  while (names().empty() && ::waitpid(writer, nullptr, WNOHANG) == 0) ::usleep(1000);
  ::kill(writer, SIGTERM);
  ::waitpid(writer, nullptr, 0);
  EXPECT_EQ(names(), std::set<std::string>{"table.csv"});
  EXPECT_EQ(fs::file_size(in("table.csv")), text.size());
}

TEST(ListFolder, ReturnsEntries) {
  const auto entries = list_folder(GYROTHERM_SOURCE_DIR "/core");
  EXPECT_NE(std::find(entries.begin(), entries.end(), std::filesystem::path(GYROTHERM_SOURCE_DIR "/core/file.hpp")),
            entries.end());
}

TEST(ListFolder, IsEmptyForOtherPaths) {
  EXPECT_TRUE(list_folder("/nonexistent").empty());
  EXPECT_TRUE(list_folder("/etc/passwd").empty());
}

}  // namespace
}  // namespace gyrotherm
