// SPDX-License-Identifier: Apache-2.0
#include "tests/sequencer/faults/breakable_run.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "acquisition/record/record_files.hpp"
#include "core/file.hpp"
#include "sequencer/run/chamber_lead.hpp"
#include "tests/sequencer/faults/simulated_run.hpp"

namespace gyrotherm::faults {
namespace {

constexpr Duration kLongestWrite = std::chrono::seconds(20);

std::string read(const std::string& path) {
  auto text = read_text_file(std::string(GYROTHERM_SOURCE_DIR "/") + path);
  EXPECT_TRUE(text) << path;
  return text.value_or("");
}

template <class T>
T expected(Result<T> result) {
  EXPECT_TRUE(result) << (result ? "" : text(result.error()));
  return std::move(result).value();
}

const std::string kRig = "profiles/rigs/virtual-reference.toml";

rig::RigFile rig_file(const Setting& setting) {
  auto file = expected(rig::parse_rig(read(kRig), GYROTHERM_SOURCE_DIR "/" + kRig,
                                      {.chamber_map = read(setting.chamber_map), .gyro_model = {}}));
  // The air is watched in safe_sequence_test.cpp; this test observes the cause.
  file.safe_observe = {};
  if (setting.rig) setting.rig(file);
  return file;
}

profile::Profile read_profile_of_setting(const Setting& setting) {
  return expected(profile::parse_profile(
      "schema = \"gyrotherm-profile/1\"\nname = \"demonstration\"\n" + setting.segments, "profile"));
}

}  // namespace

BreakableRun::BreakableRun(const Setting& setting)
    : file_(rig_file(setting)), profile_(read_profile_of_setting(setting)) {
  const auto laboratory = expected(simulator::parse_laboratory(file_.text, file_.file));
  clock_.restart_at(-kSecond);
  plant_.emplace(file_, laboratory, clock_, 1);
  wires_.emplace(*plant_, clock_);
  rig_ = rig::Rig::assemble(file_, *wires_);
  const auto program =
      setting.by_the_controller ? run::make_chamber_program(profile_) : Result<drivers::ChamberProgram>();
  const auto prepared =
      rig_->prepare(demanded_set_point(profile_, begin(profile_)), setting.by_the_controller ? &*program : nullptr);
  EXPECT_TRUE(prepared) << text(prepared.error());
  path_ = record::kInMemory;
  if (setting.rows_on_disk > 0) {
    disk_.emplace();
    path_ = folder_.emplace() / "run.db";
  }
  store_ = expected(record::Store::create(
      path_, make_run_info(profile_, file_),
      {.background = disk_.has_value(), .most_rows = setting.rows_on_disk, .retry = std::chrono::milliseconds(1)}));
  harness_.emplace(profile_, *rig_, *store_);
  harness_->after_tick = [this] { make_durable(); };
  if (setting.by_the_controller) harness_->run_controller().hand_over_to_controller();
}

BreakableRun::~BreakableRun() = default;

void BreakableRun::fill_disk() {
  disk_->fail(1, true, tests::FailingVfs::Kind::full);
  disk_is_full_ = true;
}

void BreakableRun::free_disk_space() {
  disk_->heal();
  disk_is_full_ = false;
  EXPECT_TRUE(store_->settle(kLongestWrite));
}

void BreakableRun::move_record() {
  std::filesystem::rename(path_, path_ + ".away");
  path_ = record::part_path(path_, 2);
}

/// Waits until the store has written everything, because a working disk keeps up with virtual time. Does not wait for a
/// full disk.
void BreakableRun::make_durable() {
  EXPECT_TRUE(store_->sync());
  if (disk_ && !disk_is_full_) {
    EXPECT_TRUE(store_->settle(kLongestWrite));
  }
}

record::Record BreakableRun::record() {
  if (!disk_) return expected(store_->read_back());
  harness_.reset();
  store_.reset();
  disk_.reset();
  return expected(record::read_record(path_));
}

std::vector<AlarmRecorded> BreakableRun::alarms_in(const record::Record& record) {
  std::vector<AlarmRecorded> alarms;
  for (const auto& [slot, event] : record.events) {
    const bool is_raised = event.kind == EventKind::fault || event.kind == EventKind::interlock;
    const bool is_root = event.about.interlock == run::kHostLate || event.about.interlock == run::kLineLost;
    if (is_raised && !is_root && !event.about.interlock.empty())
      alarms.push_back({event.about.interlock, event.about.reaction});
  }
  return alarms;
}

}  // namespace gyrotherm::faults
