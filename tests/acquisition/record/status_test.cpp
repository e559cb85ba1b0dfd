#include "acquisition/record/status.hpp"

#include <gtest/gtest.h>

#include <fstream>

#include "tests/acquisition/record/runs.hpp"

namespace gyrotherm {
namespace {

TEST(Status, GoesThroughJsonUnchanged) {
  RunStatus status;
  status.path = "a \"quoted\" run.db";
  status.pid = 42;
  status.being_written = true;
  status.slot = 7;
  status.acknowledged = 7;
  status.segment = "hold at −40 °C";
  status.segment_index = 3;
  status.segment_count = 9;
  status.phase = Phase::overdue;
  status.set_point = Celsius{-40};
  status.thermometers = {{"B", Celsius{1.5}}, {"A", std::nullopt}};
  status.faults = 2;
  status.frames = FrameCount{.seen = 1000, .lost = 3, .bad = 1};
  const auto back = parse_status(to_json(status), "here");
  ASSERT_TRUE(back) << text(back.error());
  EXPECT_EQ(to_json(*back), to_json(status));
  EXPECT_EQ(back->thermometers[0].channel, "B") << "the order of the rig";
  EXPECT_FALSE(back->chamber_air);
  EXPECT_EQ(back->phase, Phase::overdue);
  EXPECT_EQ(back->frames, status.frames);
}

TEST(Status, RefusesWhatItDidNotWrite) {
  for (const char* text :
       {"", "{", "[]", "{}", R"({"schema": 1})", R"({"schema": "gyrotherm-status/1", "pid": "x"})"}) {
    const auto status = parse_status(text, "here");
    ASSERT_FALSE(status) << text;
    EXPECT_EQ(status.error().kind, FaultKind::bad_file);
    EXPECT_EQ(status.error().where, "here");
  }
}

TEST(Status, FollowsEachSync) {
  const Folder folder;
  const auto store = store_with(folder / "run.db", 3);
  const auto told = [&] {
    std::ifstream file(status_path(folder / "run.db"));
    return parse_status(std::string(std::istreambuf_iterator<char>(file), {}), "status").value();
  };
  EXPECT_EQ(told().acknowledged, 2);
  Sample sample = sample_at(3);
  sample.thermometers[1].value = failure(FaultKind::timeout, "shell-1.b", "silent");
  ASSERT_TRUE(store->append(sample, {}));
  EXPECT_EQ(told().acknowledged, 2) << "not synced yet";
  ASSERT_TRUE(store->sync());
  const RunStatus status = told();
  EXPECT_EQ(status.acknowledged, 3);
  EXPECT_EQ(status.slot, 3);
  EXPECT_EQ(status.pid, ::getpid());
  EXPECT_TRUE(status.being_written && status.simulated && !status.finished);
  EXPECT_EQ(status.segment, "hold");
  EXPECT_EQ(status.segment_index, 1);
  EXPECT_EQ(status.segment_count, 2);
  EXPECT_EQ(status.phase, Phase::waiting_for_soak);
  EXPECT_EQ(status.set_point, Celsius{22.5});
  EXPECT_EQ(status.thermometers[0].reading, sample.thermometers[0].value.value());
  EXPECT_FALSE(status.thermometers[1].reading);
  EXPECT_EQ(status.faults, 1);
}

TEST(Status, OfAFinishedRunComesFromTheRecord) {
  const Folder folder;
  auto store = store_with(folder / "run.db", 4);
  ASSERT_TRUE(store->finish());
  store.reset();
  std::filesystem::remove(status_path(folder / "run.db"));
  const auto status = read_status(folder / "run.db");
  ASSERT_TRUE(status) << text(status.error());
  EXPECT_TRUE(status->finished && !status->being_written);
  EXPECT_EQ(status->slot, 3);
  EXPECT_EQ(status->acknowledged, 3);
  EXPECT_EQ(status->segment, "hold");
  EXPECT_EQ(status->thermometers[1].reading, Celsius{-0.1});
  EXPECT_EQ(status->chamber_air, sample_at(3).chamber.value->air);
}

TEST(Status, AddsUpTheGyrosFramesOverEveryProgramThatRecordedThem) {
  const Folder folder;
  auto store = store_with(folder / "run.db", 2);
  Sample sample = sample_at(2);
  sample.gyro_frames = {.seen = 3000, .lost = 2, .bad = 1};
  ASSERT_TRUE(store->append(sample, {}) && store->sync());
  store.reset();
  store = Store::reopen(folder / "run.db").value();
  sample = sample_at(3);
  sample.gyro_frames = {.seen = 1000, .lost = 5, .bad = 0};
  ASSERT_TRUE(store->append(sample, {}) && store->sync());
  ASSERT_TRUE(store->finish());
  store.reset();
  const FrameCount all{.seen = 4000, .lost = 7, .bad = 1};
  EXPECT_EQ(read_status(folder / "run.db")->frames, all);
}

TEST(Status, FileOfAFinishedRunSaysSo) {
  const Folder folder;
  const auto store = store_with(folder / "run.db", 1);
  ASSERT_TRUE(store->finish());
  std::ifstream file(status_path(folder / "run.db"));
  const auto status = parse_status(std::string(std::istreambuf_iterator<char>(file), {}), "status").value();
  EXPECT_TRUE(status.finished && !status.being_written);
}

TEST(Status, OfNoRecordIsABadFile) {
  const Folder folder;
  EXPECT_EQ(read_status(folder / "missing").error().kind, FaultKind::bad_file);
}

}  // namespace
}  // namespace gyrotherm
