// SPDX-License-Identifier: Apache-2.0
/// Programs and settings that disturb serial adapters, in folders like those of a system.
#include "apps/gyrotherm/machine_checks.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <map>

#include "tests/support/folder.hpp"

namespace gyrotherm::app {
namespace {

namespace fs = std::filesystem;

class SerialChecks : public testing::Test {
 protected:
  void write(const std::string& file, const std::string& text) {
    const fs::path path = root() + file;
    fs::create_directories(path.parent_path());
    std::ofstream(path) << text;
  }
  void start(int pid, const std::string& name) { write("/proc/" + std::to_string(pid) + "/comm", name + "\n"); }

  /// Creates a USB adapter as the kernel shows it. `properties` are the udev properties of its port.
  Device plug_in(const std::string& tty, const std::string& power, const std::string& properties = "") {
    const auto usb = "/sys/devices/pci0/usb1/1-" + tty;
    write(usb + "/idVendor", "0403\n");
    write(usb + "/power/control", power + "\n");
    write(usb + "/1-1:1.0/" + tty + "/uevent", "");
    const auto number = "188:" + std::to_string(++ports_);
    write("/sys/class/tty/" + tty + "/dev", number + "\n");
    fs::create_symlink(root() + usb + "/1-1:1.0/" + tty, root() + "/sys/class/tty/" + tty + "/device");
    write("/run/udev/data/c" + number, "S:serial/by-id/x\n" + properties);
    return {.node = {"/dev/" + tty, true, "dialout"}, .usb = "0403:6001"};
  }

  [[nodiscard]] std::map<std::string, Finding> findings(const std::vector<Device>& devices) const {
    std::map<std::string, Finding> found;
    for (const auto& finding : check_serial_adapters(devices, root())) found[finding.what] = finding;
    for (const auto& [what, finding] : found) EXPECT_EQ(finding.fix.empty(), finding.state == FindingState::ok) << what;
    return found;
  }
  [[nodiscard]] std::string root() const { return folder_ / "system"; }

 private:
  tests::TestFolder folder_;
  int ports_ = 0;
};

TEST_F(SerialChecks, FindNothingWithoutTheseSettings) {
  start(1, "systemd");
  const auto found = findings({plug_in("ttyUSB0", "on")});
  EXPECT_EQ(found.size(), 2u);
  for (const auto& [what, finding] : found) EXPECT_EQ(finding.state, FindingState::ok) << what;
}

TEST_F(SerialChecks, FindModemManagerWhenItMayProbePort) {
  start(711, "ModemManager");
  const auto mine = plug_in("ttyUSB0", "on", "E:ID_MM_DEVICE_IGNORE=1\n"),
             port = plug_in("ttyUSB1", "on", "E:ID_MM_PORT_IGNORE=1\n");
  EXPECT_EQ(findings({mine, port}).at("ModemManager").state, FindingState::ok);
  const auto probed = plug_in("ttyACM0", "on", "E:ID_MM_DEVICE_IGNORE=10\nE:ID_MM_CANDIDATE=1\n");
  const auto found = findings({mine, probed, port}).at("ModemManager");
  EXPECT_EQ(found.state, FindingState::warning);
  EXPECT_NE(found.found.find("/dev/ttyACM0"), std::string::npos);
  EXPECT_EQ(found.found.find("/dev/ttyUSB0"), std::string::npos);
  auto built_in = probed;
  built_in.usb.clear();
  EXPECT_EQ(findings({built_in}).at("ModemManager").state, FindingState::ok) << "it is not on USB";
}

TEST_F(SerialChecks, FindBrlttyWhenItClaimsCommonAdapters) {
  write("/usr/lib/udev/rules.d/85-brltty.rules", "# ENV{PRODUCT}==\"1a86/7523/*\"\nENV{PRODUCT}==\"4242/1/100\"\n");
  EXPECT_EQ(findings({}).at("brltty").state, FindingState::ok) << "a comment does not claim an adapter";
  write("/usr/lib/udev/rules.d/90-brltty-device.rules", "ENV{PRODUCT}==\"10c4/ea60/*\", ENV{BRLTTY}=\"yes\"\n");
  EXPECT_NE(findings({}).at("brltty").found.find("/usr/lib/udev/rules.d/90-brltty-device.rules"), std::string::npos);
  fs::remove_all(root() + "/usr");
  EXPECT_EQ(findings({}).at("brltty").state, FindingState::ok);
  start(99, "brltty");
  EXPECT_EQ(findings({}).at("brltty").state, FindingState::warning);
}

TEST_F(SerialChecks, FindAdaptersThatMayBeSuspended) {
  const auto awake = plug_in("ttyUSB0", "on"), asleep = plug_in("ttyUSB1", "auto"), modem = plug_in("ttyACM3", "auto");
  const auto found = findings({awake, asleep, modem});
  EXPECT_FALSE(found.contains("power of /dev/ttyUSB0"));
  EXPECT_EQ(found.at("power of /dev/ttyUSB1").state, FindingState::warning);
  EXPECT_NE(found.at("power of /dev/ttyACM3").fix.find("1-ttyACM3/power/control"), std::string::npos);
}

TEST_F(SerialChecks, HaveShippedRulesForEachFinding) {
  std::ifstream file(GYROTHERM_SOURCE_DIR "/drivers/60-gyrotherm.rules");
  const std::string rules((std::istreambuf_iterator<char>(file)), {});
  for (const auto* part : {"ftdi_sio", "cp210x", "pl2303", "ch341", "ENV{ID_MM_DEVICE_IGNORE}=\"1\"",
                           "ENV{ID_MM_PORT_IGNORE}=\"1\"", "ATTR{power/control}=\"on\""})
    EXPECT_NE(rules.find(part), std::string::npos) << part;
}

}  // namespace
}  // namespace gyrotherm::app
