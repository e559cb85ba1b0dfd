// SPDX-License-Identifier: Apache-2.0
// Tests of the text clients against instruments with faulty answers. Invariant: every reading is the value that the
// instrument had when it answered the latest question for it; everything else is a fault.
//
// These faults are not generated, because no client can detect them in a protocol without checksum and sequence number:
// - a digit or sign that is lost, changed or added in front of a number;
// - a value in another unit of measure without its name;
// - a copy of an answer that arrives while a question with the same form of answer waits.
//
// GYROTHERM_SCHEDULES sets the number of schedules of each protocol.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <memory>
#include <string>

#include "core/file.hpp"
#include "drivers/chamber/modbus_chamber.hpp"
#include "drivers/chamber/register_map.hpp"
#include "drivers/chamber/text_registers.hpp"
#include "drivers/thermometer/text_thermometer.hpp"
#include "tests/drivers/chamber/hostile_text_unit.hpp"
#include "tests/support/simulated_line.hpp"

namespace gyrotherm::drivers {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

#ifdef GYROTHERM_NIGHTLY
constexpr unsigned kSchedules = 300;
#else
constexpr unsigned kSchedules = 10;
#endif
unsigned schedules() {
  const char* asked = std::getenv("GYROTHERM_SCHEDULES");
  return asked ? static_cast<unsigned>(std::atoi(asked)) : kSchedules;
}

constexpr int kSecondsOfSchedule = 200;
constexpr int kWriteEvery = 9, kSlowSeconds = 15;
/// Of 100 answers.
constexpr std::size_t kShares[] = {5, 20, 40, 70};

class ClockPauses final : public Pauses {
 public:
  explicit ClockPauses(VirtualClock& clock) : clock_(clock) {}
  Duration now() const override { return clock_.now().since_start; }
  void rest(Duration time) override { clock_.advance(time); }

 private:
  VirtualClock& clock_;
};

struct Tally {
  long good = 0, failed = 0, wrong = 0, written = 0, wrong_writes = 0;
  std::array<long, kTextFaults> made{};
  std::string first_wrong;

  void add(const Tally& other) {
    good += other.good, failed += other.failed, wrong += other.wrong;
    written += other.written, wrong_writes += other.wrong_writes;
    for (std::size_t i = 0; i < made.size(); ++i) made[i] += other.made[i];
    if (first_wrong.empty()) first_wrong = other.first_wrong;
  }
};

std::string read_profile(const std::string& path) {
  return read_text_file(GYROTHERM_SOURCE_DIR "/profiles/" + path + ".toml").value_or("");
}

HostileTextUnit::Times times_of(const MapLink& link) {
  return {.timeout = link.modbus.timeout, .silence = link.text.silence, .quiet = link.text.quiet};
}

/// One instrument of either kind with a schedule of faults.
class Schedule {
 public:
  Schedule(const TextProtocol& protocol, unsigned seed) : protocol_(protocol), seed_(seed) {}

  /// Returns the time from the last of many late answers to the first reading.
  double seconds_to_recover() {
    constexpr int kLateSeconds = 30;
    make_instrument();
    unit_->slow_by = unit_->times().timeout * 5 / 2;
    for (int second = 0; second < kLateSeconds; ++second) pass_second(second);
    unit_->slow_by = {};
    const auto good = tally_.good;
    const auto began = clock_.now().since_start;
    for (int second = kLateSeconds; tally_.good == good && second < kSecondsOfSchedule; ++second) pass_second(second);
    return to_seconds(clock_.now().since_start - began);
  }

  Tally run() {
    make_instrument();
    for (int second = 0; second < kSecondsOfSchedule; ++second) {
      unit_->slow_by = second / kSlowSeconds % 4 == 3 ? unit_->times().timeout * 5 / 2 : Duration{};
      unit_->percent = second < 3 ? 0 : kShares[seed_ % std::size(kShares)];
      pass_second(second);
      if (chamber_ && second % kWriteEvery == 5) write(second);
    }
    tally_.made = unit_->made;
    return tally_;
  }

 private:
  void make_instrument() { protocol_.inputs > 0 ? make_thermometer() : make_chamber(); }

  /// Reads once and lets the rest of the second pass.
  void pass_second(int second) {
    line_->recover();
    const auto began = clock_.now().since_start;
    unit_->truth.sent_air_c.clear();
    unit_->truth.sent_set_point_c.clear();
    protocol_.inputs > 0 ? read_inputs(second) : read_chamber(second);
    const auto spent = clock_.now().since_start - began;
    if (spent < seconds(1)) clock_.advance(seconds(1) - spent);
  }

  std::unique_ptr<tests::SimulatedLine> make_line(const MapLink& link) {
    auto line = std::make_unique<tests::SimulatedLine>(clock_);
    line_ = line.get();
    unit_ = std::make_unique<HostileTextUnit>(protocol_, *line_, times_of(link), seed_);
    return line;
  }

  void make_chamber() {
    auto map = parse_register_map(read_profile("chambers/" + protocol_.file), protocol_.file).value();
    if (protocol_.is_serial) map = select_link(map, LinkKind::text_serial).value();
    auto line = make_line(map.link);
    chamber_ = make_modbus_chamber(map, make_text_registers(map, std::move(line), "unit", &clock_),
                                   std::make_unique<ClockPauses>(clock_));
    const auto known = chamber_->identify();
    ASSERT_TRUE(known) << protocol_.name << ": " << text(known.error());
  }

  void make_thermometer() {
    auto description =
        parse_thermometer_description(read_profile("thermometers/" + protocol_.file), protocol_.file).value();
    auto line = make_line(description.unit.link);
    thermometer_ = make_text_thermometer(std::move(description), std::move(line), "unit", &clock_);
    const auto known = thermometer_->identify();
    ASSERT_TRUE(known) << protocol_.name << ": " << text(known.error());
  }

  void note_wrong(int second, const std::string& what) {
    ++tally_.wrong;
    if (tally_.first_wrong.empty())
      tally_.first_wrong = fmt::format("{}, seed {}, second {}: {}", protocol_.name, seed_, second, what);
  }

  void read_chamber(int second) {
    const auto state = chamber_->read();
    const auto& truth = unit_->truth;
    ++(state ? tally_.good : tally_.failed);
    if (!state) return;
    const auto was_sent = [](double value, const std::vector<double>& sent) {
      return std::ranges::any_of(sent, [&](double one) { return std::abs(value - one) < 1e-6; });
    };
    if (!was_sent(state->air.value, truth.sent_air_c))
      note_wrong(second, fmt::format("air {} instead of {}", state->air.value, fmt::join(truth.sent_air_c, ", ")));
    if (!was_sent(state->set_point.value, truth.sent_set_point_c))
      note_wrong(second, fmt::format("set point {} instead of {}", state->set_point.value, truth.set_point_c));
  }

  void read_inputs(int second) {
    const auto readings = thermometer_->read();
    const auto& truth = unit_->truth;
    for (std::size_t i = 0; i < readings.size(); ++i) {
      ++(readings[i] ? tally_.good : tally_.failed);
      if (readings[i] && !(i < truth.inputs_c.size() && std::abs(readings[i]->value - truth.inputs_c[i]) < 1e-6))
        note_wrong(second, fmt::format("input {} {} instead of {}", i, readings[i]->value, truth.inputs_c[i]));
    }
  }

  /// Sends a new set point. If that succeeds, a unit that acknowledges must have received it.
  void write(int second) {
    const double target = 40 + 0.1 * (second % 150);
    if (!chamber_->send_set_point({target})) return;
    ++tally_.written;
    if (protocol_.acknowledges && std::abs(unit_->truth.set_point_c - target) > 0.051) ++tally_.wrong_writes;
  }

  const TextProtocol& protocol_;
  unsigned seed_;
  VirtualClock clock_;
  tests::SimulatedLine* line_{};
  std::unique_ptr<HostileTextUnit> unit_;
  std::unique_ptr<Chamber> chamber_;
  std::unique_ptr<Thermometer> thermometer_;
  Tally tally_;
};

class TextFaults : public testing::TestWithParam<std::size_t> {};

TEST_P(TextFaults, NeverBecomeReading) {
  const auto& protocol = text_protocols().at(GetParam());
  Tally all;
  for (unsigned seed = 1; seed <= schedules() && !HasFatalFailure(); ++seed) all.add(Schedule(protocol, seed).run());
  std::string made;
  for (std::size_t i = 0; i < kTextFaults; ++i)
    made += fmt::format(" {} {}", name(static_cast<TextFault>(i)), all.made[i]);
  fmt::print("{}: {} good, {} failed, {} wrong, {} writes, {} wrong;{}\n", protocol.name, all.good, all.failed,
             all.wrong, all.written, all.wrong_writes, made);
  EXPECT_EQ(all.wrong, 0) << all.first_wrong;
  EXPECT_EQ(all.wrong_writes, 0);
  EXPECT_GT(all.good, (all.good + all.failed) / 10);
  EXPECT_GT(all.failed, 100);
  if (protocol.inputs == 0) {
    EXPECT_GT(all.written, static_cast<long>(schedules()));
  }
  for (std::size_t i = 0; i < kTextFaults; ++i) {
    const auto fault = static_cast<TextFault>(i);
    EXPECT_GT(all.made[i], 0) << gyrotherm::drivers::name(fault);
  }
}

TEST_P(TextFaults, EndWithinFifteenSeconds) {
  constexpr double kMostSeconds = 15;
  EXPECT_LE(Schedule(text_protocols().at(GetParam()), 1).seconds_to_recover(), kMostSeconds);
}

INSTANTIATE_TEST_SUITE_P(Protocols, TextFaults, testing::Range<std::size_t>(0, text_protocols().size()),
                         [](const auto& tested) { return "of_" + text_protocols()[tested.param].name; });

}  // namespace
}  // namespace gyrotherm::drivers
