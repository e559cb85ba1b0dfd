// SPDX-License-Identifier: Apache-2.0
/// Virtual rig, profile and record in a temporary folder.
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <functional>
#include <string>

#include "acquisition/record/record.hpp"
#include "acquisition/record/store.hpp"
#include "core/file.hpp"
#include "sequencer/rig/rig.hpp"
#include "sequencer/run/resume.hpp"
#include "sequencer/run/run_controller.hpp"
#include "tests/support/run_harness.hpp"

namespace gyrotherm::tests {

class DryRun {
 public:
  explicit DryRun(const std::string& profile_path, std::uint64_t seed = 0, const std::string& rig = "virtual")
      : seed_(seed) {
    const auto name = ::testing::UnitTest::GetInstance()->current_test_info()->name();
    folder_ =
        std::filesystem::temp_directory_path() / ("gyrotherm-" + std::string(name) + "-" + std::to_string(::getpid()));
    std::filesystem::create_directories(folder_);
    auto read = rig::read_rig(GYROTHERM_SOURCE_DIR "/profiles/rigs/" + rig + ".toml");
    EXPECT_TRUE(read) << text(read.error());
    file_ = std::move(*read);
    const auto written = read_text_file(profile_path);
    EXPECT_TRUE(written);
    auto parsed = profile::parse_profile(*written, profile_path);
    EXPECT_TRUE(parsed) << text(parsed.error());
    profile_ = std::move(*parsed);
  }
  ~DryRun() { std::filesystem::remove_all(folder_); }
  DryRun(const DryRun&) = delete;
  DryRun& operator=(const DryRun&) = delete;

  [[nodiscard]] std::string path() const { return (folder_ / "run.db").string(); }
  [[nodiscard]] const profile::Profile& profile() const { return profile_; }
  rig::RigFile& file() { return file_; }

  /// Age of the virtual gyro.
  std::uint64_t days_later = 0;

  /// Returns the description of a record of this profile on this rig.
  [[nodiscard]] record::RunInfo info() const { return run::run_info("", profile_, file_, seed_, {}, days_later); }

  /// Runs until the end of the profile, for at most `seconds`. Returns the outcome of the last tick.
  run::RunOutcome run(std::int64_t seconds = 1'000'000) {
    return run({.gyro = seed_, .run = 0, .days_later = days_later}, nullptr,
               [&](RunHarness& harness, rig::Rig&) { harness.seconds(seconds); });
  }
  /// Starts a run and calls `steps`, which advances it. First loads `program` into the chamber controller, unless it is
  /// null. Finishes the record if the run is complete.
  run::RunOutcome run(simulator::LaboratorySeed seed, const drivers::ChamberProgram* program,
                      const std::function<void(RunHarness&, rig::Rig&)>& steps) {
    auto rig = rig::Rig::assemble(
        file_,
        {.seed = seed, .elapsed = {}, .replay = {}, .first_set_point = demanded_set_point(profile_, begin(profile_))});
    EXPECT_TRUE(rig) << text(rig.error());
    const auto prepared = (*rig)->prepare(demanded_set_point(profile_, begin(profile_)), program);
    EXPECT_TRUE(prepared) << text(prepared.error());
    auto store = record::Store::create(path(), info());
    EXPECT_TRUE(store) << text(store.error());
    RunHarness harness(profile_, **rig, **store);
    if (program) harness.run_controller().hand_over_to_controller();
    steps(harness, **rig);
    EXPECT_TRUE((*store)->sync());
    if (harness.outcome() == run::RunOutcome::complete) {
      EXPECT_TRUE((*store)->finish());
    }
    return harness.outcome();
  }

 private:
  std::uint64_t seed_;
  std::filesystem::path folder_;
  rig::RigFile file_;
  profile::Profile profile_;
};

}  // namespace gyrotherm::tests
