// SPDX-License-Identifier: Apache-2.0
#include "acquisition/io/instrument_io.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <condition_variable>
#include <deque>
#include <functional>
#include <future>
#include <mutex>
#include <optional>
#include <stop_token>
#include <thread>
#include <utility>

#include "core/process.hpp"

namespace gyrotherm::io {
namespace {

using ThermometerReadings = Reading<std::vector<Result<Celsius>>>;

using AnalogueReadings = Reading<std::vector<Result<double>>>;

/// The result of reading one gyro.
struct GyroReading {
  Reading<GyroCount> count;
  FrameCount frames;
};

/// Combines an instrument's answer with the present instant.
template <class T>
Reading<T> stamp(const Clock& clock, Result<T> answer) {
  return {std::move(answer), clock.now()};
}

/// Returns the fault of the first input if no input answered. Returns null if at least one answered or there are no
/// inputs. An out-of-range fault is an answer.
template <class T>
const Fault* common_fault(const std::vector<Result<T>>& readings) {
  const auto answered = [](const Result<T>& one) { return one || one.error().kind == FaultKind::out_of_range; };
  return readings.empty() || std::ranges::any_of(readings, answered) ? nullptr : &readings.front().error();
}

/// Reads all inputs of one instrument, each with its own fault. Fails if another instrument answers.
template <class T, class Instrument>
Result<std::vector<Result<T>>> read_inputs(Instrument& instrument, IdentityWatch& watch) {
  if (auto same = watch.confirm(instrument); !same) return failure(std::move(same.error()));
  auto readings = instrument.read();
  const auto* fault = common_fault(readings);
  watch.note_result(fault);
  if (fault != nullptr) return readings;
  if (auto same = watch.confirm(instrument); !same) return failure(std::move(same.error()));
  return readings;
}

ThermometerReadings read_stamped(drivers::Thermometer& thermometer, IdentityWatch& watch, const Clock& clock) {
  return stamp<std::vector<Result<Celsius>>>(clock, read_inputs<Celsius>(thermometer, watch));
}

void append_readings(const ThermometerInputs& inputs, const ThermometerReadings& readings, Sample& into) {
  for (std::size_t i = 0; i < inputs.channels.size(); ++i) {
    if (!readings.value) {
      Fault fault = readings.value.error();
      fault.where = inputs.channels[i];
      into.thermometers.push_back({failure(fault), readings.at});
      continue;
    }
    assert(i < readings.value->size());
    into.thermometers.push_back({(*readings.value)[i], readings.at});
  }
}

GyroReading read_gyro(drivers::Gyro& gyro, IdentityWatch& watch, Duration interval, const Clock& clock) {
  auto count = stamp(clock, watch.guard(gyro, [&] { return gyro.read(interval); }));
  return {std::move(count), gyro.frames()};
}

/// Selects the part of an instrument's count that belongs to one unit.
GyroCount select_share(const GyroCount& count, const GyroInputs::Share& share) {
  GyroCount own{.pulses = {}, .interval = count.interval};
  for (const auto axis : share.axes) own.pulses.push_back(count.pulses[axis]);
  for (const auto value : share.values) own.values.push_back(count.values[value]);
  return own;
}

/// Distributes a gyro's reading to its units. Assigns the frame counts to the first of the units that share the line.
void append_readings(const GyroInputs& inputs, const GyroReading& reading, Sample& into) {
  for (const auto& share : inputs.shares) {
    auto& unit = into.units[share.unit];
    unit.count = reading.count.value ? Reading<GyroCount>{select_share(*reading.count.value, share), reading.count.at}
                                     : reading.count;
    if (&share == &inputs.shares.front()) unit.frames = reading.frames;
  }
}

AnalogueReadings read_stamped(drivers::AnalogueInputs& inputs, IdentityWatch& watch, const Clock& clock) {
  return stamp<std::vector<Result<double>>>(clock, read_inputs<double>(inputs, watch));
}

/// Returns the scaled reading of one channel. A fault of the whole instrument becomes a fault of the channel.
Result<double> scaled_value(const AnalogueChannels& inputs, std::size_t channel, const AnalogueReadings& readings) {
  const auto& [unit, value, name, scale, offset] = inputs.channels[channel];
  if (!readings.value) {
    Fault fault = readings.value.error();
    fault.where = name;
    return failure(fault);
  }
  assert(channel < readings.value->size());
  return (*readings.value)[channel].map([&](double reading) { return reading * scale + offset; });
}

void append_readings(const AnalogueChannels& inputs, const AnalogueReadings& readings, Sample& into) {
  for (std::size_t i = 0; i < inputs.channels.size(); ++i) {
    const auto& channel = inputs.channels[i];
    into.units[channel.unit].analogue[channel.value] = {scaled_value(inputs, i, readings), readings.at};
  }
}

using PowerReadings = Reading<drivers::SupplyReadings>;

/// Returns the readings of a supply that did not answer.
drivers::SupplyReadings failed_readings(const SupplyChannels& inputs, const Fault& fault) {
  return {.outputs = {inputs.outputs.size(), failure(fault)}};
}

/// Reads a supply, unless another instrument answers in its place.
PowerReadings read_stamped(const SupplyChannels& inputs, IdentityWatch& watch, const Clock& clock) {
  auto& supply = inputs.instrument;
  if (auto same = watch.confirm(supply); !same) return {failed_readings(inputs, same.error()), clock.now()};
  auto readings = supply.read();
  const auto* fault = common_fault(readings.outputs);
  watch.note_result(fault);
  if (fault == nullptr)
    if (auto same = watch.confirm(supply); !same) return {failed_readings(inputs, same.error()), clock.now()};
  return {std::move(readings), clock.now()};
}

/// Writes voltage and current of each output to the values of its units.
void append_readings(const SupplyChannels& inputs, const drivers::SupplyReadings& readings, Instant at, Sample& into) {
  for (std::size_t i = 0; i < inputs.outputs.size(); ++i)
    for (const auto& channel : inputs.outputs[i]) {
      const auto& reading = readings.outputs[i];
      const auto value = [&](double drivers::OutputReading::*part) -> Result<double> {
        if (reading) return (*reading).*part;
        Fault fault = reading.error();
        fault.where = channel.name;
        return failure(std::move(fault));
      };
      auto& analogue = into.units[channel.unit].analogue;
      analogue[channel.voltage] = {value(&drivers::OutputReading::voltage_v), at};
      analogue[channel.current] = {value(&drivers::OutputReading::current_a), at};
    }
}

/// The number of analogue values of each unit.
using UnitSizes = std::vector<std::size_t>;

UnitSizes count_analogue_values(const Instruments& instruments) {
  UnitSizes units;
  for (const auto& gyro : instruments.gyros) units.resize(units.size() + gyro.shares.size());
  for (const auto& inputs : instruments.analogue)
    for (const auto& channel : inputs.channels) ++units[channel.unit];
  for (const auto& supply : instruments.supplies)
    for (const auto& output : supply.outputs)
      for (const auto& channel : output) units[channel.unit] += 2;
  return units;
}

Sample empty_sample(std::int64_t slot, Instant at, const UnitSizes& units) {
  Sample sample;
  sample.slot = slot;
  sample.at = at;
  sample.units.resize(units.size());
  for (std::size_t i = 0; i < units.size(); ++i) sample.units[i].analogue.resize(units[i]);
  return sample;
}

/// A chamber that is compared with its known identity. Only one thread may call it.
class WatchedChamber {
 public:
  WatchedChamber(drivers::Chamber& chamber, KnownIdentity known) : chamber_(chamber), watch_(std::move(known)) {}

  Result<ChamberState> read() {
    return watch_.guard(chamber_, [&] { return chamber_.read(); });
  }
  Result<void> send_set_point(Celsius target) {
    return watch_.guard(chamber_, [&] { return chamber_.send_set_point(target); });
  }
  Result<void> send_set_point_immediately(Celsius target) {
    chamber_.end_rest();
    return watch_.guard_safe(chamber_, [&] { return chamber_.send_set_point_immediately(target); });
  }
  /// Sends the safe state without an answer if the chamber could not be read before, and the commands cannot be
  /// confirmed.
  Result<void> send_safe_set_point(Celsius target, bool off) {
    const bool was_read = watch_.last_fault().empty();
    auto sent = send_set_point_immediately(target);
    if (sent || was_read || !watch_.may_be_commanded_after(sent.error())) return sent;
    Fault fault = std::move(sent.error());
    const auto unconfirmed = chamber_.send_safe_state_unconfirmed(target, off);
    fault.what += unconfirmed ? "; the commands were sent without waiting for an answer"
                              : "; the commands could not be sent without waiting for an answer either";
    return failure(std::move(fault));
  }
  Result<void> switch_on(bool on) {
    if (on) return watch_.guard(chamber_, [&] { return chamber_.start(); });
    return watch_.guard_safe(chamber_, [&] { return chamber_.stop(); });
  }
  void request_check() { watch_.request_check(); }
  [[nodiscard]] const IdentityWatch& watch() const { return watch_; }

 private:
  drivers::Chamber& chamber_;
  IdentityWatch watch_;
};

/// The identity watches of all instruments, in the order of Instruments.
struct Watches {
  explicit Watches(const Instruments& instruments) : chamber(instruments.chamber, instruments.chamber_known) {
    for (const auto& one : instruments.thermometers) thermometers.emplace_back(one.known);
    for (const auto& one : instruments.gyros) gyros.emplace_back(one.known);
    for (const auto& one : instruments.analogue) analogue.emplace_back(one.known);
    for (const auto& one : instruments.supplies) supplies.emplace_back(one.known);
  }

  /// Notes the start of a second. If the program was suspended before that second, requests a comparison of every
  /// instrument's identity, because any instrument may have been exchanged.
  void begin_second(std::int64_t slot) {
    constexpr std::int64_t kSuspendedFor = 3;  // seconds; as kSilencesInDoubt
    const bool was_suspended = last_slot && slot - *last_slot > kSuspendedFor;
    last_slot = slot;
    if (!was_suspended) return;
    chamber.request_check();
    for (auto* watches : {&thermometers, &gyros, &analogue, &supplies})
      for (auto& watch : *watches) watch.request_check();
  }

  [[nodiscard]] std::vector<std::string> mismatched_instruments() const {
    std::vector<std::string> all{chamber.watch().mismatch_text()};
    for (const auto* watches : {&thermometers, &gyros, &analogue, &supplies})
      for (const auto& watch : *watches) all.push_back(watch.mismatch_text());
    std::erase(all, std::string());
    return all;
  }

  WatchedChamber chamber;
  std::deque<IdentityWatch> thermometers{}, gyros{}, analogue{}, supplies{};  // not movable
  std::optional<std::int64_t> last_slot{};
};

class InlineIo final : public InstrumentIo {
 public:
  InlineIo(Instruments instruments, InstrumentIoOptions options)
      : instruments_(std::move(instruments)),
        options_(options),
        units_(count_analogue_values(instruments_)),
        watches_(instruments_) {}

  Sample read(std::int64_t slot, const Clock& clock) override {
    watches_.begin_second(slot);
    Sample sample = empty_sample(slot, clock.now(), units_);
    sample.chamber = stamp(clock, watches_.chamber.read());
    for (std::size_t i = 0; i < instruments_.thermometers.size(); ++i) {
      const auto& inputs = instruments_.thermometers[i];
      append_readings(inputs, read_stamped(inputs.instrument, watches_.thermometers[i], clock), sample);
    }
    for (std::size_t i = 0; i < instruments_.gyros.size(); ++i) {
      const auto& inputs = instruments_.gyros[i];
      append_readings(inputs, read_gyro(inputs.instrument, watches_.gyros[i], options_.interval, clock), sample);
    }
    for (std::size_t i = 0; i < instruments_.analogue.size(); ++i) {
      const auto& inputs = instruments_.analogue[i];
      append_readings(inputs, read_stamped(inputs.instrument, watches_.analogue[i], clock), sample);
    }
    supplies_.clear();
    for (std::size_t i = 0; i < instruments_.supplies.size(); ++i) {
      auto readings = read_stamped(instruments_.supplies[i], watches_.supplies[i], clock);
      append_readings(instruments_.supplies[i], *readings.value, readings.at, sample);
      supplies_.push_back(std::move(*readings.value));
    }
    for (std::size_t unit = 0; instruments_.true_bias && unit < units_.size(); ++unit)
      sample.units[unit].true_bias = instruments_.true_bias(unit);
    return sample;
  }
  Result<void> send_set_point(Celsius target) override { return watches_.chamber.send_set_point(target); }
  Result<void> send_set_point_immediately(Celsius target) override {
    return watches_.chamber.send_set_point_immediately(target);
  }
  Result<void> send_safe_set_point(Celsius target, bool off) override {
    return watches_.chamber.send_safe_set_point(target, off);
  }
  Result<void> switch_on(bool on) override { return watches_.chamber.switch_on(on); }
  void demand_power(std::size_t supply, drivers::PowerDemand demand) override {
    instruments_.supplies[supply].instrument.demand(demand);
  }
  const std::vector<drivers::SupplyReadings>& supplies() const override { return supplies_; }
  std::vector<std::string> mismatched_instruments() const override { return watches_.mismatched_instruments(); }

 private:
  Instruments instruments_;
  InstrumentIoOptions options_;
  UnitSizes units_;
  Watches watches_;
  std::vector<drivers::SupplyReadings> supplies_;
};

/// A thread that makes the calls of one instrument. A blocked call therefore delays no other instrument. Jobs run one
/// after the other, and at most one waits. The destructor waits for the active job, which ends by the deadline of its
/// instrument call.
class Worker {
 public:
  Worker() : thread_([this](const std::stop_token& stop) { serve(stop); }) {}

  /// Posts a job and returns the future of its result. If the caller drops the future, the result is dropped too. The
  /// previous job must have begun or been withdrawn.
  template <class Job>
  [[nodiscard]] auto post(Job job) {
    auto task = std::make_shared<std::packaged_task<decltype(job())()>>(std::move(job));
    auto answer = task->get_future();
    enqueue([task] { (*task)(); });
    return answer;
  }

  /// Returns whether post() may be called: no job waits.
  [[nodiscard]] bool can_post() {
    const std::lock_guard lock(mutex_);
    return !waiting_;
  }

  /// Removes the waiting job. Returns false if it has already begun.
  bool withdraw() {
    const std::lock_guard lock(mutex_);
    return std::exchange(waiting_, nullptr) != nullptr;
  }

  /// Returns the time since the active job began; zero if there is none.
  [[nodiscard]] Duration busy_for() {
    const std::lock_guard lock(mutex_);
    return began_ ? Duration(std::chrono::steady_clock::now() - *began_) : Duration{};
  }

 private:
  void enqueue(std::function<void()> job) {
    {
      const std::lock_guard lock(mutex_);
      assert(!waiting_ && "the job before has neither begun nor been withdrawn");
      waiting_ = std::move(job);
    }
    posted_.notify_one();
  }

  void serve(const std::stop_token& stop) {
    block_signals();
    for (;;) {
      std::function<void()> job;
      {
        std::unique_lock lock(mutex_);
        if (!posted_.wait(lock, stop, [this] { return waiting_ != nullptr; })) return;
        job = std::exchange(waiting_, nullptr);
        began_ = std::chrono::steady_clock::now();
      }
      job();
      const std::lock_guard lock(mutex_);
      began_.reset();
    }
  }

  std::mutex mutex_;
  std::condition_variable_any posted_;
  std::function<void()> waiting_;
  /// The start of the active job.
  std::optional<std::chrono::steady_clock::time_point> began_;
  std::jthread thread_;  ///< last: it uses the members above
};

std::string to_ms(Duration d) {
  return fmt::format("{} ms", std::chrono::duration_cast<std::chrono::milliseconds>(d).count());
}

class WorkerIo final : public InstrumentIo {
 public:
  WorkerIo(Instruments instruments, InstrumentIoOptions options)
      : instruments_(std::move(instruments)),
        options_(options),
        units_(count_analogue_values(instruments_)),
        watches_(instruments_),
        thermometers_(instruments_.thermometers.size()),
        gyros_(instruments_.gyros.size()),
        analogue_(instruments_.analogue.size()),
        supply_workers_(instruments_.supplies.size()),
        frames_(instruments_.gyros.size()) {}

  Sample read(std::int64_t slot, const Clock& clock) override {
    watches_.begin_second(slot);
    const Instant now = clock.now();
    clock_ = &clock;
    read_at_ = now.since_start;
    overtime_ = {};
    std::optional<std::future<Reading<ChamberState>>> chamber;
    if (chamber_.can_post())  // the safe set point has priority
      chamber = chamber_.post([this, &clock] { return stamp(clock, watches_.chamber.read()); });
    std::vector<std::future<ThermometerReadings>> thermometers;
    for (std::size_t i = 0; i < thermometers_.size(); ++i)
      thermometers.push_back(thermometers_[i].post([this, &clock, i] {
        return read_stamped(instruments_.thermometers[i].instrument, watches_.thermometers[i], clock);
      }));
    std::vector<std::future<GyroReading>> gyros;
    for (std::size_t i = 0; i < gyros_.size(); ++i)
      gyros.push_back(gyros_[i].post([this, &clock, i] {
        return read_gyro(instruments_.gyros[i].instrument, watches_.gyros[i], options_.interval, clock);
      }));
    std::vector<std::future<AnalogueReadings>> analogue;
    for (std::size_t i = 0; i < analogue_.size(); ++i)
      analogue.push_back(analogue_[i].post([this, &clock, i] {
        return read_stamped(instruments_.analogue[i].instrument, watches_.analogue[i], clock);
      }));
    std::vector<std::future<PowerReadings>> supplies;
    for (std::size_t i = 0; i < supply_workers_.size(); ++i)
      supplies.push_back(supply_workers_[i].post(
          [this, &clock, i] { return read_stamped(instruments_.supplies[i], watches_.supplies[i], clock); }));

    Sample sample = empty_sample(slot, now, units_);
    sample.chamber =
        accept_if_in_time(chamber ? await(chamber_, *chamber, clock, now) : std::nullopt,
                          {.title = "chamber", .last_fault = watches_.chamber.watch().last_fault()}, clock, now);
    for (std::size_t i = 0; i < thermometers_.size(); ++i) {
      auto readings = await(thermometers_[i], thermometers[i], clock, now);
      const LateInstrument late{.title = "thermometer", .last_fault = watches_.thermometers[i].last_fault()};
      append_readings(instruments_.thermometers[i], accept_if_in_time(std::move(readings), late, clock, now), sample);
    }
    for (std::size_t i = 0; i < gyros_.size(); ++i) {
      auto reading = await(gyros_[i], gyros[i], clock, now);
      if (reading) frames_[i] = reading->frames;
      auto count = reading ? std::optional(std::move(reading->count)) : std::nullopt;
      append_readings(instruments_.gyros[i],
                      GyroReading{accept_if_in_time(std::move(count), {.title = "gyro"}, clock, now), frames_[i]},
                      sample);
    }
    for (std::size_t i = 0; i < analogue_.size(); ++i) {
      auto readings = await(analogue_[i], analogue[i], clock, now);
      append_readings(instruments_.analogue[i],
                      accept_if_in_time(std::move(readings), {.title = "analogue input"}, clock, now), sample);
    }
    supplies_.clear();
    for (std::size_t i = 0; i < supply_workers_.size(); ++i) {
      auto readings = await(supply_workers_[i], supplies[i], clock, now);
      auto accepted = accept_if_in_time(
          std::move(readings), {.title = "supply", .last_fault = watches_.supplies[i].last_fault()}, clock, now);
      supplies_.push_back(accepted.value ? std::move(*accepted.value)
                                         : failed_readings(instruments_.supplies[i], accepted.value.error()));
      append_readings(instruments_.supplies[i], supplies_.back(), accepted.at, sample);
    }
    return sample;
  }

  void demand_power(std::size_t supply, drivers::PowerDemand demand) override {
    instruments_.supplies[supply].instrument.demand(demand);
  }
  const std::vector<drivers::SupplyReadings>& supplies() const override { return supplies_; }

  Result<void> send_set_point(Celsius target) override {
    const auto send = [this, target] { return watches_.chamber.send_set_point(target); };
    return run_command(fmt::format("set point {:g} °C", target.value), send, remaining_tick());
  }

  std::vector<std::string> mismatched_instruments() const override { return watches_.mismatched_instruments(); }

  Duration stuck_for() override {
    const auto busy = chamber_.busy_for();
    return instruments_.chamber_line ? std::min(busy, instruments_.chamber_line->time_since_note()) : busy;
  }

  Result<void> send_set_point_immediately(Celsius target) override {
    const auto send = [this, target] { return watches_.chamber.send_set_point_immediately(target); };
    return run_command(fmt::format("set point {:g} °C", target.value), send, options_.patience);
  }

  Result<void> send_safe_set_point(Celsius target, bool off) override {
    const auto within = remaining_tick();
    const auto take_result = [this](Duration longest) -> std::optional<Result<void>> {
      if (!urgent_ || urgent_->wait_for(longest) != std::future_status::ready) return {};
      return std::exchange(urgent_, std::nullopt)->get();
    };
    auto former = take_result({});
    if (former && *former) return *former;
    if (!urgent_ && chamber_.can_post())
      urgent_ = chamber_.post([this, target, off] { return watches_.chamber.send_safe_set_point(target, off); });
    if (auto result = take_result(within)) return std::move(*result);
    if (former) return std::move(*former);
    return failure(
        FaultKind::timeout, "chamber",
        fmt::format("set point {:g} °C {} within {}, the time left in its second; {}", target.value,
                    chamber_.can_post() ? "not confirmed" : "not sent", to_ms(within),
                    chamber_.can_post() ? "the chamber may have taken it" : "it is the chamber's next call") +
            received_text(watches_.chamber.watch().last_fault()));
  }

  Duration overtime() const override { return overtime_; }

  Result<void> switch_on(bool on) override {
    return run_command(
        on ? "start" : "stop", [this, on] { return watches_.chamber.switch_on(on); }, remaining_tick());
  }

 private:
  /// An instrument whose reading may be late, and the fault of its last call that ended.
  struct LateInstrument {
    const char* title;
    std::string last_fault{};
  };

  /// Runs a command in the chamber's worker and waits for it. `what` is the name of the command in a fault.
  Result<void> run_command(const std::string& what, std::function<Result<void>()> job, Duration within) {
    const auto busy_fault = [&] {
      return failure(FaultKind::timeout, "chamber",
                     fmt::format("{} not sent: the chamber was still busy after {}", what, to_ms(within)));
    };
    if (!chamber_.can_post()) return busy_fault();
    const auto began = spent();
    auto done = chamber_.post(std::move(job));
    const auto ended = done.wait_for(within);
    if (began < options_.interval) overtime_ = std::max(overtime_, spent() - options_.interval);
    if (ended == std::future_status::ready) return done.get();
    const bool never_begun = chamber_.withdraw();
    if (never_begun) return busy_fault();
    return failure(FaultKind::timeout, "chamber",
                   fmt::format("{} not confirmed within {}, the time left in its second; the chamber may have taken it",
                               what, to_ms(within)));
  }

  /// Returns the time since the last read began.
  [[nodiscard]] Duration spent() const {
    return clock_ != nullptr ? clock_->now().since_start - read_at_ : options_.interval;
  }

  /// Returns the time that remains of the present tick.
  [[nodiscard]] Duration remaining_tick() const {
    constexpr Duration kMinRemaining = std::chrono::milliseconds(20);
    const auto so_far = spent();
    if (so_far >= options_.interval) return options_.patience;  // outside a tick
    return std::clamp(options_.tick - so_far, kMinRemaining, options_.patience);
  }

  /// Returns the worker's answer to the job posted at `since`, or nothing if it does not arrive in time.
  template <class T>
  std::optional<T> await(Worker& worker, std::future<T>& answer, const Clock& clock, Instant since) {
    const Duration left = options_.patience - (clock.now().since_start - since.since_start);
    if (answer.wait_for(std::max(left, Duration{})) == std::future_status::ready) return answer.get();
    worker.withdraw();
    return std::nullopt;
  }

  /// Replaces a missing answer by the fault timeout. Also replaces an answer that belongs to a later second, as can
  /// happen after the machine was suspended.
  template <class T>
  Reading<T> accept_if_in_time(std::optional<Reading<T>> reading, const LateInstrument& instrument, const Clock& clock,
                               Instant since) const {
    const bool good = reading && reading->at.since_start - since.since_start <= options_.interval;
    return good ? std::move(*reading) : late_reading<T>(instrument, clock);
  }

  /// Makes the reading of an instrument that did not answer in time.
  template <class T>
  Reading<T> late_reading(const LateInstrument& instrument, const Clock& clock) const {
    return stamp<T>(clock, failure(FaultKind::timeout, instrument.title,
                                   fmt::format("{}{}{}", kStillBusy, to_ms(options_.patience),
                                               received_text(instrument.last_fault))));
  }

  Instruments instruments_;
  InstrumentIoOptions options_;
  UnitSizes units_;
  /// Each watch is used by one worker.
  Watches watches_;
  Worker chamber_;
  std::vector<drivers::SupplyReadings> supplies_;
  std::deque<Worker> thermometers_, gyros_, analogue_, supply_workers_;  // a worker is not movable
  /// The last known count of each gyro.
  std::vector<FrameCount> frames_;
  /// The clock and the start of the last read.
  const Clock* clock_ = nullptr;
  Duration read_at_{};
  Duration overtime_{};
  /// The safe set point that was sent last, until its result is taken.
  std::optional<std::future<Result<void>>> urgent_;
};

}  // namespace

std::unique_ptr<InstrumentIo> InstrumentIo::inline_calls(Instruments instruments, InstrumentIoOptions options) {
  return std::make_unique<InlineIo>(std::move(instruments), options);
}

std::unique_ptr<InstrumentIo> InstrumentIo::workers(Instruments instruments, InstrumentIoOptions options) {
  return std::make_unique<WorkerIo>(std::move(instruments), options);
}

}  // namespace gyrotherm::io
