// SPDX-License-Identifier: Apache-2.0
/// The virtual instruments with third-party clients.
#include <gtest/gtest.h>

#include <csignal>
#include <regex>

#include "tests/apps/gyrotherm/program.hpp"
#include "tests/apps/gyrotherm/real_rig.hpp"

namespace gyrotherm::app {
namespace {

TEST(Simulate, ServesMbpoll) {
  if (!installed("mbpoll")) GTEST_SKIP() << "mbpoll is not installed";
  const Folder folder;
  Background simulate({"simulate", "--rig", "profiles/rigs/virtual.toml"}, folder / "log");
  ASSERT_TRUE(simulate.wait_for("gyro", 60)) << simulate.output();
  const auto port = find_port("chamber", simulate.output());
  const auto mbpoll = "mbpoll -m tcp -a 1 -0 -1 -q -B -t 4:float -p " + port;
  const auto air = shell(mbpoll +
                         " -r $(sed -n '/name = \"air_temperature\"/,/^$/s/^address = //p' "
                         "profiles/chambers/virtual.toml) -c 1 127.0.0.1");
  EXPECT_EQ(air.exit_code, 0) << air.out << air.err;
  EXPECT_TRUE(std::regex_search(air.out, std::regex(R"(\]:\s+(19|20))"))) << air.out;
  const std::string set_point =
      "$(sed -n '/name = \"set_point\"/,/^$/s/^address = //p' profiles/chambers/virtual.toml)";
  EXPECT_EQ(shell(mbpoll + " -r " + set_point + " 127.0.0.1 -- -12.5").exit_code, 0);
  const auto back = shell(mbpoll + " -r " + set_point + " -c 1 127.0.0.1");
  EXPECT_NE(back.out.find("-12.5"), std::string::npos) << back.out;
  simulate.signal(SIGTERM);
  EXPECT_EQ(simulate.wait(), 0);
}

TEST(Simulate, ServesPymodbus) {
  if (shell("/usr/bin/python3 -c 'import pymodbus.client'").exit_code != 0)
    GTEST_SKIP() << "python3-pymodbus is not installed";
  const Folder folder;
  Background simulate({"simulate", "--rig", "profiles/rigs/virtual.toml", "--pace", "x20"}, folder / "log");
  ASSERT_TRUE(simulate.wait_for("gyro", 60)) << simulate.output();
  const auto ran = shell("/usr/bin/python3 tests/apps/gyrotherm/pymodbus_client.py " +
                         find_port("chamber", simulate.output()) + " profiles/chambers/virtual.toml");
  EXPECT_EQ(ran.exit_code, 0) << ran.out << ran.err;
}

TEST(Simulate, ServesRealRigInRealTime) {
  const Folder folder;
  Background simulate({"simulate", "--rig", "profiles/rigs/virtual.toml"}, folder / "log");
  ASSERT_TRUE(simulate.wait_for("gyro", 60)) << simulate.output();
  const auto output = simulate.output();
  const auto rig =
      shell("/usr/bin/python3 tests/apps/gyrotherm/real_rig.py profiles/rigs/virtual.toml " +
            find_port("chamber", output) + " " + find_port("thermometer 1", output) + " " +
            find_port("thermometer 2", output) + " " + find_port("gyro", output) + " > " + (folder / "rig.toml"));
  ASSERT_EQ(rig.exit_code, 0) << rig.err;
  const auto ran = gyrotherm_with("run tests/profiles/ten-seconds.toml --json --rig " + (folder / "rig.toml") +
                                  " --out " + (folder / "run.db"));
  EXPECT_EQ(ran.exit_code, 0) << ran.err;
  EXPECT_NE(ran.out.find("{\"acknowledged\": 9}"), std::string::npos) << ran.out;
  const auto status = gyrotherm_with("status --json " + (folder / "run.db"));
  EXPECT_NE(status.out.find("\"simulated\":false"), std::string::npos) << status.out;
}

TEST(Simulate, ServesVirtualInstrumentsOfRealRig) {
  const Folder folder;
  Background simulate({"simulate", "--rig", "example-f4t-lakeshore-kvh"}, folder / "log");
  ASSERT_TRUE(simulate.wait_for("gyro  ", 60)) << simulate.output();
  const auto output = simulate.output();
  EXPECT_NE(output.find("Modbus TCP, unit 1, F4T"), std::string::npos) << output;
  EXPECT_NE(output.find("pt12: shell"), std::string::npos) << output;
  EXPECT_NE(output.find("frames: kvh-dsp-3000-ascii"), std::string::npos) << output;
  EXPECT_NE(output.find("SIMULATED"), std::string::npos) << output;
}

/// The unit register of an F4T has address 6730 on TCP and 14080 on a serial line.
TEST(Simulate, UsesAddressesOfSerialLink) {
  const Folder folder;
  const auto rig = shell(
      "sed 's#\\.\\./chambers/virtual#../chambers/watlow_f4t#' profiles/rigs/virtual.toml | sed "
      "\"s#\\.\\./#$PWD/profiles/#\" > " +
      (folder / "f4t.toml"));
  ASSERT_EQ(rig.exit_code, 0) << rig.err;
  Background simulate({"simulate", "--pty", "--rig", folder / "f4t.toml"}, folder / "log");
  ASSERT_TRUE(simulate.wait_for("gyro           serial", 60)) << simulate.output();
  const auto output = simulate.output();
  std::smatch serial;
  ASSERT_TRUE(std::regex_search(output, serial, std::regex(R"(chamber +(serial:\S+))"))) << output;
  const auto real =
      shell("/usr/bin/python3 tests/apps/gyrotherm/real_rig.py " + (folder / "f4t.toml") + " " + serial[1].str() + " " +
            find_port("thermometer 1", output) + " " + find_port("thermometer 2", output) + " " +
            find_port("gyro", output) + " > " + (folder / "real.toml"));
  ASSERT_EQ(real.exit_code, 0) << real.err;
  const auto asked = gyrotherm_with("check --connect --rig " + (folder / "real.toml"));
  EXPECT_EQ(asked.exit_code, 0) << asked.err;
  EXPECT_NE(asked.out.find("chamber: Watlow F4T"), std::string::npos) << asked.out;
}

}  // namespace
}  // namespace gyrotherm::app
