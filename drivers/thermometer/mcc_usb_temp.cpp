// SPDX-License-Identifier: Apache-2.0
#include "drivers/thermometer/mcc_usb_temp.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <optional>
#include <string>
#include <utility>

#include "core/deadline.hpp"
#include "drivers/checksum.hpp"
#include "drivers/thermometer/placed_readings.hpp"

namespace gyrotherm::drivers {
namespace {

/// Items with a number below this one are shared by the two inputs of a converter.
constexpr unsigned kSharedItems = 0x10;
constexpr unsigned kItems = 0x1C;
/// Maximum number of memory bytes per request, for each of the two microcontrollers.
constexpr std::size_t kLongestMemory[] = {62, 60};
constexpr std::size_t kMemory = 256;

/// Sizes of a command's arguments and of its reply, in bytes.
struct Layout {
  MccCommand command;
  std::size_t arguments;
  /// Minimum size. Replies to scan, read_memory and read_item may be longer.
  std::size_t reply;
};
constexpr Layout kLayouts[] = {
    {MccCommand::read_input, 2, 4},  {MccCommand::scan, 3, 4},     {MccCommand::read_memory, 4, 1},
    {MccCommand::read_status, 0, 1}, {MccCommand::set_item, 3, 0}, {MccCommand::read_item, 2, 1},
    {MccCommand::calibrate, 0, 0},
};

const Layout* find_layout(std::uint8_t command) {
  const auto* found = std::ranges::find(kLayouts, static_cast<MccCommand>(command), &Layout::command);
  return found == std::end(kLayouts) ? nullptr : found;
}

/// Returns whether an item is a number: the reference, measured currents and voltages, and coefficients.
bool is_number_item(unsigned item) { return (item >= 0x04 && item <= 0x0A) || (item >= 0x14 && item < kItems); }
bool is_known_item(unsigned item) { return item <= 0x0A || (item >= kSharedItems && item < kItems); }

std::uint8_t item_number(std::uint8_t input, MccItem item) {
  const auto number = static_cast<unsigned>(item);
  return static_cast<std::uint8_t>(number < kSharedItems ? number : number + input % 2);
}

void append(std::vector<std::uint8_t>& bytes, float number) {
  const auto bits = std::bit_cast<std::uint32_t>(number);
  for (int shift = 0; shift < 32; shift += 8) bytes.push_back(static_cast<std::uint8_t>(bits >> shift));
}

std::string report_name(MccCommand command) { return fmt::format("report {:02X}", static_cast<unsigned>(command)); }

std::string input_name(std::uint8_t input) {
  if (input >= kMccColdJunction0) return fmt::format("CJC{}", input - kMccColdJunction0);
  return fmt::format("input {}", input);
}

/// Returns the reason for refusing the arguments of a request, or nothing.
std::optional<std::string> find_argument_error(const MccRequest& request) {
  const auto& a = request.arguments;
  const auto units = [](unsigned code) { return code <= 1; };
  const auto input = [](unsigned code) { return code < kMccInputs; };
  switch (request.command) {
    case MccCommand::read_input:
      if (!input(a[0]) && a[0] != kMccColdJunction0 && a[0] != kMccColdJunction1)
        return fmt::format("there is no input {:02X}", a[0]);
      if (!units(a[1])) return fmt::format("there is no temperature unit {}", a[1]);
      break;
    case MccCommand::scan:
      if (!input(a[1]) || a[0] > a[1]) return fmt::format("inputs {} to {} cannot be scanned", a[0], a[1]);
      if (!units(a[2])) return fmt::format("there is no temperature unit {}", a[2]);
      break;
    case MccCommand::read_memory: {
      const std::size_t address = a[0] | a[1] << 8, micro = a[2], count = a[3];
      if (micro > 1 || count == 0 || count > kLongestMemory[micro] || address + count > kMemory)
        return fmt::format("{} bytes of memory {} from {:02X} cannot be read", count, micro, address);
      break;
    }
    case MccCommand::set_item:
    case MccCommand::read_item:
      if (a[0] >= kMccInputs / 2 || !is_known_item(a[1])) return fmt::format("there is no item {} {:02X}", a[0], a[1]);
      break;
    default: break;
  }
  return std::nullopt;
}

Result<Celsius> to_celsius(float number, std::uint8_t input, const MccRanges& ranges) {
  const auto invalid = [&](const char* what) {
    return failure(FaultKind::out_of_range, input_name(input), fmt::format("{} ({})", what, number));
  };
  const float whole = std::trunc(number);
  if (whole == kMccOpen) return invalid("open thermocouple");
  if (whole == kMccNotReady) return invalid("not ready");
  if (whole == kMccDisabled) return invalid("disabled, or floating-point error");
  return check_range(input < kMccInputs ? ranges[input] : kMccMaxRange, {number}, input_name(input));
}

}  // namespace

MccRequest mcc_request(MccCommand command, std::initializer_list<std::uint8_t> arguments) {
  MccRequest request{command, arguments};
  assert(decode_mcc_request(encode_mcc_request(request)) == request);
  return request;
}

MccRequest mcc_read_input(std::uint8_t input, MccUnits units) {
  return mcc_request(MccCommand::read_input, {input, static_cast<std::uint8_t>(units)});
}

MccRequest mcc_scan(std::uint8_t first, std::uint8_t last, MccUnits units) {
  return mcc_request(MccCommand::scan, {first, last, static_cast<std::uint8_t>(units)});
}

MccRequest mcc_read_memory(std::uint8_t address, std::uint8_t count) {
  return mcc_request(MccCommand::read_memory, {address, 0, 0, count});
}

MccRequest mcc_read_item(std::uint8_t input, MccItem item) {
  return mcc_request(MccCommand::read_item, {static_cast<std::uint8_t>(input / 2), item_number(input, item)});
}

MccRequest mcc_set_item(std::uint8_t input, MccItem item, std::uint8_t value) {
  return mcc_request(MccCommand::set_item, {static_cast<std::uint8_t>(input / 2), item_number(input, item), value});
}

MccRequest mcc_set_item(std::uint8_t input, MccItem item, float value) {
  MccRequest request{MccCommand::set_item, {static_cast<std::uint8_t>(input / 2), item_number(input, item)}};
  assert(is_number_item(request.arguments[1]));
  append(request.arguments, value);
  return request;
}

std::vector<std::byte> encode_mcc_request(const MccRequest& request) {
  return encode_mcc_bytes(request.command, request.arguments);
}

Result<MccRequest> decode_mcc_request(std::span<const std::byte> report) {
  const auto* layout = report.empty() ? nullptr : find_layout(byte_at(report, 0));
  if (layout == nullptr) return failure(FaultKind::corrupted, "report", "not a command of a USB-TEMP");
  auto length = layout->arguments;
  if (layout->command == MccCommand::set_item && report.size() > 2 && is_number_item(byte_at(report, 2)))
    length += sizeof(float) - 1;
  if (report.size() <= length || report.size() > kMccLongestReport)
    return failure(FaultKind::corrupted, report_name(layout->command),
                   fmt::format("{} bytes, expected {} to {}", report.size(), length + 1, kMccLongestReport));
  MccRequest request{layout->command, {}};
  for (std::size_t i = 1; i <= length; ++i) request.arguments.push_back(byte_at(report, i));
  if (std::ranges::any_of(report.subspan(length + 1), [](std::byte padding) { return padding != std::byte{0}; }))
    return failure(FaultKind::corrupted, report_name(layout->command), "the report is longer than its arguments");
  if (const auto error = find_argument_error(request))
    return failure(FaultKind::refused, report_name(layout->command), *error);
  return request;
}

std::size_t mcc_reply_length(const MccRequest& request) {
  const auto& a = request.arguments;
  if (request.command == MccCommand::scan) return sizeof(float) * (1u + a[1] - a[0]);
  if (request.command == MccCommand::read_memory) return a[3];
  if (request.command == MccCommand::read_item && is_number_item(a[1])) return sizeof(float);
  const auto* layout = find_layout(static_cast<std::uint8_t>(request.command));
  assert(layout != nullptr);
  return layout->reply;
}

Result<std::vector<std::uint8_t>> decode_mcc_bytes(const MccRequest& request, std::span<const std::byte> report) {
  const auto length = mcc_reply_length(request);
  const auto corrupted = [&](std::string what) {
    return failure(FaultKind::corrupted, report_name(request.command), std::move(what));
  };
  if (report.empty()) return corrupted("empty");
  if (const auto id = byte_at(report, 0); static_cast<MccCommand>(id) != request.command)
    return corrupted(fmt::format("unexpected report {:02X}", id));
  if (report.size() <= length || report.size() > kMccLongestReport)
    return corrupted(fmt::format("{} bytes, expected {} to {}", report.size(), length + 1, kMccLongestReport));
  std::vector<std::uint8_t> bytes;
  bytes.reserve(length);
  for (const auto byte : report.subspan(1, length)) bytes.push_back(std::to_integer<std::uint8_t>(byte));
  return bytes;
}

Result<std::vector<float>> decode_mcc_numbers(const MccRequest& request, std::span<const std::byte> report) {
  assert(mcc_reply_length(request) % sizeof(float) == 0);
  return decode_mcc_bytes(request, report).map([](const std::vector<std::uint8_t>& bytes) {
    std::vector<float> numbers;
    for (std::size_t i = 0; i + sizeof(float) <= bytes.size(); i += sizeof(float)) {
      std::uint32_t bits = 0;
      for (std::size_t k = sizeof(float); k-- > 0;) bits = bits << 8 | bytes[i + k];
      numbers.push_back(std::bit_cast<float>(bits));
    }
    return numbers;
  });
}

Result<std::vector<Result<Celsius>>> decode_mcc_temperatures(const MccRequest& request,
                                                             std::span<const std::byte> report,
                                                             const MccRanges& ranges) {
  assert(request.command == MccCommand::scan || request.command == MccCommand::read_input);
  assert(request.arguments.back() == static_cast<std::uint8_t>(MccUnits::celsius));
  return decode_mcc_numbers(request, report).map([&](const std::vector<float>& numbers) {
    std::vector<Result<Celsius>> temperatures;
    temperatures.reserve(numbers.size());
    for (auto input = request.arguments.front(); const float number : numbers)
      temperatures.push_back(to_celsius(number, input++, ranges));
    return temperatures;
  });
}

Result<std::chrono::local_seconds> decode_mcc_date(std::span<const std::uint8_t> bytes) {
  using std::chrono::hours, std::chrono::minutes, std::chrono::seconds, std::chrono::local_days;
  if (bytes.size() == 6) {
    const std::chrono::year_month_day day{std::chrono::year(2000 + bytes[0]), std::chrono::month(bytes[1]),
                                          std::chrono::day(bytes[2])};
    if (day.ok() && bytes[3] < 24 && bytes[4] < 60 && bytes[5] < 60)
      return local_days(day) + hours(bytes[3]) + minutes(bytes[4]) + seconds(bytes[5]);
  }
  return failure(FaultKind::corrupted, "calibration date",
                 fmt::format("{:02X} is not a valid time", fmt::join(bytes, " ")));
}

std::vector<std::byte> encode_mcc_bytes(MccCommand command, std::span<const std::uint8_t> bytes) {
  std::vector<std::byte> report{static_cast<std::byte>(command)};
  for (const auto byte : bytes) report.push_back(std::byte{byte});
  return report;
}

std::vector<std::byte> encode_mcc_numbers(MccCommand command, std::span<const float> numbers) {
  std::vector<std::uint8_t> bytes;
  for (const float number : numbers) append(bytes, number);
  return encode_mcc_bytes(command, bytes);
}

namespace {

enum class SensorCode : std::uint8_t { rtd, thermistor, thermocouple, semiconductor };
enum class Excitation : std::uint8_t { off, ten_ua, two_hundred_ten_ua };

template <class Code>
MccRequest make_set_request(std::uint8_t input, MccItem item, Code code) {
  return mcc_set_item(input, item, static_cast<std::uint8_t>(code));
}

std::vector<MccRequest> make_setup(std::uint8_t input, const MccRtd& rtd) {
  return {make_set_request(input, MccItem::sensor, SensorCode::rtd),
          make_set_request(input, MccItem::connection, rtd.wires),
          make_set_request(input, MccItem::excitation, Excitation::two_hundred_ten_ua),
          make_set_request(input, MccItem::gain, 2),
          mcc_set_item(input, MccItem::coefficient_0, rtd.r0_ohm),
          mcc_set_item(input, MccItem::coefficient_1, rtd.a_per_k),
          mcc_set_item(input, MccItem::coefficient_2, rtd.b_per_k2),
          mcc_set_item(input, MccItem::coefficient_3, rtd.c_per_k4)};
}

std::vector<MccRequest> make_setup(std::uint8_t input, const MccThermistor& thermistor) {
  return {make_set_request(input, MccItem::sensor, SensorCode::thermistor),
          make_set_request(input, MccItem::connection, thermistor.wires),
          make_set_request(input, MccItem::excitation, Excitation::ten_ua),
          make_set_request(input, MccItem::gain, 0),
          mcc_set_item(input, MccItem::coefficient_0, thermistor.a),
          mcc_set_item(input, MccItem::coefficient_1, thermistor.b),
          mcc_set_item(input, MccItem::coefficient_2, thermistor.c)};
}

std::vector<MccRequest> make_setup(std::uint8_t input, const MccSemiconductor& semiconductor) {
  return {make_set_request(input, MccItem::sensor, SensorCode::semiconductor),
          make_set_request(input, MccItem::connection, semiconductor.differential),
          make_set_request(input, MccItem::excitation, Excitation::off),
          make_set_request(input, MccItem::gain, 1),
          mcc_set_item(input, MccItem::coefficient_0, semiconductor.offset),
          mcc_set_item(input, MccItem::coefficient_1, semiconductor.scale)};
}

std::vector<MccRequest> make_setup(std::uint8_t input, const MccThermocouple& thermocouple) {
  return {make_set_request(input, MccItem::sensor, SensorCode::thermocouple),
          make_set_request(input, MccItem::excitation, Excitation::off),
          make_set_request(input, MccItem::thermocouple, thermocouple.type)};
}

constexpr TemperatureRange kOtherRange{{-273.15}, {200}};
TemperatureRange range(const MccRtd&) { return {{-200}, {850}}; }
TemperatureRange range(const MccThermistor&) { return kOtherRange; }
TemperatureRange range(const MccSemiconductor&) { return kOtherRange; }
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
  return kMccMaxRange;
}

}  // namespace

std::vector<MccRequest> mcc_setup(std::uint8_t input, const MccSensor& sensor) {
  assert(input < kMccInputs);
  return std::visit([input](const auto& kind) { return make_setup(input, kind); }, sensor);
}

TemperatureRange mcc_range(const MccSensor& sensor) {
  return std::visit([](const auto& kind) { return range(kind); }, sensor);
}

namespace {

using Bytes = std::vector<std::uint8_t>;

constexpr std::size_t kMinReportSize = 2;  ///< hidraw refuses shorter ones
constexpr Duration kStatusPeriod = std::chrono::seconds(1);
constexpr int kMaxStatusReads = 12;

class MccUsbTemp final : public Thermometer {
 public:
  MccUsbTemp(std::unique_ptr<HidReports> reports, std::string place, MccOptions options)
      : reports_(std::move(reports)), place_(std::move(place)), options_(options) {
    for (std::size_t input = 0; input < kMccInputs; ++input)
      if (options_.sensors[input]) ranges_[input] = mcc_range(*options_.sensors[input]);
  }

  Result<std::string> identify() override {
    auto identity = wait_until_ready();
    if (!identity) return failure(add_location(place_, note_fault(identity.error())));
    const auto date = query_bytes(mcc_read_calibration_date());
    if (!date) return failure(add_location(place_, note_fault(date.error())));
    const auto calibrated = decode_mcc_date(*date);
    if (!calibrated) return "MCC " + *identity;
    return fmt::format("MCC {}, calibrated {:%F}", *identity, std::chrono::sys_seconds(calibrated->time_since_epoch()));
  }

  std::vector<Result<Celsius>> read() override {
    const auto scan = mcc_scan(0, kMccInputs - 1);
    auto readings = make_ready().and_then([&] { return query(scan); }).and_then([&](const Report& report) {
      return decode_mcc_temperatures(scan, report, ranges_);
    });
    if (!readings) note_fault(readings.error());
    return add_locations(place_, kMccInputs, std::move(readings));
  }

 private:
  enum class Stage { unknown, calibrating, ready };
  using Report = std::vector<std::byte>;

  [[nodiscard]] Result<void> send(const MccRequest& request) {
    auto report = encode_mcc_request(request);
    report.resize(std::max(report.size(), kMinReportSize));
    return reports_->write(report);
  }

  /// Discards replies to earlier requests until no report arrives.
  [[nodiscard]] Result<void> wait_for_silence() {
    std::array<std::byte, kMccLongestReport> stale;
    const Deadline deadline(options_.within, options_.clock);
    do {
      const auto size = reports_->read(stale, reply_may_come_late_ ? deadline.left() : Duration::zero());
      if (size) continue;
      if (size.error().kind != FaultKind::timeout) return failure(size.error());
      reply_may_come_late_ = false;
      return {};
    } while (!deadline.has_passed());
    return failure(FaultKind::corrupted, "", "the device sends unrequested reports");
  }

  /// Sends a request and returns its reply; other reports are ignored.
  [[nodiscard]] Result<Report> query(const MccRequest& request) {
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
    } while (!deadline.has_passed());
    return failure(FaultKind::timeout, "", "only other reports arrived");
  }

  [[nodiscard]] Result<Bytes> query_bytes(const MccRequest& request) {
    return query(request).and_then([&](const Report& report) { return decode_mcc_bytes(request, report); });
  }

  /// Returns whether the instrument's item already has the value in the request `set_item`.
  [[nodiscard]] Result<bool> has_value(const MccRequest& set_item) {
    const auto& arguments = set_item.arguments;
    const auto found = query_bytes({MccCommand::read_item, {arguments[0], arguments[1]}});
    if (!found) return failure(found.error());
    return std::ranges::equal(*found, std::span(arguments).subspan(2));
  }

  /// Sets the items that differ from the required settings. Returns their number.
  [[nodiscard]] Result<int> set_differing_items() {
    int count = 0;
    for (std::uint8_t input = 0; input < kMccInputs; ++input) {
      if (!options_.sensors[input]) continue;
      for (const auto& item : mcc_setup(input, *options_.sensors[input])) {
        const auto is_set = has_value(item);
        if (!is_set) return failure(is_set.error());
        if (*is_set) continue;
        if (auto sent = send(item); !sent) return failure(std::move(sent.error()));
        ++count;
      }
    }
    return count;
  }

  [[nodiscard]] Result<void> begin_setup() {
    if (auto opened = reports_->open(); !opened) return failure(std::move(opened.error()));
    const auto set = set_differing_items();
    if (!set) return failure(set.error());
    if (*set > 0)
      if (auto sent = send(mcc_request(MccCommand::calibrate)); !sent) return sent;
    stage_ = Stage::calibrating;
    return {};
  }

  /// Verifies that the calibration has ended (otherwise fails with timeout) and that the settings are correct
  /// (otherwise fails with mismatch).
  [[nodiscard]] Result<void> finish_calibration() {
    const auto status = query_bytes(mcc_request(MccCommand::read_status));
    if (!status) return failure(status.error());
    if (is_mcc_calibrating(status->front())) return failure(FaultKind::timeout, "", "self-calibration in progress");
    stage_ = Stage::unknown;
    for (std::uint8_t input = 0; input < kMccInputs; ++input) {
      if (!options_.sensors[input]) continue;
      for (const auto& item : mcc_setup(input, *options_.sensors[input])) {
        const auto is_set = has_value(item);
        if (!is_set) return failure(is_set.error());
        if (!*is_set)
          return failure(FaultKind::mismatch, fmt::format("input {}", input),
                         fmt::format("item {:02X} did not keep its setting", item.arguments[1]));
      }
    }
    stage_ = Stage::ready;
    return {};
  }

  [[nodiscard]] Result<void> make_ready() {
    if (stage_ == Stage::unknown)
      if (auto started = begin_setup(); !started) return started;
    return stage_ == Stage::calibrating ? finish_calibration() : Result<void>{};
  }

  [[nodiscard]] Result<std::string> wait_until_ready() {
    std::array<std::byte, kMccLongestReport> stray;
    for (int reads = 1;; ++reads) {
      auto ready = make_ready();
      if (ready) return reports_->open();
      if (stage_ != Stage::calibrating || reads == kMaxStatusReads) return failure(std::move(ready.error()));
      (void)reports_->read(stray, kStatusPeriod);  // a pause; no report is expected
    }
  }

  /// Notes a fault and returns it. After a disconnect, the next call compares the settings again, because another
  /// device may have been plugged in.
  const Fault& note_fault(const Fault& fault) {
    if (fault.kind == FaultKind::disconnected) stage_ = Stage::unknown;
    return fault;
  }

  std::unique_ptr<HidReports> reports_;
  std::string place_;
  MccOptions options_;
  MccRanges ranges_ = mcc_max_ranges();
  Stage stage_ = Stage::unknown;
  bool reply_may_come_late_ = false;
};

}  // namespace

std::unique_ptr<Thermometer> make_mcc_usb_temp(std::unique_ptr<HidReports> reports, std::string place,
                                               MccOptions options) {
  return std::make_unique<MccUsbTemp>(std::move(reports), std::move(place), options);
}

}  // namespace gyrotherm::drivers
