// SPDX-License-Identifier: Apache-2.0
#include "sequencer/rig/unit_serials.hpp"

#include <gtest/gtest.h>

#include <map>
#include <string>
#include <vector>

namespace gyrotherm::rig {
namespace {

/// Returns a rig whose units have these serial numbers.
RigFile make_rig(const std::vector<std::pair<std::string, std::string>>& units) {
  RigFile rig;
  rig.file = "lot.toml";
  for (const auto& [name, serial] : units) {
    UnitSettings unit;
    unit.info.name = name;
    unit.info.serial_number = serial;
    rig.units.push_back(unit);
  }
  return rig;
}

/// Identifies the units in order. Returns the first error, or an empty text.
std::string identify(RigFile& rig, const std::vector<std::string>& texts) {
  for (const auto& one : texts) {
    const auto serial = parse_unit_serial(one, rig);
    if (!serial) return serial.error().what;
    if (const auto taken = identify_unit(rig, *serial); !taken) return taken.error().what;
  }
  return {};
}

TEST(UnitSerial, NamesItsPosition) {
  const auto rig = make_rig({{"u1", ""}, {"u2", ""}});
  EXPECT_EQ(parse_unit_serial("u1=0042", rig).value(), (UnitSerial{"u1", "0042"}));
  EXPECT_EQ(parse_unit_serial(" u2 = 00 43\r", rig).value(), (UnitSerial{"u2", "00 43"}));
  EXPECT_EQ(parse_unit_serial("u2=", rig).value(), (UnitSerial{"u2", ""})) << "an empty position";
  EXPECT_EQ(parse_unit_serial("u1=a=b", rig).value(), (UnitSerial{"u1", "a=b"}));
  for (const auto* other : {"0042", "u3=0042", "=0042", ""}) {
    const auto refused = parse_unit_serial(other, rig);
    ASSERT_FALSE(refused) << other;
    EXPECT_EQ(refused.error().kind, FaultKind::usage);
    EXPECT_NE(refused.error().what.find("expected POSITION=SERIAL with one of u1, u2"), std::string::npos);
  }
  EXPECT_EQ(parse_unit_serial("u1=0\x1d", rig).error().what.substr(0, 21), "u1: the serial number");
}

TEST(UnitSerial, NeedsNoPositionIfRigHasOneUnit) {
  const auto rig = make_rig({{"gyro", ""}});
  EXPECT_EQ(parse_unit_serial("0042", rig).value(), (UnitSerial{"gyro", "0042"}));
  EXPECT_EQ(parse_unit_serial("gyro=0042", rig).value(), (UnitSerial{"gyro", "0042"}));
  EXPECT_EQ(parse_unit_serial("gyro=A=7", rig).value(), (UnitSerial{"gyro", "A=7"}));
  for (const auto* other : {"A=7", "gyor=3", "gyor=", "Gyro =3", "=0042"}) {
    const auto refused = parse_unit_serial(other, rig);
    ASSERT_FALSE(refused) << other;
    EXPECT_EQ(refused.error().kind, FaultKind::usage);
  }
  EXPECT_NE(parse_unit_serial("gyor=3", rig).error().what.find("did you mean gyro=SERIAL?"), std::string::npos);
  EXPECT_EQ(parse_unit_serial("A=7", rig).error().what.find("did you mean"), std::string::npos);
  EXPECT_FALSE(parse_unit_serial("", rig));
}

TEST(UnitSerial, CompletesRig) {
  auto rig = make_rig({{"u1", ""}, {"u2", "0043"}, {"u3", ""}, {"u4", ""}});
  EXPECT_EQ(find_unidentified(rig), (std::vector<std::string>{"u1", "u3", "u4"}));
  EXPECT_EQ(identify(rig, {"u1=0042", "u2=0043", "u4="}), "") << "the number of the rig file may be repeated";
  EXPECT_EQ(find_unidentified(rig), std::vector<std::string>{"u3"});
  EXPECT_EQ(rig.units[0].info.serial_number, "0042");
  EXPECT_EQ(rig.identification.serial_numbers, (std::map<std::string, std::string>{{"u1", "0042"}}));
  EXPECT_EQ(rig.identification.unused, std::vector<std::string>{"u4"});
  ASSERT_EQ(list_units_in_use(rig).size(), 3u);
  rig.identification.order_number = "2026-17";
  EXPECT_EQ(describe_identification(rig), "u1 0042, u2 0043, u3 without serial number; u4 not used; order 2026-17");
}

TEST(UnitSerial, IsRefusedWithBothValues) {
  const auto refused = [](const std::vector<std::string>& texts) {
    auto rig = make_rig({{"u1", ""}, {"u2", "0043"}, {"u3", ""}});
    return identify(rig, texts);
  };
  EXPECT_EQ(refused({"u2=0044"}), "gives u2 the serial number 0044, but lot.toml gives it 0043");
  EXPECT_EQ(refused({"u1=0042", "u1=0045"}), "gives u1 the serial number 0045, but an earlier value gives it 0042");
  EXPECT_EQ(refused({"u1=0043"}), "the serial number 0043 is given to u1 and to u2");
  EXPECT_EQ(refused({"u1=7", "u3=7"}), "the serial number 7 is given to u1 and to u3");
  EXPECT_EQ(refused({"u1=42", "u3=042"}), "") << "leading zeros distinguish numbers";
  EXPECT_EQ(refused({"u2="}), "u2 is given as empty, but its serial number is 0043");
  EXPECT_EQ(refused({"u1=", "u1=0042"}), "u1 is given as empty and as 0042");
  auto rig = make_rig({{"u1", ""}, {"u2", ""}});
  EXPECT_EQ(identify(rig, {"u1=", "u1=", "u2="}), "u2 is given as empty, but a run needs at least one unit");
}

TEST(UnitSerial, IsUnchangedAfterRefusal) {
  auto rig = make_rig({{"u1", ""}, {"u2", "0043"}});
  EXPECT_NE(identify(rig, {"u1=0043"}), "");
  EXPECT_EQ(find_unidentified(rig), std::vector<std::string>{"u1"}) << "a prompt asks again";
  EXPECT_EQ(identify(rig, {"u1=0042"}), "");
}

TEST(UnitSerial, OfRecordIsRestoredAndCompared) {
  record::RunInfo info;
  info.order_number = "2026-17";
  info.units = {{.name = "u1", .serial_number = "0042", .model = "RLG-1"}, {.name = "u2"}, {.name = "u3"}};
  info.unused_units = {"u2"};
  auto rig = make_rig({{"u1", ""}, {"u2", ""}, {"u3", ""}});
  restore_identification(rig, info);
  EXPECT_EQ(rig.units[0].info.serial_number, "0042");
  EXPECT_EQ(rig.units[0].info.model, "RLG-1");
  EXPECT_EQ(describe_identification(rig), "u1 0042, u3 without serial number; u2 not used; order 2026-17");
  const auto compared = [&](const UnitSerial& serial) {
    const auto same = compare_with_record(serial, info, "lot.db");
    return same ? "" : same.error().what;
  };
  EXPECT_EQ(compared({"u1", "0042"}), "");
  EXPECT_EQ(compared({"u2", ""}), "");
  EXPECT_EQ(compared({"u1", "0044"}),
            "gives u1 the serial number 0044, but lot.db contains 0042; a run keeps the units that it began with");
  EXPECT_NE(compared({"u2", "0044"}).find("lot.db contains an empty position"), std::string::npos);
  EXPECT_NE(compared({"u3", "0044"}).find("lot.db contains no serial number"), std::string::npos);
  EXPECT_NE(compared({"u1", ""}).find("gives u1 as empty, but lot.db contains 0042"), std::string::npos);
}

}  // namespace
}  // namespace gyrotherm::rig
