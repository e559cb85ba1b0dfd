// SPDX-License-Identifier: Apache-2.0
#include "drivers/thermometer/mcc_usb_temp.hpp"

#include <fmt/chrono.h>

#include <algorithm>
#include <cassert>
#include <utility>

#include "drivers/line/deadline.hpp"
#include "drivers/thermometer/placed_readings.hpp"

namespace gyrotherm::drivers {

namespace {

enum class SensorCode : std::uint8_t { rtd, thermistor, thermocouple, semiconductor };
enum class Excitation : std::uint8_t { off, ten_ua, two_hundred_ten_ua };

template <class Code>
MccRequest set(std::uint8_t input, MccItem item, Code code) {
  return mcc_set_item(input, item, static_cast<std::uint8_t>(code));
}

std::vector<MccRequest> setup(std::uint8_t input, const MccRtd& rtd) {
  return {set(input, MccItem::sensor, SensorCode::rtd),
          set(input, MccItem::connection, rtd.wires),
          set(input, MccItem::excitation, Excitation::two_hundred_ten_ua),
          set(input, MccItem::gain, 2),
          mcc_set_item(input, MccItem::coefficient_0, rtd.r0_ohm),
          mcc_set_item(input, MccItem::coefficient_1, rtd.a_per_k),
          mcc_set_item(input, MccItem::coefficient_2, rtd.b_per_k2),
          mcc_set_item(input, MccItem::coefficient_3, rtd.c_per_k4)};
}

std::vector<MccRequest> setup(std::uint8_t input, const MccThermistor& thermistor) {
  return {set(input, MccItem::sensor, SensorCode::thermistor),
          set(input, MccItem::connection, thermistor.wires),
          set(input, MccItem::excitation, Excitation::ten_ua),
          set(input, MccItem::gain, 0),
          mcc_set_item(input, MccItem::coefficient_0, thermistor.a),
          mcc_set_item(input, MccItem::coefficient_1, thermistor.b),
          mcc_set_item(input, MccItem::coefficient_2, thermistor.c)};
}

std::vector<MccRequest> setup(std::uint8_t input, const MccSemiconductor& semiconductor) {
  return {set(input, MccItem::sensor, SensorCode::semiconductor),
          set(input, MccItem::connection, semiconductor.differential),
          set(input, MccItem::excitation, Excitation::off),
          set(input, MccItem::gain, 1),
          mcc_set_item(input, MccItem::coefficient_0, semiconductor.offset),
          mcc_set_item(input, MccItem::coefficient_1, semiconductor.scale)};
}

std::vector<MccRequest> setup(std::uint8_t input, const MccThermocouple& thermocouple) {
  return {set(input, MccItem::sensor, SensorCode::thermocouple), set(input, MccItem::excitation, Excitation::off),
          set(input, MccItem::thermocouple, thermocouple.type)};
}

constexpr TemperatureRange kOther{{-273.15}, {200}};
TemperatureRange range(const MccRtd&) { return {{-200}, {850}}; }
TemperatureRange range(const MccThermistor&) { return kOther; }
TemperatureRange range(const MccSemiconductor&) { return kOther; }
TemperatureRange range(const MccThermocouple& thermocouple) {
  switch (thermocouple.type) {
    case MccThermocoupleType::j: return {{-210}, {1200}};
    case MccThermocoupleType::k: return {{-270}, {1372}};
    case MccThermocoupleType::t: return {{-270}, {400}};
    case MccThermocoupleType::e: return {{-270}, {1000}};
    case MccThermocoupleType::r:
    case MccThermocoupleType::s: return {{-50}, {1768.1}};
    case MccThermocoupleType::b: return {{0}, {1820}};
    case MccThermocoupleType::n: return {{-270}, {1300}};
  }
  return kMccWidest;
}

}  // namespace

std::vector<MccRequest> mcc_setup(std::uint8_t input, const MccSensor& sensor) {
  assert(input < kMccInputs);
  return std::visit([input](const auto& kind) { return setup(input, kind); }, sensor);
}

TemperatureRange mcc_range(const MccSensor& sensor) {
  return std::visit([](const auto& kind) { return range(kind); }, sensor);
}

namespace {

using Bytes = std::vector<std::uint8_t>;

constexpr std::size_t kLeastReport = 2;  ///< hidraw refuses shorter ones
constexpr Duration kStatusEvery = std::chrono::seconds(1);
constexpr int kMostStatusReads = 12;

class MccUsbTemp final : public Thermometer {
 public:
  MccUsbTemp(std::unique_ptr<HidReports> reports, std::string place, MccOptions options)
      : reports_(std::move(reports)), place_(std::move(place)), options_(std::move(options)) {
    for (std::size_t input = 0; input < kMccInputs; ++input)
      if (options_.sensors[input]) ranges_[input] = mcc_range(*options_.sensors[input]);
  }

  Result<std::string> identify() override;
  std::vector<Result<Celsius>> read() override;

 private:
  enum class Stage { unknown, calibrating, ready };
  using Report = std::vector<std::byte>;

  [[nodiscard]] Result<void> send(const MccRequest& request);
  [[nodiscard]] Result<void> wait_for_silence();
  [[nodiscard]] Result<Report> ask(const MccRequest& request);
  [[nodiscard]] Result<Bytes> ask_bytes(const MccRequest& request);
  [[nodiscard]] Result<bool> holds(const MccRequest& set_item);
  [[nodiscard]] Result<int> set_what_differs();
  [[nodiscard]] Result<void> begin();
  [[nodiscard]] Result<void> finish_calibration();
  [[nodiscard]] Result<void> make_ready();
  [[nodiscard]] Result<std::string> wait_until_ready();
  const Fault& seen(const Fault& fault);

  std::unique_ptr<HidReports> reports_;
  std::string place_;
  MccOptions options_;
  MccRanges ranges_ = mcc_widest_ranges();
  Stage stage_ = Stage::unknown;
  bool reply_may_come_late_ = false;
};

/// What was unplugged may come back as another.
const Fault& MccUsbTemp::seen(const Fault& fault) {
  if (fault.kind == FaultKind::disconnected) stage_ = Stage::unknown;
  return fault;
}

Result<void> MccUsbTemp::send(const MccRequest& request) {
  auto report = encode_mcc_request(request);
  report.resize(std::max(report.size(), kLeastReport));
  return reports_->write(report);
}

/// Throws away what older questions left.
Result<void> MccUsbTemp::wait_for_silence() {
  std::array<std::byte, kMccLongestReport> stale;
  const Deadline deadline(options_.within, options_.clock);
  do {
    const auto size = reports_->read(stale, reply_may_come_late_ ? deadline.left() : Duration::zero());
    if (size) continue;
    if (size.error().kind != FaultKind::timeout) return failure(size.error());
    reply_may_come_late_ = false;
    return {};
  } while (!deadline.over());
  return failure(FaultKind::corrupted, "", "reports come that nobody asked for");
}

/// The report that answers; reports with another number are passed over.
Result<MccUsbTemp::Report> MccUsbTemp::ask(const MccRequest& request) {
  if (auto silent = wait_for_silence(); !silent) return failure(std::move(silent.error()));
  if (auto sent = send(request); !sent) return failure(std::move(sent.error()));
  reply_may_come_late_ = true;
  Report report(kMccLongestReport);
  const Deadline deadline(options_.within, options_.clock);
  do {
    const auto size = reports_->read(report, deadline.left());
    if (!size) return failure(size.error());
    if (*size == 0 || report[0] != static_cast<std::byte>(request.command)) continue;
    reply_may_come_late_ = false;
    report.resize(*size);
    return report;
  } while (!deadline.over());
  return failure(FaultKind::timeout, "", "only other reports came");
}

Result<Bytes> MccUsbTemp::ask_bytes(const MccRequest& request) {
  const auto report = ask(request);
  if (!report) return failure(report.error());
  return decode_mcc_bytes(request, *report);
}

/// Whether the item that `set_item` sets has that value already.
Result<bool> MccUsbTemp::holds(const MccRequest& set_item) {
  const auto& arguments = set_item.arguments;
  const auto found = ask_bytes({MccCommand::read_item, {arguments[0], arguments[1]}});
  if (!found) return failure(found.error());
  return std::ranges::equal(*found, std::span(arguments).subspan(2));
}

/// How many items had to be set.
Result<int> MccUsbTemp::set_what_differs() {
  int count = 0;
  for (std::uint8_t input = 0; input < kMccInputs; ++input) {
    if (!options_.sensors[input]) continue;
    for (const auto& item : mcc_setup(input, *options_.sensors[input])) {
      const auto same = holds(item);
      if (!same) return failure(same.error());
      if (*same) continue;
      if (auto sent = send(item); !sent) return failure(std::move(sent.error()));
      ++count;
    }
  }
  return count;
}

Result<void> MccUsbTemp::begin() {
  if (auto opened = reports_->open(); !opened) return failure(std::move(opened.error()));
  const auto set = set_what_differs();
  if (!set) return failure(set.error());
  if (*set > 0)
    if (auto sent = send(mcc_request(MccCommand::calibrate)); !sent) return sent;
  stage_ = Stage::calibrating;
  return {};
}

/// Whether it is over, and what was set is still there.
Result<void> MccUsbTemp::finish_calibration() {
  const auto status = ask_bytes(mcc_request(MccCommand::read_status));
  if (!status) return failure(status.error());
  if (mcc_calibrating(status->front())) return failure(FaultKind::timeout, "", "it calibrates itself");
  stage_ = Stage::unknown;
  for (std::uint8_t input = 0; input < kMccInputs; ++input) {
    if (!options_.sensors[input]) continue;
    for (const auto& item : mcc_setup(input, *options_.sensors[input])) {
      const auto same = holds(item);
      if (!same) return failure(same.error());
      if (!*same)
        return failure(FaultKind::mismatch, fmt::format("input {}", input),
                       fmt::format("item {:02X} does not keep what it is set to", item.arguments[1]));
    }
  }
  stage_ = Stage::ready;
  return {};
}

Result<void> MccUsbTemp::make_ready() {
  if (stage_ == Stage::unknown)
    if (auto begun = begin(); !begun) return begun;
  return stage_ == Stage::calibrating ? finish_calibration() : Result<void>{};
}

Result<std::string> MccUsbTemp::wait_until_ready() {
  std::array<std::byte, kMccLongestReport> stray;
  for (int reads = 1;; ++reads) {
    auto ready = make_ready();
    if (ready) return reports_->open();
    if (stage_ != Stage::calibrating || reads == kMostStatusReads) return failure(std::move(ready.error()));
    (void)reports_->read(stray, kStatusEvery);  // a pause: nothing is expected
  }
}

Result<std::string> MccUsbTemp::identify() {
  auto who = wait_until_ready();
  if (!who) return failure(at_instrument(place_, seen(who.error())));
  const auto date = ask_bytes(mcc_read_calibration_date());
  if (!date) return failure(at_instrument(place_, seen(date.error())));
  const auto calibrated = decode_mcc_date(*date);
  if (!calibrated) return "MCC " + *who;
  return fmt::format("MCC {}, calibrated {:%F}", *who, std::chrono::sys_seconds(calibrated->time_since_epoch()));
}

std::vector<Result<Celsius>> MccUsbTemp::read() {
  const auto scan = mcc_scan(0, kMccInputs - 1);
  auto readings = make_ready().and_then([&] { return ask(scan); }).and_then([&](const Report& report) {
    return decode_mcc_temperatures(scan, report, ranges_);
  });
  if (!readings) seen(readings.error());
  return readings_at(place_, kMccInputs, std::move(readings));
}

}  // namespace

std::unique_ptr<Thermometer> make_mcc_usb_temp(std::unique_ptr<HidReports> reports, std::string place,
                                               MccOptions options) {
  return std::make_unique<MccUsbTemp>(std::move(reports), std::move(place), std::move(options));
}

}  // namespace gyrotherm::drivers
