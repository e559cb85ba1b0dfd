/// A log that lost its end holds a record that fits in itself; what was acknowledged tells.
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <fstream>
#include <random>

#include "acquisition/record/chain_check.hpp"
#include "acquisition/record/status.hpp"
#include "tests/acquisition/record/runs.hpp"

namespace gyrotherm {
namespace {

constexpr int kSeconds = 40;  ///< few enough that the log was never folded in: each of its bytes counts

/// An unfinished run whose writer has died, a transaction a second.
void leave_behind(const std::string& path) {
  if (const auto child = ::fork(); child != 0) {
    ASSERT_EQ(::waitpid(child, nullptr, 0), child);
    return;
  }
  auto store = Store::create(path, two_thermometers());
  for (int slot = 0; store && slot < kSeconds; ++slot) {
    (void)(*store)->append(sample_at(slot), {});
    (void)(*store)->sync();
  }
  ::_exit(0);
}

std::string finding(const std::string& path) {
  const auto lost = lost_end(path);
  if (!lost) return text(lost.error());
  return *lost ? in_words(**lost) : "nothing";
}

TEST(LostEnd, OfALogIsFoundWhereverItWasCutOff) {
  const Folder folder;
  const auto path = folder / "run.db";
  leave_behind(path);
  ASSERT_EQ(finding(path), "nothing");
  const auto whole = std::filesystem::file_size(path + "-wal");
  std::filesystem::copy_file(path + "-wal", folder / "log");
  std::mt19937_64 random(16);
  for (int i = 0; i < 100; ++i) {
    std::filesystem::copy_file(folder / "log", path + "-wal", std::filesystem::copy_options::overwrite_existing);
    std::filesystem::resize_file(path + "-wal", random() % whole);
    const auto last = read_record(path)->slot.size();
    ASSERT_LT(last, static_cast<std::size_t>(kSeconds));
    const auto words = "ends at second " + std::to_string(static_cast<int>(last) - 1) +
                       ", but second 39 was acknowledged: its end is lost";
    EXPECT_EQ(finding(path), words);
    const auto verified = verify_record(path);
    ASSERT_FALSE(verified);
    EXPECT_EQ(verified.error().kind, FaultKind::bad_file);
    EXPECT_EQ(verified.error().what, words);
  }
}

TEST(LostEnd, IsToldByTheStatusOfTheSameRunAlone) {
  const Folder folder;
  const auto path = folder / "run.db";
  leave_behind(path);
  std::filesystem::remove(path + "-wal");
  const auto status = parse_status(
                          [&] {
                            std::ifstream file(status_path(path));
                            return std::string(std::istreambuf_iterator<char>(file), {});
                          }(),
                          "status")
                          .value();
  EXPECT_NE(finding(path), "nothing");
  auto other = status;
  other.id = "another";
  ASSERT_TRUE(write_status(other));
  EXPECT_EQ(finding(path), "nothing");
  std::ofstream(status_path(path)) << "[[[[";
  EXPECT_EQ(finding(path), "nothing");
  std::filesystem::remove(status_path(path));
  EXPECT_EQ(finding(path), "nothing");
  ASSERT_TRUE(write_status(status));
  auto store = Store::reopen(path).value();
  ASSERT_TRUE(store->finish());
  store.reset();
  ASSERT_TRUE(write_status(status));
  EXPECT_EQ(finding(path), "nothing") << "a finished run says itself where it ends";
}

}  // namespace
}  // namespace gyrotherm
