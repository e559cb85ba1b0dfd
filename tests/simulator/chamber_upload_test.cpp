// SPDX-License-Identifier: Apache-2.0
/// Uploads a program into the profile memory of a controller, compares and starts it. The virtual unit then executes
/// it. Covers every shipped map with a profile memory and each of its framings, at the pace of the link on a virtual
/// clock.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>

#include "core/file.hpp"
#include "drivers/chamber/program.hpp"
#include "tests/simulator/chamber_on_a_line.hpp"

namespace gyrotherm::simulator {
namespace {

using std::chrono::minutes;
using std::chrono::seconds;

/// Returns the qualification profile shortened to one hour, with ramps of 5 °C/min and holds of 5 min.
drivers::ChamberProgram an_hour() {
  drivers::ChamberProgram program{.name = "HOUR", .number = 1, .soak_band = {}, .steps = {}};
  Celsius at{20};
  const auto soak = [&] { program.steps.push_back({drivers::StepKind::soak, at, at, minutes(5), false}); };
  soak();
  for (const double target : {-40.0, 60.0, 20.0}) {
    const auto time = abs(Celsius{target} - at) / CelsiusPerMinute{5};
    program.steps.push_back({drivers::StepKind::ramp, at, {target}, time, false});
    at = {target};
    soak();
  }
  return program;
}

double set_point_at(const drivers::ChamberProgram& program, int second) {
  Duration begun{};
  for (const auto& step : program.steps) {
    const auto within = seconds(second) - begun;
    if (within < step.duration)
      return step.start.value + (step.target - step.start).value * to_seconds(within) / to_seconds(step.duration);
    begun += step.duration;
  }
  return program.steps.back().target.value;
}

/// Returns the names of the shipped maps with a profile memory. Parses no map, because each test process calls it.
std::vector<std::string> maps_with_memory() {
  auto names = shipped_chambers();
  std::erase_if(names, [](const std::string& name) {
    const auto text = read_text_file(GYROTHERM_SOURCE_DIR "/profiles/chambers/" + name + ".toml");
    return text.value().find("\n[profile_memory]\n") == std::string::npos;
  });
  return names;
}

/// A shipped map with a profile memory, on each of its links.
class Upload : public testing::TestWithParam<std::string> {
 protected:
  template <class Test>
  static void on_each_link(Test test) {
    for (const auto& link : chamber_map(GetParam()).links) {
      SCOPED_TRACE(name(link.kind));
      ChamberOnALine line(GetParam(), link.kind);
      test(line);
    }
  }

  static void compare_and_execute(ChamberOnALine& line);
  static void end_by_set_point(ChamberOnALine& line);
  static void show_running_and_held(ChamberOnALine& line);
};

void Upload::compare_and_execute(ChamberOnALine& line) {
  const auto program = an_hour();
  const auto sent = line.chamber->send_set_point({20});
  ASSERT_TRUE(sent) << text(sent.error());
  ASSERT_TRUE(line.chamber->start());
  const auto report = line.chamber->upload(program);
  ASSERT_TRUE(report) << text(report.error());
  RecordProperty(fmt::format("upload_{}", name(line.map.link.kind)),
                 fmt::format("{}; {:.0f} s of line time", *report, to_seconds(line.clock.now().since_start)));
  const auto started = line.chamber->start_program();
  ASSERT_TRUE(started) << text(started.error());

  double furthest = 0;
  for (int second = 0; second < 3600; ++second) {
    line.pass(1);
    furthest = std::max(furthest, std::abs(line.laboratory.set_point().value - set_point_at(program, second)));
  }
  EXPECT_LT(furthest, 0.06) << "the set point is interpolated between the stored steps";
  const auto during = line.chamber->read();
  ASSERT_TRUE(during) << text(during.error());
  EXPECT_EQ(line.unit.program().step(), 6) << "the last second belongs to the last step";
  line.pass(5);
  EXPECT_FALSE(line.unit.program().is_running());
  EXPECT_EQ(line.laboratory.set_point().value, 20);
}

TEST_P(Upload, IsComparedAndExecuted) { on_each_link(compare_and_execute); }

void Upload::end_by_set_point(ChamberOnALine& line) {
  ASSERT_TRUE(line.chamber->send_set_point({20}));
  ASSERT_TRUE(line.chamber->upload(an_hour()));
  ASSERT_TRUE(line.chamber->start_program());
  line.pass(600);
  ASSERT_TRUE(line.unit.program().is_running());
  const auto done = line.chamber->send_set_point({25});
  ASSERT_TRUE(done) << text(done.error());
  line.pass(10);
  EXPECT_FALSE(line.unit.program().is_running());
  EXPECT_EQ(line.laboratory.set_point().value, 25);
}

TEST_P(Upload, EndsWhenSetPointIsSent) { on_each_link(end_by_set_point); }

void Upload::show_running_and_held(ChamberOnALine& line) {
  ASSERT_TRUE(line.chamber->upload(an_hour()));
  ASSERT_TRUE(line.chamber->start_program());
  line.pass(10);
  // On a slow line, several readings may be needed for the complete status.
  const auto running = line.chamber->inspect();
  ASSERT_TRUE(running) << text(running.error());
  EXPECT_TRUE(running->activity == ChamberActivity::program || running->activity == ChamberActivity::soaking)
      << name(running->activity);
  EXPECT_TRUE(running->alarms.empty()) << running->alarms.front();
  if (!line.map.sequences.contains("resume")) return;
  ASSERT_TRUE(line.chamber->perform("pause"));
  const auto held = line.chamber->inspect();
  ASSERT_TRUE(held);
  EXPECT_EQ(held->activity, ChamberActivity::holding);
  ASSERT_TRUE(line.chamber->perform("resume"));
  EXPECT_TRUE(line.unit.program().is_running());
}

TEST_P(Upload, ShowsRunningAndHeldProgram) { on_each_link(show_running_and_held); }

INSTANTIATE_TEST_SUITE_P(Shipped, Upload, testing::ValuesIn(maps_with_memory()),
                         [](const auto& one) { return one.param; });

TEST(UploadMaps, CoverEveryMapWithMemory) {
  const auto covered = maps_with_memory();
  for (const auto& name : shipped_chambers())
    EXPECT_EQ(chamber_map(name).memory.has_value(), std::ranges::count(covered, name) == 1) << name;
}

/// Compares registers with values in the unit of the controller, because the virtual unit uses the same map as the
/// driver.
TEST(F4tUpload, UsesUnitOfController) {
  auto written = chamber_map("watlow_f4t").text;
  const std::string celsius = "register = \"communication_unit\", value = 15";
  written.replace(written.find(celsius), celsius.size(), "register = \"communication_unit\", value = 30");
  ChamberOnALine line(drivers::parse_register_map(written, "watlow_f4t.toml").value());
  const auto registers = line.registers();
  auto program = an_hour();
  program.soak_band = {1.0};
  ASSERT_TRUE(line.chamber->upload(program));
  const auto number_at = [&](std::uint16_t address) {
    const auto words = registers->read(drivers::ReadFunction::holding_registers, address, 2).value();
    return std::bit_cast<float>(static_cast<std::uint32_t>(words[1]) << 16 | words[0]);
  };
  EXPECT_NEAR(number_at(19086), 1.8, 1e-3) << "band";
  EXPECT_NEAR(number_at(19114 + 170), -40, 1e-3) << "target of the first ramp, the same number in both units";
  EXPECT_NEAR(number_at(19114 + 3 * 170), 140, 1e-3) << "target of the second ramp: 60 °C in °F";
}

TEST(EztUpload, MatchesPublishedFrames) {
  ChamberOnALine line("csz_ezt570i", drivers::LinkKind::rtu);
  const drivers::ChamberProgram program{.name = "JESD22A",
                                        .number = 1,
                                        .soak_band = {1.0},
                                        .steps = {{drivers::StepKind::soak, {-40}, {-40}, minutes(90), true}}};
  ASSERT_TRUE(line.chamber->upload(program));
  ASSERT_TRUE(line.chamber->start_program());
  const auto said = [&](const std::string& request) {
    const auto found = std::ranges::find(line.heard, request);
    return found == line.heard.end() ? "not sent" : line.said[static_cast<std::size_t>(found - line.heard.begin())];
  };
  EXPECT_NE(said("01 03 00 B4 00 01 C4 2C"), "not sent") << "query whether the controller is busy";
  EXPECT_EQ(said("01 10 00 C8 00 0F 1E 00 00 00 00 00 00 00 00 45 4A 44 53 32 32 20 41 20 20 00 01 00 0A "
                 "00 00 00 00 00 00 00 00 3E B4"),
            "01 10 00 C8 00 0F 01 F3");
  EXPECT_EQ(said("01 10 00 D7 00 0F 1E 00 01 1E 00 00 01 00 00 00 01 00 00 00 00 00 00 00 01 00 00 FE 70 "
                 "00 00 00 00 00 00 00 00 73 19"),
            "01 10 00 D7 00 0F 30 35");
  EXPECT_NE(said("01 06 00 25 00 01 59 C1"), "not sent") << "start at step 1";
  EXPECT_NE(said("01 06 00 18 00 04 08 0E"), "not sent") << "run";
  ASSERT_TRUE(line.chamber->perform("pause"));
  EXPECT_NE(said("01 06 00 18 00 02 88 0C"), "not sent") << "hold";
}

TEST(EztUpload, SendsBlocksOneSecondApart) {
  ChamberOnALine line("csz_ezt570i", drivers::LinkKind::rtu);
  ASSERT_TRUE(line.chamber->upload(an_hour()));
  EXPECT_GE(line.clock.now().since_start, seconds(8)) << "a header and seven steps, one second apart";
}

TEST(EztUnit, SendsNoExceptionsAndIgnoresForeignBlocks) {
  ChamberOnALine line("csz_ezt570i", drivers::LinkKind::rtu);
  const auto registers = line.registers();
  EXPECT_EQ(registers->read(drivers::ReadFunction::holding_registers, 1800, 1).error().kind, FaultKind::timeout);
  const std::uint16_t word = 300;
  EXPECT_TRUE(registers->write(drivers::WriteFunction::registers, 60, std::span(&word, 1))) << "acknowledged …";
  EXPECT_EQ(line.laboratory.set_point().value, 20) << "… and ignored";
}

}  // namespace
}  // namespace gyrotherm::simulator
