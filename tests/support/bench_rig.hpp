// SPDX-License-Identifier: Apache-2.0
/// Bench rig: a chamber with its air, nine thermometers, a gyro, and a record in memory. Each part fails on command.
/// The parts implement the interfaces of real rigs, so tests execute the same run code.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "acquisition/record/alarms.hpp"
#include "acquisition/record/record.hpp"
#include "acquisition/record/store.hpp"
#include "sequencer/rig/rig.hpp"
#include "tests/support/run_harness.hpp"

namespace gyrotherm::tests {

/// Actual state of the chamber, which its replies may contradict.
struct BenchChamber {
  double set_point_c = 20, air_c = 20;
  bool on = true;
  bool silent{};
  /// Refuses set points with an exception.
  bool refuses{};
  /// Position in the fault of a refused set point.
  std::string fault_place = "chamber";
  /// Refuses the command that switches it off.
  bool refuses_off{};
  /// Acknowledges set points but keeps the previous one, which the read-back reveals.
  bool ignores{};
  bool door_open{};
  bool must_stop{};
  /// Heats by half a kelvin per second regardless of the set point, and reports manual mode.
  bool manual{};
  /// Remains in manual mode when another mode is written.
  bool keeps_manual{};
  /// Does not report its activity.
  bool hides_mode{};
  double lag_s = 60;
  /// The controller multiplies each set point by this factor, and shows it divided.
  double scale = 1;
  /// Every set point that reached the chamber.
  std::vector<double> sent_c;
  /// Number of set points sent although the line is paused.
  int immediate_set_points = 0;

  void second() {
    constexpr double kHeatsK = 0.5;
    if (on && manual)
      air_c += kHeatsK;
    else
      follow();
  }
  void follow() { air_c += (on && !door_open ? set_point_c * scale - air_c : 22 - air_c) / lag_s; }
  /// Restarts with the default set point, as after a power cut.
  void restart() { set_point_c = 20; }
};

class BenchIo final : public io::InstrumentIo {
 public:
  explicit BenchIo(BenchChamber& chamber) : chamber_(chamber) {}

  Sample read(std::int64_t slot, const Clock& clock) override {
    Sample sample;
    sample.slot = slot;
    sample.at = clock.now();
    sample.chamber = {state(), sample.at};
    sample.thermometers.assign(9, {Celsius{uut_c}, sample.at});
    for (const auto column : silent_thermometers) sample.thermometers[column].value = silence("thermometer");
    if (thermometer_c) sample.thermometers[0].value = Celsius{*thermometer_c};
    sample.units.assign(units, {.count = {GyroCount{{106}, std::chrono::seconds(1)}, sample.at}});
    if (gyro_silent) sample.units[0].count.value = silence("gyro");
    if (gyro_garbled) sample.units[0].count.value = failure(FaultKind::corrupted, "gyro", "no frame in 350 bytes");
    for (const auto& value : analogue) sample.units[0].analogue.push_back({value, sample.at});
    return sample;
  }
  Result<void> send_set_point(Celsius target) override {
    if (chamber_.silent) return silence("chamber");
    if (chamber_.refuses) return failure(FaultKind::refused, chamber_.fault_place, "exception 4");
    chamber_.sent_c.push_back(target.value);
    if (chamber_.ignores) return failure(FaultKind::mismatch, "chamber", "reads otherwise than was written");
    chamber_.set_point_c = target.value;
    return {};
  }
  Result<void> send_set_point_immediately(Celsius target) override {
    ++chamber_.immediate_set_points;
    return send_set_point(target);
  }
  Result<void> switch_on(bool on) override {
    if (chamber_.silent) return silence("chamber");
    if (chamber_.refuses_off && !on) return failure(FaultKind::refused, "chamber stop", "no such command");
    switched.push_back(on);
    chamber_.on = on;
    chamber_.manual = chamber_.manual && chamber_.keeps_manual;
    return {};
  }

  std::vector<std::string> mismatched_instruments() const override { return others; }
  Duration overtime() const override { return over; }

  /// Unauthorised programs that use the instruments.
  std::vector<std::string> others;
  double uut_c = 20;
  std::optional<double> thermometer_c;  ///< first thermometer
  std::vector<std::size_t> silent_thermometers;
  bool gyro_silent = false;   ///< first unit under test
  bool gyro_garbled = false;  ///< first unit under test
  /// Time by which waits for the chamber exceed each tick.
  Duration over{};
  std::size_t units = 1;
  std::vector<bool> switched;
  /// Readings of the first unit's analogue inputs.
  std::vector<Result<double>> analogue;

 private:
  static tl::unexpected<Fault> silence(const char* who) {
    return failure(FaultKind::timeout, who, "no reply in 500 ms");
  }
  Result<ChamberState> state() const {
    if (chamber_.silent) return silence("chamber");
    ChamberState state{{chamber_.air_c}, {chamber_.set_point_c}};
    state.activity = chamber_.hides_mode  ? ChamberActivity::unknown
                     : chamber_.door_open ? ChamberActivity::door_open
                     : !chamber_.on       ? ChamberActivity::off
                     : chamber_.manual    ? ChamberActivity::not_following
                                          : ChamberActivity::running;
    state.must_stop = chamber_.must_stop;
    return state;
  }
  BenchChamber& chamber_;
};

class BenchRig final : public rig::Rig {
 public:
  explicit BenchRig(rig::RigFile file) : file_(std::move(file)), io_(chamber) { io_.units = file_.units.size(); }
  std::vector<Result<std::string>> query_instruments() override { return {}; }
  using rig::Rig::prepare;
  Result<std::vector<std::string>> prepare(const rig::Entrance&, const drivers::ChamberProgram*) override { return {}; }
  void set_unit_state(const UnitState&) override {}
  void let_pass(std::int64_t seconds) override {
    constexpr double kUutLag = 900;
    for (; seconds > 0; --seconds) {
      chamber.second();
      io_.uut_c += (chamber.air_c - io_.uut_c) / kUutLag;
      clock_.advance(std::chrono::seconds(1));
    }
  }
  const Clock& clock() const override { return clock_; }
  BenchIo& io() override { return io_; }
  const rig::RigFile& file() const override { return file_; }
  rig::RigFile& file() { return file_; }
  Result<drivers::SetPointRange> controller_limits() override { return drivers::SetPointRange{}; }
  bool is_as_found() const override { return true; }
  Duration will_start_utc() const override { return clock_.now().utc; }

  BenchChamber chamber;

 private:
  rig::RigFile file_;
  BenchIo io_;
  VirtualClock clock_;
};

/// Keeps all samples and events.
class BenchStore final : public record::Store {
 public:
  Result<void> append(const Sample& sample, std::span<const Event> more) override {
    samples.push_back(sample);
    for (const auto& event : more) (void)append_event(event);
    return {};
  }
  Result<void> append_gap(std::int64_t first, std::int64_t last, const std::string& cause) override {
    gap_seconds += last - first + 1;
    gap_cause = cause;
    return {};
  }
  Result<void> append_event(const Event& event) override {
    events.push_back(event);
    events.back().number = static_cast<std::int64_t>(events.size());
    alarms_.update({.slot = static_cast<std::int64_t>(samples.size()) - 1, .event = events.back()});
    return {};
  }
  Result<void> append_decision(const Event& event, std::span<const record::RunInfo::SegmentInfo> segments) override {
    add_block(info_, info_.segments.size(), segments, event.about.channel);
    return append_event(event);
  }
  Result<std::int64_t> sync() override { return static_cast<std::int64_t>(samples.size()) - 1; }
  bool settle(Duration) override { return true; }
  Result<void> finish() override { return {}; }
  void publish(const RunOverview&) override {}
  record::StoreHealth health() const override { return {}; }
  const record::Alarms& alarms() const override { return alarms_; }
  const record::RunInfo& info() const override { return info_; }
  Result<record::Record> read_back() override { return record::Record{}; }

  std::vector<Sample> samples;
  std::vector<Event> events;
  std::int64_t gap_seconds = 0;
  std::string gap_cause{};  ///< the latest

 private:
  record::Alarms alarms_;
  record::RunInfo info_;
};

/// Runs a profile on the bench, one second at a time.
class Bench {
 public:
  explicit Bench(const std::string& segments, const std::function<void(rig::RigFile&)>& change = {})
      : rig_(file(change)) {
    auto read = profile::parse_profile("schema = \"gyrotherm-profile/1\"\nname = \"p\"\n\n" + segments, "p.toml");
    EXPECT_TRUE(read) << text(read.error());
    profile_ = *read;
    harness_.emplace(profile_, rig_, store_);
  }

  void late(int seconds) { harness_->without_tick(seconds); }
  run::RunOutcome seconds(int count) { return harness_->seconds(count); }
  int until(RunState state, int most = 20'000) { return harness_->until(state, most); }
  [[nodiscard]] bool told(EventKind kind, const std::string& words) const { return count(kind, words) > 0; }
  [[nodiscard]] int count(EventKind kind, const std::string& words) const {
    int found = 0;
    for (const auto& event : store_.events)
      found += event.kind == kind && event.text.find(words) != std::string::npos ? 1 : 0;
    return found;
  }
  /// Returns the position in the profile.
  [[nodiscard]] ProfilePosition progress() const { return harness_->progress(); }

  BenchChamber& chamber() { return rig_.chamber; }
  BenchIo& instruments() { return rig_.io(); }
  run::RunController& run_controller() { return harness_->run_controller(); }
  BenchStore& record() { return store_; }

 private:
  static rig::RigFile file(const std::function<void(rig::RigFile&)>& change) {
    rig::RigFile file;
    file.units = {rig::UnitSettings{}};
    file.simulated = true;
    file.chamber_limits = {{-45}, {70}, {6}, {6}};
    file.safe_set_point = {20};
    file.safe_observe = {};
    if (change) change(file);
    return file;
  }

  BenchRig rig_;
  profile::Profile profile_;
  BenchStore store_;
  std::optional<RunHarness> harness_;
};

}  // namespace gyrotherm::tests
