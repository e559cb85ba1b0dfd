// SPDX-License-Identifier: Apache-2.0
/// Tests the check of logs that SQLite wrote, unchanged and with one byte changed.
#include "acquisition/record/file_watch.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "acquisition/record/run_file.hpp"
#include "core/file.hpp"
#include "tests/acquisition/record/runs.hpp"

namespace gyrotherm::record {
namespace {

constexpr std::size_t kHeader = 32, kFrame = 24 + 4096;

std::string log_image(const std::string& path) {
  std::ifstream stream(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

/// A file in a temporary folder.
class TemporaryLog {
 public:
  explicit TemporaryLog(const std::string& text) {
    std::ofstream(folder_ / "log", std::ios::binary) << text;
    file_ = Descriptor(::open((folder_ / "log").c_str(), O_RDONLY | O_CLOEXEC));
  }
  [[nodiscard]] bool is_intact(std::size_t frames) const {
    return is_log_intact(file_.number(), static_cast<std::int64_t>(frames));
  }

 private:
  Folder folder_;
  Descriptor file_;
};

/// Returns the log of a record of 50 seconds, with only one checkpoint at its beginning.
std::string make_record_log() {
  const Folder folder;
  auto file = RunFile::create(folder / "run.db", two_thermometers()).value();
  for (std::int64_t slot = 0; slot < 50; ++slot) {
    const auto entry = sample_entry(sample_at(slot), {}, two_thermometers());
    EXPECT_TRUE(file.begin().and_then([&] { return file.insert(entry); }).and_then([&] { return file.commit(); }));
  }
  auto text = log_image(folder / "run.db-wal");
  file.leave_untouched();
  return text;
}

TEST(LogCheck, AcceptsUnchangedLog) {
  const auto log = make_record_log();
  const auto frames = (log.size() - kHeader) / kFrame;
  ASSERT_GE(frames, 50u);
  const TemporaryLog whole(log);
  EXPECT_TRUE(whole.is_intact(frames));
  EXPECT_TRUE(whole.is_intact(0));
  EXPECT_FALSE(whole.is_intact(frames + 1)) << "a missing frame";
  EXPECT_TRUE(TemporaryLog({}).is_intact(0));
  EXPECT_FALSE(TemporaryLog({}).is_intact(1));
}

TEST(LogCheck, DetectsChangeOfEveryByte) {
  const auto log = make_record_log();
  const auto frames = (log.size() - kHeader) / kFrame;
  for (std::size_t at = 0; at < kHeader + frames * kFrame; at += at < kHeader + kFrame ? 7 : 997) {
    auto other = log;
    other[at] = static_cast<char>(other[at] ^ 0x10);
    EXPECT_FALSE(TemporaryLog(other).is_intact(frames)) << at;
  }
}

TEST(LogCheck, AcceptsOnlyExistingFramesOfTruncatedLog) {
  const auto log = make_record_log();
  const TemporaryLog truncated(log.substr(0, kHeader + 5 * kFrame + 100));
  EXPECT_TRUE(truncated.is_intact(5));
  EXPECT_FALSE(truncated.is_intact(6));
}

}  // namespace
}  // namespace gyrotherm::record
