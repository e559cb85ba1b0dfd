// SPDX-License-Identifier: Apache-2.0
/// The virtual chamber with third-party Modbus clients: both framings, four word orders, exceptions.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <csignal>
#include <fstream>
#include <optional>
#include <regex>
#include <sstream>

#include "core/file.hpp"
#include "tests/apps/gyrotherm/program.hpp"

namespace gyrotherm::app {
namespace {

struct Setting {
  std::string framing, order, words;  ///< −40.25 on the wire
};
void PrintTo(const Setting& setting, std::ostream* out) { *out << setting.framing << " " << setting.order; }

class Peers : public testing::TestWithParam<Setting> {
 protected:
  /// Serves the default rig with an F4T. Returns whether it is ready.
  bool serve() {
    auto text = read_text_file(GYROTHERM_SOURCE_DIR "/profiles/rigs/virtual.toml").value();
    const auto begin = text.find("map = "), end = text.find("line = ");
    text.replace(begin, end - begin,
                 fmt::format("map = \"../chambers/watlow_f4t.toml\"\nframing = \"{}\"\nword_order = \"{}\"\n",
                             GetParam().framing, GetParam().order));
    const std::string profiles = GYROTHERM_SOURCE_DIR "/profiles/";
    for (auto at = text.find("\"../"); at != std::string::npos; at = text.find("\"../", at))
      text.replace(at, 4, "\"" + profiles);
    std::ofstream(folder / "rig.toml") << text;
    simulate.emplace(std::vector<std::string>{"simulate", "--pty", "--pace", "x50", "--rig", folder / "rig.toml"},
                     folder / "log");
    return simulate->wait_for("gyro", 20);
  }
  /// Returns the port or device of the chamber.
  [[nodiscard]] std::string address() const {
    const auto output = simulate->output();
    std::smatch match;
    const std::regex tcp(R"(chamber +tcp://127\.0\.0\.1:(\d+))"), rtu(R"(chamber +serial:(/dev/pts/\d+))");
    return std::regex_search(output, match, GetParam().framing == "tcp" ? tcp : rtu) ? match[1].str() : "";
  }

  const Folder folder;
  std::optional<Background> simulate;
};

TEST_P(Peers, PymodbusDrivesChamberAndGetsExceptions) {
  if (shell("/usr/bin/python3 -c 'import pymodbus.client'").exit_code != 0)
    GTEST_SKIP() << "python3-pymodbus is not installed";
  ASSERT_TRUE(serve()) << simulate->output();
  const auto ran = shell(fmt::format("timeout 60 /usr/bin/python3 tests/apps/gyrotherm/chamber_peer.py {} {} {}",
                                     GetParam().framing, address(), GetParam().order));
  EXPECT_EQ(ran.exit_code, 0) << simulate->output() << ran.out << ran.err;
}

TEST_P(Peers, MbpollWritesRegistersAndReadsThemBack) {
  if (!installed("mbpoll")) GTEST_SKIP() << "mbpoll is not installed";
  ASSERT_TRUE(serve()) << simulate->output();
  const bool tcp = GetParam().framing == "tcp";
  const auto mbpoll = [&](const std::string& options, const std::string& values) {
    return shell(tcp ? fmt::format("mbpoll -m tcp -a 1 -0 -1 -q {} -p {} 127.0.0.1 {}", options, address(), values)
                     : fmt::format("mbpoll -m rtu -b 9600 -P none -a 1 -0 -1 -q {} {} {}", options, address(), values));
  };
  const auto written = mbpoll("-t 4 -r 2782", "-- " + GetParam().words);
  EXPECT_EQ(written.exit_code, 0) << written.out << written.err;
  const auto back = mbpoll("-t 4 -r 2782 -c 2", "");
  std::istringstream words(GetParam().words);
  for (std::string word; words >> word;)
    EXPECT_TRUE(std::regex_search(back.out, std::regex("\\]:\\s+" + word))) << back.out << back.err;
  EXPECT_NE(mbpoll("-t 4 -r 5 -c 1", "").err.find("Illegal data address"), std::string::npos);
  EXPECT_NE(mbpoll("-t 0 -r 5", "1").err.find("Illegal data address"), std::string::npos);
  EXPECT_NE(mbpoll("-t 4 -r 2730", "11").err.find("Illegal data value"), std::string::npos);
}

INSTANTIATE_TEST_SUITE_P(Orders, Peers,
                         testing::Values(Setting{"tcp", "abcd", "49697 0"}, Setting{"tcp", "cdab", "0 49697"},
                                         Setting{"tcp", "badc", "8642 0"}, Setting{"tcp", "dcba", "0 8642"},
                                         Setting{"rtu", "abcd", "49697 0"}, Setting{"rtu", "cdab", "0 49697"},
                                         Setting{"rtu", "badc", "8642 0"}, Setting{"rtu", "dcba", "0 8642"}),
                         [](const auto& setting) { return setting.param.framing + "_" + setting.param.order; });

}  // namespace
}  // namespace gyrotherm::app
