// SPDX-License-Identifier: Apache-2.0
#include "acquisition/io/instrument_io.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <thread>

namespace gyrotherm::io {
namespace {

using std::chrono_literals::operator""ms;
using std::chrono_literals::operator""s;
using std::chrono::steady_clock;

/// A line that can be blocked: calls wait while it is closed.
class Gate {
 public:
  void close() { set(false); }
  void open() { set(true); }
  void pass() {
    std::unique_lock lock(mutex_);
    ++arrived_;
    changed_.notify_all();
    changed_.wait(lock, [this] { return open_; });
  }
  void wait_for_arrivals(int count) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return arrived_ >= count; });
  }

 private:
  void set(bool open) {
    const std::lock_guard lock(mutex_);
    open_ = open;
    changed_.notify_all();
  }
  std::mutex mutex_;
  std::condition_variable changed_;
  bool open_ = true;
  int arrived_ = 0;
};

/// A chamber with increasing answers, so that a late one differs from a fresh one.
class GatedChamber final : public drivers::Chamber {
 public:
  Result<std::string> identify() override { return "gated"; }
  Result<ChamberState> read() override {
    gate.pass();
    return ChamberState{Celsius{static_cast<double>(++reads)}, Celsius{set_point.load()}};
  }
  Result<void> send_set_point(Celsius target) override {
    command_gate.pass();
    set_point = target.value;
    return {};
  }
  Result<void> start() override { return {}; }
  Result<void> stop() override { return {}; }
  Gate gate;
  Gate command_gate;
  std::atomic<int> reads{};
  std::atomic<double> set_point{20};
};

class GatedThermometer final : public drivers::Thermometer {
 public:
  Result<std::string> identify() override { return "gated"; }
  std::vector<Result<Celsius>> read() override {
    gate.pass();
    const double base = 100.0 * ++reads;
    return {Celsius{base}, failure(FaultKind::out_of_range, "input 2", "open"), Celsius{base + 2}};
  }
  Gate gate;
  std::atomic<int> reads{};
};

class GatedGyro final : public drivers::Gyro {
 public:
  Result<GyroCount> read(Duration expected) override {
    gate.pass();
    return GyroCount{{++reads}, expected};
  }
  Gate gate;
  std::atomic<int> reads{};
};

/// Two inputs. The second one fails on command.
class GatedInputs final : public drivers::AnalogueInputs {
 public:
  Result<std::string> identify() override { return "gated"; }
  std::vector<Result<double>> read() override {
    gate.pass();
    const double reading = ++reads;
    if (open_loop) return {reading, failure(FaultKind::out_of_range, "input 2", "burn_out")};
    return {reading, 2 * reading};
  }
  Gate gate;
  std::atomic<bool> open_loop{};
  std::atomic<int> reads{};
};

/// A rig with two thermometers. Only the first input of the second one is used.
struct Bench {
  GatedChamber chamber;
  GatedThermometer first;
  GatedThermometer second;
  GatedGyro gyro;
  VirtualClock clock;
  Instruments instruments{chamber, {{first, {"A", "B", "C"}}, {second, {"shell"}}}, {{gyro, {{0, {0}}}}}};
};

void expect_complete(const Sample& sample) {
  ASSERT_TRUE(sample.chamber.value && sample.units[0].count.value);
  ASSERT_EQ(sample.thermometers.size(), 4u);
  EXPECT_EQ(sample.thermometers[0].value, Celsius{100});
  EXPECT_EQ(sample.thermometers[1].value.error().kind, FaultKind::out_of_range);
  EXPECT_EQ(sample.thermometers[2].value, Celsius{102});
  EXPECT_EQ(sample.thermometers[3].value, Celsius{100});
  EXPECT_EQ(sample.units[0].count.value->interval, 1s);
}

TEST(InstrumentIo, ReadsEveryInstrumentOnceInline) {
  Bench bench;
  bench.clock.advance(7s);
  const auto io = InstrumentIo::inline_calls(bench.instruments);
  const Sample sample = io->read(7, bench.clock);
  expect_complete(sample);
  EXPECT_EQ(sample.slot, 7);
  EXPECT_EQ(sample.at.since_start, 7s);
  EXPECT_EQ(sample.units[0].count.at.since_start, 7s);
}

TEST(InstrumentIo, ReadsEveryInstrumentOnceWithWorkers) {
  Bench bench;
  const auto io = InstrumentIo::workers(bench.instruments, {.patience = 10s});
  expect_complete(io->read(0, bench.clock));
  EXPECT_EQ(io->read(1, bench.clock).chamber.value->air, Celsius{2});
}

/// A patience that suffices for a busy machine, unless an instrument hangs.
constexpr auto kPatient = 2s;

TEST(InstrumentIo, ReportsSilentInstrumentInItsOwnColumns) {
  Bench bench;
  bench.first.gate.close();
  const auto io = InstrumentIo::workers(bench.instruments, {.patience = kPatient});
  const Sample sample = io->read(0, bench.clock);
  for (const std::size_t i : {0, 1, 2}) {
    const Fault& fault = sample.thermometers[i].value.error();
    EXPECT_EQ(fault.kind, FaultKind::timeout);
    EXPECT_EQ(fault.where, std::string(1, static_cast<char>('A' + i)));
    EXPECT_EQ(fault.what, "still busy after 2000 ms");
  }
  EXPECT_TRUE(sample.thermometers[3].value && sample.chamber.value && sample.units[0].count.value);
  bench.first.gate.open();
}

/// Reads until the call of a chamber that hangs is active. Returns the time at which it was.
steady_clock::time_point read_until_stuck(Bench& bench, InstrumentIo& io) {
  bench.chamber.gate.close();
  static_cast<void>(io.read(0, bench.clock));
  bench.chamber.gate.wait_for_arrivals(1);
  return steady_clock::now();
}

void expect_free(InstrumentIo& io) {
  for (const auto end = steady_clock::now() + 60s; io.stuck_for() != Duration{} && steady_clock::now() < end;)
    std::this_thread::sleep_for(1ms);
  EXPECT_EQ(io.stuck_for(), Duration{});
}

TEST(InstrumentIo, MeasuresTimeWithoutProgressOfChamberCall) {
  Bench bench;
  const auto io = InstrumentIo::workers(bench.instruments, {.patience = 50ms});
  EXPECT_EQ(io->stuck_for(), Duration{});
  const auto began = steady_clock::now();
  const auto stuck = read_until_stuck(bench, *io);
  std::this_thread::sleep_for(50ms);
  const auto before = steady_clock::now();
  const auto stuck_for = io->stuck_for();
  EXPECT_GE(stuck_for, before - stuck) << "the hanging call is active";
  EXPECT_LE(stuck_for, steady_clock::now() - began);
  bench.chamber.gate.open();
  static_cast<void>(io->read(1, bench.clock));
  expect_free(*io);
}

TEST(InstrumentIo, DoesNotReportProgressingCallAsStuck) {
  Bench bench;
  drivers::LineActivity line;
  bench.instruments.chamber_line = &line;
  const auto io = InstrumentIo::workers(bench.instruments, {.patience = 50ms});
  const auto stuck = read_until_stuck(bench, *io);
  std::this_thread::sleep_for(50ms);
  const auto before = steady_clock::now();
  EXPECT_GE(io->stuck_for(), before - stuck);
  const auto noted = steady_clock::now();
  line.note();
  const auto stuck_for = io->stuck_for();
  EXPECT_LE(stuck_for, steady_clock::now() - noted) << "on a line that loses most requests";
  bench.chamber.gate.open();
}

TEST(InstrumentIo, DoesNotReportHangingThermometerAsStuck) {
  Bench bench;
  const auto io = InstrumentIo::workers(bench.instruments, {.patience = 50ms});
  bench.first.gate.close();
  static_cast<void>(io->read(0, bench.clock));
  bench.first.gate.wait_for_arrivals(1);
  expect_free(*io);
  bench.first.gate.open();
}

TEST(InstrumentIo, NeverUsesLateAnswerForLaterSecond) {
  Bench bench;
  bench.chamber.gate.close();
  bench.gyro.gate.close();
  const auto io = InstrumentIo::workers(bench.instruments, {.patience = kPatient});
  const Sample missed = io->read(0, bench.clock);
  EXPECT_EQ(missed.chamber.value.error().kind, FaultKind::timeout);
  EXPECT_EQ(missed.units[0].count.value.error().kind, FaultKind::timeout);
  bench.chamber.gate.open();
  bench.gyro.gate.open();
  const Sample next = io->read(1, bench.clock);
  ASSERT_TRUE(next.chamber.value && next.units[0].count.value);
  EXPECT_EQ(next.chamber.value->air, Celsius{2}) << "1 was the late answer";
  EXPECT_EQ(next.units[0].count.value->pulses[0], 2);
}

/// A clock that jumps while its thermometer is read, as if the machine had been suspended.
class SuspendingClock final : public Clock, public drivers::Thermometer {
 public:
  Result<std::string> identify() override { return "slept"; }
  Instant now() const override { return {elapsed_ms.load() * 1ms, elapsed_ms.load() * 1ms}; }
  std::vector<Result<Celsius>> read() override {
    elapsed_ms += stands_still_ms;
    return {Celsius{24}};
  }
  std::atomic<std::int64_t> elapsed_ms{};
  int stands_still_ms = 0;
};

TEST(InstrumentIo, DropsAnswerFromAfterSuspension) {
  Bench bench;
  SuspendingClock machine;
  const auto io = InstrumentIo::workers({bench.chamber, {{machine, {"A"}}}, {{bench.gyro, {{0, {0}}}}}});
  machine.stands_still_ms = 700;
  EXPECT_EQ(io->read(0, machine).thermometers[0].value, Celsius{24});
  machine.stands_still_ms = 24'000;
  const auto late = io->read(1, machine).thermometers[0].value;
  ASSERT_FALSE(late);
  EXPECT_EQ(late.error().kind, FaultKind::timeout);
}

/// A gyro that is read while the machine is suspended.
class SuspendedGyro final : public drivers::Gyro {
 public:
  explicit SuspendedGyro(SuspendingClock& machine) : machine_(machine) {}
  Result<GyroCount> read(Duration expected) override {
    machine_.elapsed_ms += machine_.stands_still_ms;
    return GyroCount{{7}, expected};
  }

 private:
  SuspendingClock& machine_;
};

TEST(InstrumentIo, DropsCountFromAfterSuspension) {
  Bench bench;
  SuspendingClock machine;
  SuspendedGyro gyro(machine);
  const auto io = InstrumentIo::workers({bench.chamber, {}, {{gyro, {{0, {0}}}}}});
  machine.stands_still_ms = 700;
  ASSERT_TRUE(io->read(0, machine).units[0].count.value);
  machine.stands_still_ms = 24'000;
  const auto late = io->read(1, machine).units[0].count.value;
  ASSERT_FALSE(late);
  EXPECT_EQ(late.error().kind, FaultKind::timeout);
}

TEST(InstrumentIo, QueriesBusyInstrumentOnceWhenItReturns) {
  Bench bench;
  bench.gyro.gate.close();
  const auto io = InstrumentIo::workers(bench.instruments, {.patience = 30ms});
  for (int slot = 0; slot < 4; ++slot)
    EXPECT_EQ(io->read(slot, bench.clock).units[0].count.value.error().kind, FaultKind::timeout);
  EXPECT_EQ(bench.gyro.reads, 0);
  bench.gyro.gate.open();
  bench.gyro.gate.wait_for_arrivals(1);
  const auto patient = io->read(4, bench.clock);
  EXPECT_TRUE(!patient.units[0].count.value || patient.units[0].count.value->pulses[0] == 2)
      << "three withdrawn reads were never made";
}

TEST(InstrumentIo, SendsCommandInlineAndWithWorkers) {
  Bench bench;
  const auto inline_sampler = InstrumentIo::inline_calls(bench.instruments);
  ASSERT_TRUE(inline_sampler->send_set_point(Celsius{-40}));
  EXPECT_EQ(bench.chamber.set_point, -40);
  const auto io = InstrumentIo::workers(bench.instruments, {.patience = 10s});
  ASSERT_TRUE(io->send_set_point(Celsius{70}));
  EXPECT_EQ(io->read(0, bench.clock).chamber.value->set_point, Celsius{70});
}

TEST(InstrumentIo, WithdrawsCommandThatCouldNotBegin) {
  Bench bench;
  bench.chamber.gate.close();
  const auto io = InstrumentIo::workers(bench.instruments, {.patience = 900ms});
  EXPECT_FALSE(io->read(0, bench.clock).chamber.value);
  const auto sent = io->send_set_point(Celsius{70});
  ASSERT_FALSE(sent);
  EXPECT_EQ(text(sent.error()), "chamber: set point 70 °C not sent: the chamber was still busy after 900 ms");
  bench.chamber.gate.open();
  EXPECT_EQ(io->read(1, bench.clock).chamber.value->set_point, Celsius{20});
}

TEST(InstrumentIo, KeepsSafeSetPointAsNextCallOfBusyChamber) {
  Bench bench;
  const auto io = InstrumentIo::workers(bench.instruments, {.patience = 20ms});
  bench.chamber.gate.close();
  (void)io->read(0, bench.clock);
  EXPECT_EQ(io->send_safe_set_point(Celsius{5}, false).error().kind, FaultKind::timeout);
  bench.clock.advance(1s);
  const auto late = io->read(1, bench.clock);
  EXPECT_EQ(late.chamber.value.error().kind, FaultKind::timeout);
  EXPECT_FALSE(io->switch_on(false)) << "is not sent before the safe set point";
  EXPECT_FALSE(io->send_safe_set_point(Celsius{5}, false));
  bench.chamber.gate.open();
  bench.chamber.command_gate.wait_for_arrivals(1);
  while (bench.chamber.set_point != 5) std::this_thread::yield();
  bench.clock.advance(1s);
  Result<void> sent = io->send_safe_set_point(Celsius{5}, false);
  for (int tries = 0; !sent && tries < 100; ++tries) sent = io->send_safe_set_point(Celsius{5}, false);
  EXPECT_TRUE(sent) << "the result of the call is reported later";
  EXPECT_EQ(bench.chamber.reads, 1) << "the second reading had not begun";
}

TEST(InstrumentIo, LimitsSafeSetPointToRemainderOfTick) {
  Bench bench;
  const SteadyClock clock;
  const auto io = InstrumentIo::workers(bench.instruments, {.patience = 300ms, .tick = 320ms});
  bench.chamber.gate.close();
  const auto began = clock.now().since_start;
  (void)io->read(0, clock);
  EXPECT_FALSE(io->send_safe_set_point(Celsius{5}, false));
  EXPECT_LT(clock.now().since_start - began, 600ms) << "not the whole patience after the reading";
  EXPECT_EQ(io->overtime(), 0s);
  bench.chamber.gate.open();
}

TEST(InstrumentIo, MeasuresOvertimeOfCommands) {
  Bench bench;
  const SteadyClock clock;
  const auto io = InstrumentIo::workers(bench.instruments, {.interval = 100ms, .patience = 300ms, .tick = 90ms});
  (void)io->read(0, clock);
  EXPECT_EQ(io->overtime(), 0s);
  bench.chamber.command_gate.close();
  EXPECT_FALSE(io->send_set_point_immediately(Celsius{5}));
  EXPECT_GT(io->overtime(), 100ms);
  bench.chamber.command_gate.open();
  (void)io->read(1, clock);
  EXPECT_EQ(io->overtime(), 0s);
}

TEST(InstrumentIo, ReportsUnconfirmedCommandAsUnknown) {
  Bench bench;
  bench.chamber.command_gate.close();
  const auto io = InstrumentIo::workers(bench.instruments, {.patience = kPatient});
  const auto sent = io->send_set_point(Celsius{70});
  ASSERT_FALSE(sent);
  EXPECT_EQ(sent.error().kind, FaultKind::timeout);
  EXPECT_EQ(sent.error().what,
            "set point 70 °C not confirmed within 2000 ms, the time left in its second; the chamber may have taken it");
  bench.chamber.command_gate.open();
}

TEST(InstrumentIo, LimitsCommandToItsTick) {
  Bench bench;
  bench.chamber.command_gate.close();
  const auto io = InstrumentIo::workers(bench.instruments);
  EXPECT_TRUE(io->read(0, bench.clock).chamber.value);
  bench.clock.advance(480ms);  // an instrument was slow
  EXPECT_EQ(io->send_set_point(Celsius{70}).error().what,
            "set point 70 °C not confirmed within 500 ms, the time left in its second; the chamber may have taken it");
  bench.chamber.command_gate.open();
}

/// Two units on one line, each with an analogue value.
struct AnalogueBench : Bench {
  GatedInputs inputs;
  AnalogueBench() {
    instruments.gyros[0].shares = {{.unit = 0, .axes = {0}}, {.unit = 1, .axes = {0}}};
    instruments.analogue.push_back({inputs,
                                    {{.unit = 1, .value = 0, .name = "u2.current", .scale = 10, .offset = 0.5},
                                     {.unit = 0, .value = 0, .name = "u1.current"}}});
  }
};

void expect_read(const Sample& sample) {
  for (const auto& unit : sample.units) {
    EXPECT_TRUE(unit.count.value);
    ASSERT_EQ(unit.analogue.size(), 1u);
  }
  EXPECT_EQ(sample.units[0].analogue[0].value, 2.0);
  EXPECT_EQ(sample.units[1].analogue[0].value, 10.5) << "scaled";
}

TEST(InstrumentIo, AssignsAnalogueValuesToUnits) {
  AnalogueBench inlined;
  expect_read(InstrumentIo::inline_calls(inlined.instruments)->read(0, inlined.clock));
  AnalogueBench worked;
  expect_read(InstrumentIo::workers(worked.instruments, {.patience = 10s})->read(0, worked.clock));
}

TEST(InstrumentIo, ReportsOpenAnalogueInputInItsOwnChannel) {
  AnalogueBench bench;
  bench.inputs.open_loop = true;
  const auto sample = InstrumentIo::inline_calls(bench.instruments)->read(0, bench.clock);
  ASSERT_FALSE(sample.units[0].analogue[0].value);
  EXPECT_EQ(sample.units[0].analogue[0].value.error().what, "burn_out");
  EXPECT_TRUE(sample.units[1].analogue[0].value && sample.units[0].count.value && sample.chamber.value);
}

TEST(InstrumentIo, ReportsSilentAnalogueInputsInTheirOwnChannels) {
  AnalogueBench bench;
  bench.inputs.gate.close();
  const auto io = InstrumentIo::workers(bench.instruments, {.patience = kPatient});
  const auto sample = io->read(0, bench.clock);
  EXPECT_EQ(text(sample.units[1].analogue[0].value.error()), "u2.current: still busy after 2000 ms");
  EXPECT_EQ(sample.units[0].analogue[0].value.error().where, "u1.current");
  EXPECT_TRUE(sample.units[0].count.value && sample.units[1].count.value && sample.chamber.value);
  bench.inputs.gate.open();
}

TEST(InstrumentIo, KeepsAnalogueChannelsWhenGyroIsSilent) {
  AnalogueBench bench;
  bench.gyro.gate.close();
  const auto io = InstrumentIo::workers(bench.instruments, {.patience = 50ms});
  const auto sample = io->read(0, bench.clock);
  EXPECT_FALSE(sample.units[0].count.value || sample.units[1].count.value);
  EXPECT_EQ(sample.units[0].analogue[0].value, 2.0);
  EXPECT_EQ(sample.units[1].analogue[0].value, 10.5);
  bench.gyro.gate.open();
}

}  // namespace
}  // namespace gyrotherm::io
