// SPDX-License-Identifier: Apache-2.0
#include "sequencer/run/rig_changes.hpp"

#include <gtest/gtest.h>

namespace gyrotherm::run {
namespace {

using Texts = std::vector<std::string>;

tl::unexpected<Fault> silence(const char* where) { return failure(FaultKind::timeout, where, "no reply"); }

/// A chamber, a thermometer "A" and a gyro. All answer.
class Changes : public testing::Test {
 protected:
  Changes() {
    rig_.limits.channels = {"A"};
    rig_.units = {rig::UnitSettings{}};
    rig_.units[0].info.name = record::kOnlyUnit;
    sample_.chamber.value = ChamberState{{20}, {20}};
    sample_.thermometers = {{Celsius{20}, {}}};
    sample_.units.resize(1);
    sample_.units[0].count.value = GyroCount{{1}, kSecond};
  }

  Texts compare(bool dropped = false, bool units_may_be_off = false) {
    Texts texts;
    for (const auto& change : changes_.compare_readings(sample_, {dropped}, units_may_be_off))
      texts.push_back(std::string(change.kind == EventKind::fault ? "fault " : "recovered ") + change.text);
    return texts;
  }

  rig::RigFile rig_;
  Sample sample_;
  RigChanges changes_{rig_};
};

TEST_F(Changes, ReportFaultOnceAndItsEnd) {
  EXPECT_EQ(compare(), Texts{});
  sample_.thermometers[0].value = silence("scanner");
  EXPECT_EQ(compare(), Texts{"fault thermometer A: scanner: no reply"});
  EXPECT_EQ(compare(), Texts{});
  EXPECT_EQ(changes_.faulty_readings(), 1);
  sample_.thermometers[0].value = Celsius{20};
  EXPECT_EQ(compare(), Texts{"recovered thermometer A answers again"});
  EXPECT_EQ(changes_.faulty_readings(), 0);
}

TEST_F(Changes, IgnoreUnitThatIsDroppedOrMayBeOff) {
  sample_.units[0].count.value = silence("gyro");
  constexpr bool kDropped = true, kMayBeOff = true;
  EXPECT_EQ(compare(kDropped), Texts{});
  EXPECT_EQ(changes_.faulty_readings(), 1);
  EXPECT_EQ(compare(!kDropped, kMayBeOff), Texts{});
  EXPECT_EQ(changes_.faulty_readings(), 0) << "the profile has switched it off";
  EXPECT_EQ(changes_.readings_while_off(), 1);
  EXPECT_EQ(compare(), Texts{"fault gyro: no reply"});
  EXPECT_EQ(changes_.faulty_readings(), 1);
  EXPECT_EQ(changes_.readings_while_off(), 0);
}

TEST_F(Changes, ReportAlarmsOfChamberWhenTheyChange) {
  sample_.chamber.value->alarms = {"door", "water"};
  EXPECT_EQ(compare(), Texts{"fault chamber alarm: door; water"});
  EXPECT_EQ(compare(), Texts{});
  sample_.chamber.value->alarms.clear();
  EXPECT_EQ(compare(), Texts{"recovered chamber: all alarms have cleared"});
}

}  // namespace
}  // namespace gyrotherm::run
