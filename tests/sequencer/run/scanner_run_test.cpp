// SPDX-License-Identifier: Apache-2.0
// Runs with a thermometer scanner that a file describes.
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "acquisition/record/record.hpp"
#include "sequencer/run/resume.hpp"
#include "tests/support/dry_run.hpp"

namespace gyrotherm::run {
namespace {

const std::string kTenSecondsProfile = GYROTHERM_SOURCE_DIR "/tests/profiles/ten-seconds.toml";

/// Returns the virtual rig whose first thermometer is the described scanner.
rig::RigFile rig_with_scanner(const std::string& description) {
  const auto path = GYROTHERM_SOURCE_DIR "/profiles/rigs/virtual.toml";
  auto text_of_rig = read_text_file(path).value();
  const std::string driver = "driver = \"lakeshore_218\"";
  text_of_rig.replace(text_of_rig.find(driver), driver.size(),
                      "driver = \"text\"\ndescription = \"../thermometers/" + description + ".toml\"");
  auto rig = rig::parse_rig(text_of_rig, path);
  EXPECT_TRUE(rig) << text(rig.error());
  return std::move(*rig);
}

TEST(ScannerRun, RecordsTheReadingsOfAScanner) {
  tests::DryRun reference(kTenSecondsProfile);
  EXPECT_EQ(reference.run(), RunOutcome::complete);
  const auto expected = record::read_record(reference.path());
  ASSERT_TRUE(expected) << text(expected.error());
  std::filesystem::remove(reference.path());
  for (const auto* description : {"keysight_34970a", "keithley_daq6510", "lakeshore_224"}) {
    tests::DryRun dry_run(kTenSecondsProfile);
    dry_run.file() = rig_with_scanner(description);
    EXPECT_EQ(dry_run.run(), RunOutcome::complete) << description;
    const auto record = record::read_record(dry_run.path());
    ASSERT_TRUE(record) << text(record.error());
    EXPECT_EQ(record->info.thermometer_texts, collect_thermometer_texts(dry_run.file()));
    EXPECT_EQ(record->info.thermometer_texts.size(), 1u);
    ASSERT_EQ(record->thermometers_c.size(), expected->thermometers_c.size());
    for (std::size_t channel = 0; channel < record->thermometers_c.size(); ++channel) {
      const auto& read = record->thermometers_c[channel];
      ASSERT_EQ(read.size(), expected->thermometers_c[channel].size());
      for (std::size_t i = 0; i < read.size(); ++i)
        EXPECT_NEAR(read[i], expected->thermometers_c[channel][i], 0.0011) << description;
    }
    std::filesystem::remove(dry_run.path());
  }
}

TEST(ScannerRun, ResumesFromItsRecordOnly) {
  tests::DryRun dry_run(kTenSecondsProfile);
  dry_run.file() = rig_with_scanner("lakeshore_224");
  EXPECT_EQ(dry_run.run(4), RunOutcome::going_on);
  const auto record = record::read_record(dry_run.path());
  ASSERT_TRUE(record) << text(record.error());
  EXPECT_EQ(record->info.thermometers.front().instrument, "Lake Shore 224, thermometer 1 at virtual, input 1");
  const auto on = plan_continuation(*record, dry_run.path(), kSecond, 1);
  ASSERT_TRUE(on) << text(on.error());
  EXPECT_EQ(collect_thermometer_texts(on->rig), collect_thermometer_texts(dry_run.file()));
  auto rig = rig::Rig::assemble(on->rig, on->start);
  ASSERT_TRUE(rig) << text(rig.error());
  ASSERT_TRUE((*rig)->prepare(Celsius{20}));
  (*rig)->let_pass(1);
  const auto sample = (*rig)->io().read(5, (*rig)->clock());
  ASSERT_EQ(sample.thermometers.size(), record->thermometers_c.size());
  for (const auto& thermometer : sample.thermometers) EXPECT_TRUE(thermometer.value) << text(thermometer.value.error());
}

}  // namespace
}  // namespace gyrotherm::run
