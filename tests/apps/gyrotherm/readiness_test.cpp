// SPDX-License-Identifier: Apache-2.0
/// The go/no-go block before a run.
#include "apps/gyrotherm/run/readiness.hpp"

#include <gtest/gtest.h>

#include <filesystem>

namespace gyrotherm::app {
namespace {

rig::RigFile shipped(const std::string& name) {
  auto rig = rig::read_rig(std::string(GYROTHERM_SOURCE_DIR) + "/profiles/rigs/" + name + ".toml");
  EXPECT_TRUE(rig) << text(rig.error());
  return *rig;
}

const Finding* find(const std::vector<Finding>& findings, const std::string& what) {
  const auto found = std::ranges::find(findings, what, &Finding::what);
  return found == findings.end() ? nullptr : &*found;
}

std::vector<Finding> readiness(const rig::RigFile& rig) { return check_readiness(rig, "run.db", kVirtualEpoch); }

TEST(Readiness, WarnsWhenEarthRateOfAxisIsUnknown) {
  for (const auto* name : {"virtual", "virtual-lot", "virtual-hard", "example-f4t-lakeshore-kvh"}) {
    auto rig = shipped(name);
    const auto known = check_bias_zero(rig);
    EXPECT_EQ(known.state, FindingState::ok) << name << ": " << known.found;
    auto& unit = rig.units.back().info;
    unit.axes.back().earth_rate.reset();
    const auto missing = check_bias_zero(rig);
    EXPECT_EQ(missing.state, FindingState::warning) << name;
    EXPECT_NE(missing.found.find(axis_label(unit, unit.axes.size() - 1)), std::string::npos) << missing.found;
    EXPECT_NE(missing.found.find("the mean of the first hold becomes the bias reference"), std::string::npos);
    EXPECT_NE(missing.fix.find("latitude"), std::string::npos);
    EXPECT_EQ(find(readiness(rig), "bias reference")->state, FindingState::warning) << name;
  }
}

TEST(Readiness, ChecksLimiterDiskAndGuardOfRealRig) {
  auto rig = shipped("example-f4t-lakeshore-kvh");
  const auto findings = readiness(rig);
  for (const auto* what : {"bias reference", "calibrations", "limiter", "disk", "guard"})
    EXPECT_NE(find(findings, what), nullptr) << what;
  rig.limiter.reset();
  EXPECT_EQ(find(readiness(rig), "limiter")->state, FindingState::warning);
  rig.limiter = rig::Limiter{.protection_class = "3.3", .lowest = Celsius{-50}, .highest = Celsius{75}};
  EXPECT_EQ(find(readiness(rig), "limiter")->state, FindingState::ok);
  EXPECT_EQ(find(readiness(rig), "limiter")->found,
            "class 3.3, below -50 °C, above 75 °C; verify these settings on the chamber");
}

TEST(Readiness, WarnsAboutOverdueCertificates) {
  const auto rig = shipped("example-f4t-lakeshore-kvh");
  const auto much_later = kVirtualEpoch + std::chrono::hours(24 * 365 * 30);
  EXPECT_EQ(find(check_readiness(rig, "run.db", much_later), "calibrations")->state, FindingState::warning);
  EXPECT_EQ(find(check_readiness(rig, "run.db", Duration{}), "calibrations")->state, FindingState::ok);
}

TEST(Readiness, ReportsMissingDisk) {
  const auto findings = check_readiness(shipped("virtual"), "/no/such/folder/run.db", kVirtualEpoch);
  EXPECT_EQ(find(findings, "disk")->state, FindingState::fault);
}

TEST(Readiness, SkipsLimiterAndGuardOfVirtualRig) {
  const auto findings = readiness(shipped("virtual"));
  EXPECT_EQ(find(findings, "limiter"), nullptr);
  EXPECT_EQ(find(findings, "guard"), nullptr);
}

}  // namespace
}  // namespace gyrotherm::app
