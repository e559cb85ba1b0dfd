// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/apps/gyrotherm/program.hpp"

namespace gyrotherm::app {
namespace {

TEST(Devices, ListsDevicesWithLineAndAccess) {
  const auto ran = gyrotherm_with("devices --json");
  ASSERT_EQ(ran.exit_code, 0) << ran.err;
  const auto devices = nlohmann::json::parse(ran.out).at("devices");
  for (const auto& device : devices) {
    EXPECT_TRUE(device.at("kind") == "serial" || device.at("kind") == "hid");
    EXPECT_TRUE(device.at("device").get<std::string>().starts_with("/dev/"));
    EXPECT_TRUE(device.at("allowed").is_boolean());
    if (!device.at("allowed").get<bool>() && !device.at("line").get<std::string>().empty()) {
      EXPECT_NE(device.at("fix").get<std::string>().find("sudo"), std::string::npos);
    }
  }
  const auto words = gyrotherm_with("devices");
  EXPECT_EQ(words.exit_code, 0);
  EXPECT_FALSE(words.out.empty());
}

}  // namespace
}  // namespace gyrotherm::app
