// SPDX-License-Identifier: Apache-2.0
/// The virtual instruments with third-party clients.
#include <gtest/gtest.h>

#include <csignal>
#include <fstream>
#include <map>
#include <regex>
#include <vector>

#include "acquisition/record/record.hpp"
#include "tests/apps/gyrotherm/program.hpp"
#include "tests/apps/gyrotherm/real_rig.hpp"

namespace gyrotherm::app {
namespace {

int count_occurrences(const std::string& output, const std::string& part) {
  int count = 0;
  for (auto at = output.find(part); at != std::string::npos; at = output.find(part, at + 1)) ++count;
  return count;
}

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
  EXPECT_NE(ran.err.find("SIMULATED: these instruments are virtual: chamber, thermometer 1, thermometer 2"),
            std::string::npos)
      << ran.err;
  const auto status = gyrotherm_with("status --json " + (folder / "run.db"));
  EXPECT_NE(status.out.find("\"simulated\":true"), std::string::npos) << status.out;
  EXPECT_NE(status.out.find("\"virtual_instruments\":[\"chamber\",\"thermometer 1\",\"thermometer 2\"]"),
            std::string::npos)
      << status.out;
  const auto csv = shell("gyrotherm export " + (folder / "run.db") + " --out " + (folder / "t.csv") + " >&2 && cat " +
                         (folder / "t.csv"));
  EXPECT_TRUE(
      csv.out.starts_with("# SIMULATED: these instruments were virtual: chamber, thermometer 1, thermometer 2\n"))
      << csv.out << csv.err;
  const auto info = record::read_info(folder / "run.db");
  ASSERT_TRUE(info);
  EXPECT_FALSE(info->virtual_rig) << "it was recorded in real time";
  const auto asked = gyrotherm_with("check --connect --rig " + (folder / "rig.toml"));
  EXPECT_EQ(count_occurrences(asked.out, "; SIMULATED: it is virtual"), 3) << asked.out << asked.err;
}

/// Copies the real rig file under the name of a real chamber, with both thermometers behind proxies.
class RenamedInstruments : public testing::Test {
 protected:
  void SetUp() override {
    ASSERT_TRUE(simulate.wait_for("gyro  ", 60)) << simulate.output();
    for (int i = 1; i <= 2; ++i) ports[i] = start_proxy(i, "0", "21A45C");
    const auto map = shell(R"(sed 's/^name = "virtual chamber"/name = "oven"/; s/^vendor = .*/vendor = "Acme"/' )"
                           "profiles/chambers/virtual.toml > " +
                           (folder / "oven.toml"));
    ASSERT_EQ(map.exit_code, 0) << map.err;
    const auto made =
        shell("/usr/bin/python3 tests/apps/gyrotherm/real_rig.py profiles/rigs/virtual.toml " +
              find_port("chamber", simulate.output()) + " " + ports[1] + " " + ports[2] + " " +
              find_port("gyro", simulate.output()) + " | sed 's#^map = .*#map = \"oven.toml\"#' > " + rig);
    ASSERT_EQ(made.exit_code, 0) << made.err;
  }
  void TearDown() override {
    for (int i = 1; i <= 2; ++i) end_proxy(i);
  }

  /// Starts the proxy of a thermometer, which reports the serial number. Returns its port.
  std::string start_proxy(int thermometer, const std::string& port, const std::string& serial_number) {
    const auto name = folder / ("proxy" + std::to_string(thermometer));
    const auto started =
        shell("rm -f " + name + "; /usr/bin/python3 tests/apps/gyrotherm/renaming_proxy.py " + port + " " +
              find_port("thermometer " + std::to_string(thermometer), simulate.output()) + " VIRTUAL1 " +
              serial_number + " > " + name + " 2>&1 & echo $! > " + name + ".pid; for i in $(seq 100); do [ -s " +
              name + " ] && break; sleep 0.1; done; cat " + name);
    return started.out.substr(0, started.out.find('\n'));
  }
  void end_proxy(int thermometer) const {
    (void)shell("kill $(cat " + (folder / ("proxy" + std::to_string(thermometer))) + ".pid)");
  }

  const Folder folder;
  const std::string rig = folder / "rig.toml", record = folder / "run.db";
  std::map<int, std::string> ports;
  const Background simulate{{"simulate", "--rig", "profiles/rigs/virtual.toml"}, folder / "log"};
};

TEST_F(RenamedInstruments, AreNamedOnlyIfVirtual) {
  end_proxy(2);
  ASSERT_EQ(start_proxy(2, ports[2], "VIRTUAL1"), ports[2]);
  const auto ran = gyrotherm_with("run tests/profiles/ten-seconds.toml --rig " + rig + " --out " + record);
  ASSERT_EQ(ran.exit_code, 0) << ran.err;
  EXPECT_EQ(record::read_info(record).value().virtual_instruments, std::vector<std::string>{"thermometer 2"});
  const auto csv =
      shell("gyrotherm export " + record + " --out " + (folder / "t.csv") + " >&2 && cat " + (folder / "t.csv"));
  EXPECT_TRUE(csv.out.starts_with("# SIMULATED: these instruments were virtual: thermometer 2\n")) << csv.out;
}

/// The description of a run cannot be changed, so rows of virtual instruments would not be marked.
TEST_F(RenamedInstruments, DoNotContinueRunOfRealInstrumentsOnVirtualOnes) {
  {
    Background run({"run", "tests/profiles/ten-minutes-warm.toml", "--rig", rig, "--out", record, "--json"},
                   folder / "run.log");
    ASSERT_TRUE(run.wait_for("\"acknowledged\": 3}", 60)) << run.output();
    run.signal(SIGINT);
    run.wait();
  }
  EXPECT_FALSE(record::is_simulated(record::read_info(record).value()));
  end_proxy(1);
  ASSERT_EQ(start_proxy(1, ports[1], "VIRTUAL1"), ports[1]);
  const auto refused = gyrotherm_with("resume --accept " + record);
  EXPECT_NE(refused.exit_code, 0);
  EXPECT_NE(refused.err.find("thermometer 1 is now virtual, but the run is not marked"), std::string::npos)
      << refused.err;
  end_proxy(1);
  ASSERT_EQ(start_proxy(1, ports[1], "21A45C"), ports[1]);
  Background resumed({"resume", record, "--json"}, folder / "resume.log");
  EXPECT_TRUE(resumed.wait_for("\"acknowledged\": ", 60)) << "with the instruments of its start: " << resumed.output();
  resumed.signal(SIGINT);
  resumed.wait();
}

TEST(Simulate, ResumedRunKeepsItsMark) {
  const Folder folder;
  const RealLaboratory laboratory(folder / "");
  ASSERT_TRUE(laboratory.serves());
  const auto record = folder / "run.db";
  for (const auto& command : {std::vector<std::string>{"run", "tests/profiles/ten-minutes-warm.toml", "--rig",
                                                       laboratory.rig(), "--out", record, "--json"},
                              {"resume", record, "--json"}}) {
    Background run(command, folder / (command.front() + ".log"));
    ASSERT_TRUE(run.wait_for("\"acknowledged\": ", 60)) << run.output();
    run.signal(SIGINT);
    run.wait();
    EXPECT_NE(run.output().find("SIMULATED: these instruments are virtual: chamber"), std::string::npos)
        << run.output();
    const auto status = gyrotherm_with("status --json " + record);
    EXPECT_NE(status.out.find("\"simulated\":true"), std::string::npos) << status.out;
  }
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

/// The rig has its own latitude and more thermometers than the virtual gyro.
TEST(Simulate, ServesRigWithManyThermometersElsewhere) {
  const Folder folder;
  const auto made = shell("sed 's/^latitude = .*/latitude = 51.05/' profiles/rigs/example-f4t-lakeshore-kvh.toml > " +
                          (folder / "rig.toml"));
  ASSERT_EQ(made.exit_code, 0) << made.err;
  std::ofstream(folder / "rig.toml", std::ios::app)
      << "\n[[thermometer]]\ndriver = \"lakeshore_218\"\nline = \"tcp://127.0.0.1:7777\"\nuncertainty = 0.04\n"
         "channels = [\"p1\", \"p2\", \"p3\", \"p4\", \"p5\", \"p6\", \"p7\", \"p8\"]\n";
  Background simulate({"simulate", "--rig", folder / "rig.toml"}, folder / "log");
  ASSERT_TRUE(simulate.wait_for("gyro  ", 60)) << simulate.output();
  EXPECT_NE(simulate.output().find("p8"), std::string::npos) << simulate.output();
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
