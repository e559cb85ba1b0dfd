// SPDX-License-Identifier: Apache-2.0
/// The safe-state file: its text, its path, and the files that are refused.
#include "sequencer/watchdog/safe_state_file.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "sequencer/watchdog/trail.hpp"
#include "tests/support/folder.hpp"

namespace gyrotherm::watchdog {
namespace {

SafeState safe_state() {
  return {.record = "/var/lib/gyrotherm/rate.db",
          .line = "tcp://10.0.0.7:502",
          .link = drivers::LinkKind::tcp,
          .word_order = drivers::WordOrder::cdab,
          .link_settings = {.unit = 7,
                            .timeout = std::chrono::milliseconds(800),
                            .read_at_most = 40,
                            .returns_other_transaction = true,
                            .miscounts_write_replies = false},
          .safe_set_point = {23.5},
          .switch_off = true,
          .by_program = false,
          .observe = std::chrono::minutes(2),
          .settings = {{"communication_unit", 15}, {"decimals", 1}},
          .written_by = {.pid = 4711, .started = 123456789, .boot = "0b5f1c52-29c2-4d6b-8a4b-3d1c0e6c2f10"},
          .map_text = "schema = \"gyrotherm-chamber/1\"\nname = \"F4T\"\n"};
}

constexpr const char* kLinkSettings =
    "link_settings = { unit = 7, timeout = \"0.8 s\", read_at_most = 40, returns_other_transaction = true, "
    "miscounts_write_replies = false }\n";
constexpr const char* kObserved = "observe_s = 120\nsettings = { \"communication_unit\" = 15, \"decimals\" = 1 }\n";

const std::string kGolden =
    "schema = \"gyrotherm-safe-state/2\"\n"
    "record = \"/var/lib/gyrotherm/rate.db\"\n"
    "line = \"tcp://10.0.0.7:502\"\n"
    "link = \"tcp\"\n" +
    std::string(kLinkSettings) +
    "word_order = \"cdab\"\n"
    "safe_set_point_c = 23.5\n"
    "switch_off = true\n"
    "by_program = false\n" +
    std::string(kObserved) +
    "pid = 4711\n"
    "started = 123456789\n"
    "boot = \"0b5f1c52-29c2-4d6b-8a4b-3d1c0e6c2f10\"\n"
    "map = [\n"
    "  \"schema = \\\"gyrotherm-chamber/1\\\"\",\n"
    "  \"name = \\\"F4T\\\"\",\n"
    "  \"\"\n"
    "]\n";

/// Returns the same state in the format of version 0.1.0.
std::string version_one_text() {
  auto text = kGolden;
  text.replace(text.find("state/2"), 7, "state/1");
  text.erase(text.find(kLinkSettings), std::string(kLinkSettings).size());
  text.erase(text.find(kObserved), std::string(kObserved).size());
  return text;
}

TEST(SafeStateFile, IsWrittenInFormatTwo) { EXPECT_EQ(to_text(safe_state()), kGolden); }

TEST(SafeStateFile, ReadsBothFormats) {
  const auto read = parse_safe_state(kGolden, "golden");
  ASSERT_TRUE(read) << text(read.error());
  EXPECT_EQ(*read, safe_state());
  const auto first = parse_safe_state(version_one_text(), "first");
  ASSERT_TRUE(first) << text(first.error());
  auto expected = safe_state();
  expected.link_settings = {};
  expected.observe = kUsualObserve;
  expected.settings.clear();
  EXPECT_EQ(*first, expected);
  auto third = kGolden;
  third.replace(third.find("state/2"), 7, "state/3");
  EXPECT_FALSE(parse_safe_state(third, "third"));
}

TEST(SafeStateFile, RefusesLinkSettingsThatNoLinkHas) {
  for (const auto* wrong : {"{ unit = 256 }", "{ timeout = \"3 s\" }", "{ read_at_most = 0 }", "{ echo = 1 }",
                            "{ speed = 3 }", "{ timeout = 5 }", "7"}) {
    auto changed = kGolden;
    const auto at = changed.find("{ unit");
    changed.replace(at, changed.find('\n', at) - at, wrong);
    EXPECT_FALSE(parse_safe_state(changed, "changed")) << wrong;
  }
}

TEST(SafeStateFile, RestoresEveryWrittenState) {
  auto written = safe_state();
  written.parameters = {{"channel", "2"}, {"type", "^VC \"600\"$"}};
  written.link_settings.after_read = std::chrono::milliseconds(40);
  written.word_order = {};
  written.switch_off = false;
  written.link = drivers::LinkKind::rtu_over_tcp;
  written.safe_set_point = {-12.0625};
  written.map_text = "";
  written.power = "event_1";
  written.identity = "Watlow F4T (part_number = F4T1A2EAA1B1AAA, serial_number = 111), ramp_action = off";
  written.link_settings = {.unit = 0, .timeout = std::chrono::microseconds(1500), .echo = true};
  const auto read = parse_safe_state(to_text(written), "text");
  ASSERT_TRUE(read) << text(read.error());
  EXPECT_EQ(*read, written);
}

TEST(SafeStateFile, RefusesTruncatedAndChangedFilesWithPosition) {
  const std::string& golden = kGolden;
  // The last line may lack its line break.
  for (std::size_t length = 0; length + 1 < golden.size(); ++length)
    EXPECT_FALSE(parse_safe_state(golden.substr(0, length), "cut")) << length;
  EXPECT_FALSE(parse_safe_state(golden + "x", "longer"));
  int lines = 0;
  for (auto at = golden.find(" = "); at < golden.find("map"); at = golden.find(" = ", at + 1), ++lines) {
    auto changed = golden;
    changed[at + 1] = ';';
    const auto read = parse_safe_state(changed, "changed");
    ASSERT_FALSE(read) << changed;
    EXPECT_EQ(read.error().kind, FaultKind::bad_file);
    EXPECT_TRUE(read.error().where.starts_with("changed:")) << read.error().where;
  }
  EXPECT_GE(lines, 8);
}

TEST(SafeStateFile, RefusesNumbersThatAreNotTemperatures) {
  for (const auto* number : {"nan", "inf", "-inf", "", "23,5", "true", "\"23.5\"", "1e999"}) {
    auto changed = kGolden;
    changed.replace(changed.find("23.5"), 4, number);
    EXPECT_FALSE(parse_safe_state(changed, "changed")) << number;
  }
}

TEST(SafeStateFile, IsForOwnerAndGroupAndRemovedAtEndOfRun) {
  const tests::TestFolder folder;
  auto written = safe_state();
  written.record = folder / "run.db";
  ASSERT_TRUE(write_safe_state(written));
  struct stat found {};
  ASSERT_EQ(::stat(safe_state_path(written.record).c_str(), &found), 0);
  EXPECT_EQ(found.st_mode & 0777, 0640u & ~S_IWOTH);
  const auto read = read_safe_state(safe_state_path(written.record));
  ASSERT_TRUE(read && *read);
  EXPECT_EQ(**read, written);
  remove_safe_state(written.record);
  const auto gone = read_safe_state(safe_state_path(written.record));
  ASSERT_TRUE(gone);
  EXPECT_FALSE(*gone);
  EXPECT_FALSE(std::filesystem::exists(safe_state_path(written.record) + ".part"));
}

/// The author of the file decides which process is killed, and the chamber's set point.
TEST(SafeStateFile, IsRefusedWhenOwnedByAnotherUserOrWritableByOthers) {
  const tests::TestFolder folder;
  auto written = safe_state();
  written.record = folder / "run.db";
  const auto path = safe_state_path(written.record);
  ASSERT_TRUE(write_safe_state(written));
  ASSERT_EQ(::chmod(path.c_str(), 0660), 0);
  EXPECT_NE(text(read_safe_state(path).error()).find("can be written by other users"), std::string::npos);
  ASSERT_EQ(::chmod(path.c_str(), 0640), 0);
  EXPECT_TRUE(read_safe_state(path));
  if (::geteuid() != 0) GTEST_SKIP() << "only root can make another user's file";
  ASSERT_EQ(::chown(path.c_str(), 65534, 65534), 0);
  EXPECT_NE(text(read_safe_state(path).error()).find("belongs to nobody (uid 65534)"), std::string::npos);
}

TEST(SafeStateFile, IsRefusedImmediatelyWhenNotRegularFile) {
  const tests::TestFolder folder;
  const auto path = folder / "run.db.safe-state";
  ASSERT_EQ(::mkfifo(path.c_str(), 0600), 0);
  EXPECT_FALSE(read_safe_state(path)) << "a FIFO without a writer is not waited for";
  std::filesystem::remove(path);
  std::ofstream(folder / "elsewhere") << to_text(safe_state());
  std::filesystem::create_symlink(folder / "elsewhere", path);
  EXPECT_FALSE(read_safe_state(path)) << "a link may lead anywhere";
}

TEST(SafeStateFile, IsRefusedWhenPathIsNotText) {
  const tests::TestFolder folder;
  auto written = safe_state();
  written.record = folder / "\xff.db";
  EXPECT_FALSE(write_safe_state(written));
  written.record = folder / "two\nlines\".db";
  ASSERT_TRUE(write_safe_state(written));
  const auto read = read_safe_state(safe_state_path(written.record));
  ASSERT_TRUE(read && *read);
  EXPECT_EQ(**read, written);
}

TEST(GiveUpOrder, IsReadOnceAndRemoved) {
  const tests::TestFolder folder;
  const auto record = folder / "run.db";
  EXPECT_EQ(read_give_up(record), "");
  ASSERT_TRUE(write_give_up(record, "ada (uid 1000): the map was wrong\nsecond line"));
  EXPECT_EQ(read_give_up(record).find("ada (uid 1000): the map was wrong"), 0u);
  EXPECT_EQ(read_give_up(record).find('\n'), std::string::npos);
  remove_give_up(record);
  EXPECT_EQ(read_give_up(record), "");
  remove_give_up(record);
}

TEST(GiveUpOrder, IsIgnoredWhenOthersMayWriteItOrWhenItIsLink) {
  const tests::TestFolder folder;
  const auto record = folder / "run.db";
  ASSERT_TRUE(write_give_up(record, "mallory: done"));
  ASSERT_EQ(::chmod(give_up_path(record).c_str(), 0666), 0);
  EXPECT_EQ(read_give_up(record), "");
  remove_give_up(record);
  std::ofstream(folder / "elsewhere") << "mallory: done\n";
  ASSERT_EQ(::symlink((folder / "elsewhere").c_str(), give_up_path(record).c_str()), 0);
  EXPECT_EQ(read_give_up(record), "");
}

TEST(GiveUpOrder, EndsGuardAndLeavesTrace) {
  const tests::TestFolder folder;
  auto state = safe_state();
  state.record = folder / "run.db";
  ASSERT_TRUE(write_safe_state(state));
  TraceWriter trail(state, "the program that drove it hung");
  (void)trail.record({.reached = {}, .details = "mode NOT shown: holding"});
  EXPECT_FALSE(trail.find_end_reason());
  ASSERT_TRUE(write_give_up(state.record, "ada (uid 1000): the map was wrong"));
  EXPECT_EQ(trail.find_end_reason(), "ordered to give up by ada (uid 1000): the map was wrong");
  trail.note_given_up(trail.give_up_order());
  ASSERT_TRUE(trail.settle(std::chrono::seconds(30)));
  EXPECT_EQ(read_give_up(state.record), "");
  EXPECT_FALSE(read_safe_state(safe_state_path(state.record)).value());
  const auto left = read_trace(state.record).value().value();
  EXPECT_FALSE(left.confirmed);
  EXPECT_EQ(left.given_up, "ada (uid 1000): the map was wrong");
  const auto words = describe(left);
  EXPECT_EQ(words.find("GIVEN UP by the guard at "), 0u) << words;
  EXPECT_NE(words.find("NOT confirmed"), std::string::npos) << words;
  EXPECT_NE(words.find("mode NOT shown: holding"), std::string::npos) << words;
}

TEST(MadeSafeTrace, NamesProgramThatActed) {
  MadeSafe trace{.at = std::chrono::seconds(1767225600),
                 .because = "the program that drove it had ended",
                 .set_point = {23},
                 .confirmed = true,
                 .details = "set point read back",
                 .by = "gyrotherm-make-safe"};
  EXPECT_EQ(describe(trace).find("made safe by gyrotherm-make-safe at "), 0u) << describe(trace);
  EXPECT_EQ(parse_made_safe(to_text(trace), "x").value(), trace);
}

}  // namespace
}  // namespace gyrotherm::watchdog
