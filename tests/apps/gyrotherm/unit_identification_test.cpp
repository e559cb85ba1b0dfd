// SPDX-License-Identifier: Apache-2.0
/// The identification of units when a run starts, by options, by an order and on a terminal.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "acquisition/record/record.hpp"
#include "acquisition/record/run_info.hpp"
#include "tests/apps/gyrotherm/program.hpp"

namespace gyrotherm::app {
namespace {

constexpr const char* kOrder = R"(schema = "gyrotherm-order/1"
number = "2026-17"
serial_numbers = ["0042", "0043", "0044"]

[customer]
name = "Navigation Works"
)";

/// A folder with a short profile, an order and rigs.
class LotFolder : public Folder {
 public:
  LotFolder() {
    std::ofstream(*this / "short.toml") << "schema = \"gyrotherm-profile/1\"\nname = \"short\"\n\n[[segment]]\nkind = "
                                           "\"hold\"\nat = \"20 °C\"\ntime = \"1 min\"\n";
    std::ofstream(*this / "order.toml") << kOrder;
  }
  /// Writes a copy of a shipped rig without the lines that match `removed`.
  std::string write_rig(const std::string& shipped, const std::string& removed) const {
    const auto rig = *this / (shipped + ".toml");
    EXPECT_EQ(shell("sed '/" + removed + "/d; s#\"\\.\\./#\"" GYROTHERM_SOURCE_DIR "/profiles/#' profiles/rigs/" +
                    shipped + ".toml > '" + rig + "'")
                  .exit_code,
              0);
    return rig;
  }
  /// Returns the virtual rig of eight units, whose serial numbers are left to the start of a run.
  [[nodiscard]] std::string lot() const { return write_rig("virtual-lot", "^serial_number"); }
  /// Returns a real rig with one unit; its chamber does not answer.
  [[nodiscard]] std::string real() const {
    const auto rig = write_rig("example-f4t-lakeshore-kvh", "^serial_number");
    EXPECT_EQ(shell("sed -i 's#tcp://[0-9.]*:502#tcp://127.0.0.1:1#' '" + rig + "'").exit_code, 0);
    return rig;
  }
  /// Returns a real rig with eight units; none of its instruments answers.
  [[nodiscard]] std::string real_lot() const {
    const auto rig = write_rig("virtual-lot", "^serial_number");
    EXPECT_EQ(
        shell("sed -i '/^\\[virtual/,$d; /^\\[\\[virtual/,$d; s#= \"virtual\"#= \"tcp://127.0.0.1:1\"#' '" + rig + "'")
            .exit_code,
        0);
    return rig;
  }
  Ran run(const std::string& arguments) const {
    return gyrotherm_with("run '" + (*this / "short.toml") + "' --rig " + arguments);
  }
};

bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

TEST(UnitIdentification, IsRecordedWithOrder) {
  const LotFolder folder;
  const auto record = folder / "one.db";
  const auto rig = folder.lot();
  const auto ran = folder.run(rig + " --unit u1=0042 --unit ' u2 =0043' --unit u3= --unit u4= --order " +
                              (folder / "order.toml") + " --out " + record);
  ASSERT_EQ(ran.exit_code, 0) << ran.err;
  EXPECT_TRUE(contains(ran.err, "units: u1 0042, u2 0043, u5 without serial number")) << ran.err;
  EXPECT_TRUE(contains(ran.err, "; u3, u4 not used; order 2026-17")) << ran.err;
  const auto read = record::read_record(record).value();
  EXPECT_EQ(read.info.units[0].serial_number, "0042");
  EXPECT_EQ(read.info.units[1].serial_number, "0043");
  EXPECT_EQ(read.info.unused_units, (std::vector<std::string>{"u3", "u4"}));
  EXPECT_EQ(read.info.order_number, "2026-17");
  EXPECT_FALSE(std::isnan(read.units[0].rotation[0][10]));
  EXPECT_TRUE(std::isnan(read.units[2].rotation[0][10])) << "an empty position has no readings";
  EXPECT_EQ(gyrotherm_with("status --verify " + record).exit_code, 0);
}

TEST(UnitIdentification, DistinguishesVirtualRunsOfOneSeed) {
  const LotFolder folder;
  const auto rig = folder.lot();
  const auto id = [&](const std::string& name, const std::string& options) {
    const auto ran = folder.run(rig + options + " --out " + (folder / name));
    EXPECT_EQ(ran.exit_code, 0) << ran.err;
    return record::read_info(folder / name).value().id;
  };
  EXPECT_NE(id("a.db", " --unit u1=0042"), id("b.db", " --unit u1=0043"));
}

TEST(UnitIdentification, RefusesContradictions) {
  const LotFolder folder;
  const auto rig = folder.lot(), order = folder / "order.toml";
  const auto refused = [&](const std::string& arguments) {
    const auto ran = folder.run(arguments + " --out " + (folder / "no.db"));
    EXPECT_NE(ran.exit_code, 0) << arguments;
    EXPECT_FALSE(std::filesystem::exists(folder / "no.db"));
    return ran.err;
  };
  EXPECT_TRUE(contains(refused("virtual-lot --unit u1=0042"), "the serial number 0042, but "));
  EXPECT_TRUE(contains(refused("virtual-lot --unit u1=0042"), "gives it V-0101"));
  EXPECT_TRUE(contains(refused(rig + " --unit u1=7 --unit u2=7"), "7 is given to u1 and to u2"));
  EXPECT_TRUE(contains(refused(rig + " --unit u9=7"), "expected POSITION=SERIAL with one of u1, u2"));
  EXPECT_TRUE(contains(refused(rig + " --unit 'u1=0\x1d"
                                     "1'"),
                       "contains the character \\x1d at position 2"));
  EXPECT_TRUE(contains(refused(rig + " --unit u1=" + std::string(65, '1')), "has 65 bytes, expected at most 64"));
  EXPECT_TRUE(contains(refused(rig + " --unit u1=42 --order " + order),
                       "the order does not contain the serial number \"42\" of u1"));
  EXPECT_TRUE(contains(refused("virtual-lot --order " + order), "does not contain the serial number \"V-0101\""));
  EXPECT_TRUE(contains(refused(rig + " --order " + (folder / "none.toml")), "none.toml"));
}

TEST(UnitIdentification, NamesMissingOptionWithoutTerminal) {
  const LotFolder folder;
  const auto ran = folder.run(folder.real() + " --out " + (folder / "no.db"));
  EXPECT_EQ(ran.exit_code, 2);
  EXPECT_TRUE(contains(ran.err, "no serial number for gyro, expected --unit gyro=SERIAL")) << ran.err;
  const auto qualified = gyrotherm_with("qualify --rig " + folder.real() + " --out " + (folder / "out"));
  EXPECT_EQ(qualified.exit_code, 2);
  EXPECT_TRUE(contains(qualified.err, "expected --unit gyro=SERIAL")) << qualified.err;
}

TEST(UnitIdentification, IsAskedForOnTerminal) {
  const LotFolder folder;
  const auto ran = run_on_terminal({"run", folder / "short.toml", "--rig", folder.real(), "--order",
                                    folder / "order.toml", "--out", folder / "no.db"},
                                   "\n0099\n 0043\r");
  EXPECT_TRUE(contains(ran.out, "serial number of the unit (scan or type): ")) << ran.out;
  EXPECT_TRUE(contains(ran.out, "does not contain the serial number \"0099\"")) << "asks again: " << ran.out;
  EXPECT_TRUE(contains(ran.out, "units: gyro 0043; order 2026-17")) << ran.out;
  EXPECT_EQ(ran.exit_code, 3) << "the chamber does not answer: " << ran.out;
}

TEST(UnitIdentification, AsksForEachPositionOnTerminal) {
  const LotFolder folder;
  const auto ran = run_on_terminal(
      {"run", folder / "short.toml", "--rig", folder.real_lot(), "--unit", "u8=8", "--out", folder / "no.db"},
      "0042\n0042\n0043\n\n-\n 5\n6\n7\n");
  EXPECT_TRUE(contains(ran.out, "position u1: serial number")) << ran.out;
  EXPECT_TRUE(contains(ran.out, "the serial number 0042 is given to u1 and to u2")) << "asks again: " << ran.out;
  EXPECT_FALSE(contains(ran.out, "position u8")) << "an option gives it";
  EXPECT_TRUE(contains(ran.out, "units: u1 0042, u2 0043, u5 5, u6 6, u7 7, u8 8; u3, u4 not used")) << ran.out;
  EXPECT_EQ(ran.exit_code, 3) << ran.out;
}

TEST(UnitIdentification, IsAnsweredFromElsewhere) {
  const LotFolder folder;
  const auto record = folder / "lot/page.db";
  const Background run({"run",
                        folder / "short.toml",
                        "--rig",
                        folder.real_lot(),
                        "--order",
                        folder / "order.toml",
                        "--unit",
                        "u1=0042",
                        "--unit",
                        "u3=",
                        "--unit",
                        "u4=",
                        "--unit",
                        "u5=",
                        "--unit",
                        "u6=",
                        "--unit",
                        "u7=",
                        "--wait-for-units",
                        "--out",
                        record},
                       folder / "run.log");
  ASSERT_TRUE(run.wait_for("position u2: answer with its serial number, or - if it is empty", 60)) << run.output();
  const auto status = gyrotherm_with("status " + record);
  EXPECT_EQ(status.exit_code, 0) << status.err;
  EXPECT_TRUE(contains(status.out, "held: position u2: answer with its serial number")) << status.out;
  const auto tell = [&](const std::string& words) { return gyrotherm_with("tell " + record + " " + words); };
  const auto other = tell("resume 0099");
  EXPECT_EQ(other.exit_code, 3);
  EXPECT_TRUE(contains(other.err, "does not contain the serial number \"0099\"")) << other.err;
  EXPECT_TRUE(contains(tell("resume 0042").err, "0042 is given to u1 and to u2"));
  EXPECT_TRUE(contains(tell("resume").err, "or - if it is empty")) << "an empty text is no answer";
  EXPECT_TRUE(contains(tell("pause").err, "the run has not started"));
  EXPECT_EQ(gyrotherm_with("run '" + (folder / "short.toml") + "' --wait-for-units --rig " + folder.real_lot() +
                           " --out " + record)
                .exit_code,
            3)
      << "the name is in use";
  EXPECT_TRUE(contains(tell("resume 0043").err, "u2 0043"));
  ASSERT_TRUE(run.wait_for("position u8", 60)) << run.output();
  EXPECT_TRUE(contains(tell("resume -").err, "u8 -"));
  EXPECT_TRUE(run.wait_for("units: u1 0042, u2 0043; u3, u4, u5, u6, u7, u8 not used; order 2026-17", 60))
      << run.output();
  EXPECT_FALSE(std::filesystem::exists(record + ".status"));
}

TEST(UnitIdentification, IsStoppedFromElsewhere) {
  const LotFolder folder;
  const auto record = folder / "page.db";
  Background run({"run", folder / "short.toml", "--rig", folder.real(), "--wait-for-units", "--out", record},
                 folder / "run.log");
  ASSERT_TRUE(run.wait_for("answer with the serial number of the unit", 60)) << run.output();
  EXPECT_EQ(gyrotherm_with("tell " + record + " stop").exit_code, 0);
  EXPECT_EQ(run.wait(), 5) << run.output();
  EXPECT_FALSE(std::filesystem::exists(record + ".status"));
  EXPECT_FALSE(std::filesystem::exists(record + ".socket"));
}

TEST(UnitIdentification, EndsWithItsInput) {
  const LotFolder folder;
  const auto ran =
      run_on_terminal({"run", folder / "short.toml", "--rig", folder.real(), "--out", folder / "no.db"}, "\x04");
  EXPECT_EQ(ran.exit_code, 2) << ran.out;
  EXPECT_TRUE(contains(ran.out, "expected --unit gyro=SERIAL")) << ran.out;
}

TEST(UnitIdentification, NoticesRunThatUnitHasFinished) {
  const LotFolder folder;
  const auto rig = folder.lot(), order = " --order " + (folder / "order.toml");
  const auto run = [&](const std::string& name, const std::string& options) {
    return folder.run(rig + " --unit u1=0042" + options + " --out " + (folder / name));
  };
  ASSERT_EQ(run("one.db", order).exit_code, 0);
  const auto again = run("two.db", order);
  EXPECT_EQ(again.exit_code, 3) << again.err;
  EXPECT_TRUE(contains(again.err, "0042 has finished \"short\" in the order 2026-17: ")) << again.err;
  EXPECT_TRUE(contains(again.err, "one.db; --again runs it again")) << again.err;
  EXPECT_EQ(run("two.db", order + " --again").exit_code, 0);
  EXPECT_EQ(run("three.db", "").exit_code, 0) << "no order, no comparison";
  const std::vector<std::string> arguments{
      "run",   folder / "short.toml", "--rig", rig, "--unit", "u1=0042", "--order", folder / "order.toml",
      "--out", folder / "four.db"};
  EXPECT_EQ(run_on_terminal(arguments, "n\n").exit_code, 3);
  const auto confirmed = run_on_terminal(arguments, "y\ny\n");
  EXPECT_EQ(confirmed.exit_code, 0) << confirmed.out;
}

TEST(UnitIdentification, IsKeptByResume) {
  const LotFolder folder;
  const auto record = folder / "one.db", rig = folder.lot(), profile = folder / "long.toml";
  ASSERT_EQ(shell("sed 's/1 min/90 min/' '" + (folder / "short.toml") + "' > '" + profile + "'").exit_code, 0);
  {
    Background run({"run", profile, "--rig", rig, "--unit", "u1=0042", "--unit", "u2=", "--json", "--out", record},
                   folder / "run.log");
    ASSERT_TRUE(run.wait_for("acknowledged", 60));
    run.signal(SIGINT);
    ASSERT_EQ(run.wait(), 5) << run.output();
  }
  const auto other = gyrotherm_with("resume " + record + " --unit u1=0043");
  EXPECT_EQ(other.exit_code, 2) << other.err;
  EXPECT_TRUE(contains(other.err, "gives u1 the serial number 0043, but " + record + " contains 0042")) << other.err;
  const auto same = gyrotherm_with("resume " + record + " --unit u1=0042 --unit u2=");
  ASSERT_EQ(same.exit_code, 0) << same.err;
  const auto read = record::read_record(record).value();
  EXPECT_EQ(read.info.units[0].serial_number, "0042");
  EXPECT_FALSE(std::isnan(read.units[0].rotation[0].back()));
  EXPECT_TRUE(std::isnan(read.units[1].rotation[0].back())) << "u2 is empty after the resume, too";
}

}  // namespace
}  // namespace gyrotherm::app
