// SPDX-License-Identifier: Apache-2.0
/// Tests that the values of an exchanged instrument are not recorded, and that nothing is sent to it.
#include "acquisition/io/identity_watch.hpp"

#include <gtest/gtest.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "acquisition/io/instrument_io.hpp"

namespace gyrotherm::io {
namespace {

using std::chrono_literals::operator""s;

/// The state of any of the instruments below, including its identity.
struct Wire {
  std::string serial = "111";
  std::optional<FaultKind> broken{};
  std::uint64_t breaks = 0;
  int asked = 0;
  /// The next call breaks the connection and reaches another instrument after it reconnects.
  bool swaps_within_a_call = false;

  Result<std::string> identify() {
    ++asked;
    if (broken) return failure(*broken, "wire", "broken");
    return "Maker Model " + serial;
  }
  [[nodiscard]] std::optional<Fault> call() {
    if (std::exchange(swaps_within_a_call, false)) swap();
    if (broken == FaultKind::disconnected) ++breaks;
    return broken ? std::optional(Fault{*broken, "wire", "broken"}) : std::nullopt;
  }
  void swap() {
    ++breaks;
    serial = "222";
  }
};

class WiredChamber final : public drivers::Chamber {
 public:
  explicit WiredChamber(Wire& wire) : wire_(wire) {}
  Result<std::string> identify() override { return wire_.identify(); }
  std::uint64_t breaks() const override { return wire_.breaks; }
  Result<ChamberState> read() override {
    if (auto fault = wire_.call()) return failure(*fault);
    return ChamberState{Celsius{20}, Celsius{20}};
  }
  Result<void> send_set_point(Celsius) override { return count_command(); }
  Result<void> start() override { return count_command(); }
  Result<void> stop() override { return count_command(); }
  Result<void> send_safe_state_unconfirmed(Celsius, bool off) override {
    ++unconfirmed;
    was_switched_off = was_switched_off || off;
    return {};
  }
  int commands = 0, unconfirmed = 0;
  bool was_switched_off = false;

 private:
  Result<void> count_command() {
    if (auto fault = wire_.call()) return failure(*fault);
    ++commands;
    return {};
  }
  Wire& wire_;
};

/// Thermometers and analogue inputs differ only in the type of their values.
template <class Kind, class Value>
class WiredInputs final : public Kind {
 public:
  explicit WiredInputs(Wire& wire) : wire_(wire) {}
  Result<std::string> identify() override { return wire_.identify(); }
  std::uint64_t breaks() const override { return wire_.breaks; }
  std::vector<Result<Value>> read() override {
    if (auto fault = wire_.call()) return {failure(*fault), failure(*fault)};
    return {Value{20}, Value{21}};
  }

 private:
  Wire& wire_;
};

class WiredGyro final : public drivers::Gyro {
 public:
  explicit WiredGyro(Wire& wire) : wire_(wire) {}
  Result<std::string> identify() override { return wire_.identify(); }
  std::uint64_t breaks() const override { return wire_.breaks; }
  Result<GyroCount> read(Duration expected) override {
    if (auto fault = wire_.call()) return failure(*fault);
    return GyroCount{{100}, expected};
  }

 private:
  Wire& wire_;
};

/// One instrument of each kind, each on its own wire.
struct Rack {
  Wire chamber_wire, thermometer_wire, gyro_wire, analogue_wire;
  WiredChamber chamber{chamber_wire};
  WiredInputs<drivers::Thermometer, Celsius> thermometer{thermometer_wire};
  WiredGyro gyro{gyro_wire};
  WiredInputs<drivers::AnalogueInputs, double> analogue{analogue_wire};
  VirtualClock clock;

  [[nodiscard]] Instruments instruments() {
    Instruments all{chamber, {{thermometer, {"A", "B"}}}, {{gyro, {{0, {0}}}}}, {{analogue, {}}}};
    all.analogue[0].channels = {{.unit = 0, .value = 0, .name = "u.a"}, {.unit = 0, .value = 1, .name = "u.b"}};
    all.chamber_known = {"chamber", "Maker Model 111"};
    all.thermometers[0].known = {"thermometer 1", "Maker Model 111"};
    all.gyros[0].known = {"gyro", "Maker Model 111"};
    all.analogue[0].known = {"analogue inputs 1", "Maker Model 111"};
    return all;
  }
};

using WireOf = Wire Rack::*;
constexpr WireOf kWires[] = {&Rack::chamber_wire, &Rack::thermometer_wire, &Rack::gyro_wire, &Rack::analogue_wire};
constexpr const char* kNames[] = {"Chamber", "Thermometer", "Gyro", "Analogue"};

/// Returns the fault of the instrument on that wire, or one per input if it has several.
std::vector<std::optional<Fault>> collect_faults(const Sample& sample, WireOf wire) {
  const auto of = [](const auto& reading) {
    return reading.value ? std::nullopt : std::optional<Fault>(reading.value.error());
  };
  if (wire == &Rack::chamber_wire) return {of(sample.chamber)};
  if (wire == &Rack::gyro_wire) return {of(sample.units[0].count)};
  if (wire == &Rack::analogue_wire) return {of(sample.units[0].analogue[0]), of(sample.units[0].analogue[1])};
  return {of(sample.thermometers[0]), of(sample.thermometers[1])};
}

void expect_all(const Sample& sample, WireOf wire, std::optional<FaultKind> kind) {
  for (const auto& fault : collect_faults(sample, wire))
    EXPECT_EQ(fault ? std::optional(fault->kind) : std::nullopt, kind) << (fault ? text(*fault) : "a value");
}

/// Tests each way to exchange an instrument with each kind of instrument.
class Exchanged : public ::testing::TestWithParam<WireOf> {
 protected:
  Rack rack_;
  std::unique_ptr<InstrumentIo> io_ = InstrumentIo::inline_calls(rack_.instruments());
  Wire& wire_ = rack_.*GetParam();
  std::int64_t slot_ = 0;

  Sample second() { return io_->read(slot_++, rack_.clock); }
  void expect_refused() {
    expect_all(second(), GetParam(), FaultKind::mismatch);
    ASSERT_EQ(io_->mismatched_instruments().size(), 1u);
    EXPECT_NE(io_->mismatched_instruments()[0].find("111"), std::string::npos) << "names the instrument of the run";
    EXPECT_NE(io_->mismatched_instruments()[0].find("222"), std::string::npos) << "names the instrument that answers";
  }
};

TEST_P(Exchanged, IsRefusedAfterSilence) {
  expect_all(second(), GetParam(), std::nullopt);
  wire_.broken = FaultKind::timeout;
  for (int i = 0; i < 9; ++i) second();
  wire_.broken.reset();
  wire_.serial = "222";
  expect_refused();
  expect_refused();
}

/// An exchange does not break the line of a serial instrument.
TEST_P(Exchanged, IsRefusedAfterProgramWasSuspended) {
  for (const std::int64_t pause : {0, 2}) {
    slot_ += pause;
    expect_all(second(), GetParam(), std::nullopt);
    EXPECT_EQ(wire_.asked, 0) << "late by " << pause << " s";
  }
  slot_ += 4;
  wire_.serial = "222";
  expect_refused();
  wire_.serial = "111";
  expect_all(second(), GetParam(), std::nullopt);
}

TEST_P(Exchanged, IsRefusedAfterBrokenLine) {
  second();
  wire_.broken = FaultKind::disconnected;
  expect_all(second(), GetParam(), FaultKind::disconnected);
  wire_.broken.reset();
  wire_.serial = "222";
  expect_refused();
}

TEST_P(Exchanged, IsRefusedWhenDriverReconnectsWithinCall) {
  second();
  wire_.swaps_within_a_call = true;
  expect_refused();
}

TEST_P(Exchanged, IsRefusedWhenItRefusesQuery) {
  second();
  ++wire_.breaks;
  wire_.broken = FaultKind::refused;
  expect_all(second(), GetParam(), FaultKind::mismatch);
  EXPECT_EQ(io_->mismatched_instruments().size(), 1u) << "an instrument of another vendor does not support the query";
}

TEST_P(Exchanged, IsAcceptedWhenFirstInstrumentReturns) {
  second();
  wire_.swap();
  expect_refused();
  ++wire_.breaks;
  wire_.serial = "111";
  expect_all(second(), GetParam(), std::nullopt);
  EXPECT_TRUE(io_->mismatched_instruments().empty());
}

TEST_P(Exchanged, IsNotQueriedAgainWhileLineHolds) {
  for (int i = 0; i < 100; ++i) second();
  EXPECT_EQ(wire_.asked, 0);
  wire_.broken = FaultKind::timeout;
  second();
  wire_.broken.reset();
  second();
  EXPECT_EQ(wire_.asked, 0) << "one lost answer is not a reconnection";
}

TEST_P(Exchanged, GivesNoValueWhileQueryFails) {
  second();
  ++wire_.breaks;
  wire_.broken = FaultKind::timeout;
  expect_all(second(), GetParam(), FaultKind::timeout);
  wire_.broken.reset();
  expect_all(second(), GetParam(), std::nullopt);
}

INSTANTIATE_TEST_SUITE_P(Instrument, Exchanged, ::testing::ValuesIn(kWires),
                         [](const auto& one) { return std::string(kNames[one.index]); });

TEST(ExchangedChamber, ReceivesNoCommand) {
  for (const bool with_workers : {false, true}) {
    Rack rack;
    const auto io = with_workers ? InstrumentIo::workers(rack.instruments(), {.patience = 10s})
                                 : InstrumentIo::inline_calls(rack.instruments());
    (void)io->read(0, rack.clock);
    ASSERT_TRUE(io->send_set_point(Celsius{20}));
    rack.chamber_wire.swap();
    for (int slot = 1; slot < 4; ++slot) {
      EXPECT_EQ(io->send_set_point(Celsius{50}).error().kind, FaultKind::mismatch);
      EXPECT_EQ(io->send_set_point_immediately(Celsius{20}).error().kind, FaultKind::mismatch);
      EXPECT_EQ(io->switch_on(true).error().kind, FaultKind::mismatch);
      EXPECT_EQ(io->switch_on(false).error().kind, FaultKind::mismatch);
      (void)io->read(slot, rack.clock);
    }
    EXPECT_EQ(rack.chamber.commands, 1);
  }
}

TEST(ExchangedChamber, ReceivesNoUnconfirmedCommand) {
  for (const bool with_workers : {false, true}) {
    Rack rack;
    const auto io = with_workers ? InstrumentIo::workers(rack.instruments(), {.patience = 10s})
                                 : InstrumentIo::inline_calls(rack.instruments());
    (void)io->read(0, rack.clock);
    rack.chamber_wire.swap();
    EXPECT_EQ(io->send_safe_set_point(Celsius{20}, true).error().kind, FaultKind::mismatch);
    rack.chamber_wire.broken = FaultKind::timeout;
    EXPECT_FALSE(io->send_safe_set_point(Celsius{20}, true)) << "the other chamber has answered before";
    EXPECT_EQ(rack.chamber.commands, 0);
    EXPECT_EQ(rack.chamber.unconfirmed, 0);
  }
}

TEST(UnreadableChamber, ReceivesSafeStateWithoutEvidence) {
  for (const bool with_workers : {false, true})
    for (const auto kind : {FaultKind::corrupted, FaultKind::timeout, FaultKind::disconnected}) {
      Rack rack;
      const auto io = with_workers ? InstrumentIo::workers(rack.instruments(), {.patience = 10s})
                                   : InstrumentIo::inline_calls(rack.instruments());
      (void)io->read(0, rack.clock);
      ASSERT_TRUE(io->send_safe_set_point(Celsius{20}, false));
      EXPECT_EQ(rack.chamber.unconfirmed, 0) << "the commands were confirmed";
      rack.chamber_wire.broken = kind;
      EXPECT_EQ(io->send_safe_set_point(Celsius{20}, true).error().kind, kind);
      EXPECT_EQ(rack.chamber.unconfirmed, 0) << "the last reading was good";
      for (int tries = 1; tries < 4; ++tries) {
        EXPECT_FALSE(io->read(tries, rack.clock).chamber.value);
        EXPECT_EQ(io->send_safe_set_point(Celsius{20}, true).error().kind, kind);
        EXPECT_EQ(rack.chamber.unconfirmed, tries);
        EXPECT_TRUE(rack.chamber.was_switched_off);
      }
      rack.chamber_wire.broken.reset();
      EXPECT_TRUE(io->send_safe_set_point(Celsius{20}, true));
    }
}

TEST(UnreadableChamber, ReceivesNothingIfItWasNeverIdentifiedOrRefuses) {
  Rack rack;
  auto instruments = rack.instruments();
  instruments.chamber_known = {};
  const auto io = InstrumentIo::inline_calls(std::move(instruments));
  rack.chamber_wire.broken = FaultKind::corrupted;
  EXPECT_FALSE(io->send_safe_set_point(Celsius{20}, true));
  EXPECT_EQ(rack.chamber.unconfirmed, 0);
  Rack refusing;
  const auto other = InstrumentIo::inline_calls(refusing.instruments());
  (void)other->read(0, refusing.clock);
  refusing.chamber_wire.broken = FaultKind::refused;
  EXPECT_FALSE(other->send_safe_set_point(Celsius{20}, true));
  EXPECT_EQ(refusing.chamber.unconfirmed, 0);
}

TEST(ExchangedChamber, IsNotComparedWithoutKnownIdentity) {
  Rack rack;
  auto instruments = rack.instruments();
  instruments.chamber_known = {};
  const auto io = InstrumentIo::inline_calls(std::move(instruments));
  rack.chamber_wire.swap();
  EXPECT_TRUE(io->read(0, rack.clock).chamber.value);
  EXPECT_EQ(rack.chamber_wire.asked, 0);
}

}  // namespace
}  // namespace gyrotherm::io
