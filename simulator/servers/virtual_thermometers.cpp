// SPDX-License-Identifier: Apache-2.0
#include "simulator/servers/virtual_thermometers.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include "core/quantity.hpp"
#include "core/text.hpp"
#include "drivers/thermometer/mcc_usb_temp.hpp"

namespace gyrotherm::simulator {
namespace {

constexpr int kCrdgDecimals = 3;

/// Returns the reading at an input, or nothing if the input has no thermometer or a dead one.
std::optional<double> read_at(const std::optional<std::size_t>& input, const VirtualLaboratory& laboratory) {
  if (!input) return {};
  const double celsius = laboratory.thermometers_as_measured_c()[*input];
  return std::isnan(celsius) ? std::nullopt : std::optional(celsius);
}

}  // namespace

std::string Lakeshore218Session::answer(std::string_view command) const {
  if (command == "*IDN?") return "LSCI,MODEL218S,VIRTUAL1,010126\r\n";
  if (command.starts_with("CRDG?")) return readings(trimmed(command.substr(5), kBlanks), 0);
  if (command.starts_with("KRDG?")) return readings(trimmed(command.substr(5), kBlanks), kZeroCelsiusInKelvin);
  return {};
}

std::string Lakeshore218Session::readings(std::string_view argument, double zero_c) const {
  std::array<double, drivers::kLakeshore218Inputs> shown{};
  for (std::size_t i = 0; i < shown.size(); ++i)
    shown[i] = read_at(inputs_[i], laboratory_).value_or(-kZeroCelsiusInKelvin) + zero_c;
  if (argument.empty() || argument == "0") return drivers::encode_crdg(shown, kCrdgDecimals) + "\r\n";
  const bool one_input = argument.size() == 1 && argument[0] >= '1' && argument[0] <= '8';
  if (!one_input) return {};
  return drivers::encode_crdg(std::span(shown).subspan(static_cast<std::size_t>(argument[0] - '1'), 1), kCrdgDecimals) +
         "\r\n";
}

namespace {

constexpr int kDconDecimals = 2;
// Length of "#AA".
constexpr std::size_t kHeadSize = 3;
constexpr std::uint8_t kBaud9600 = 0x06, kSumSwitch = 0x40;

std::string settings_text(const DconModule& module) {
  const auto format = module.checksum == drivers::DconChecksum::on ? kSumSwitch : std::uint8_t{0};
  return drivers::encode_dcon_configuration({.type = module.type, .baud = kBaud9600, .format = format});
}

}  // namespace

std::string DconSession::answer(std::string_view command) const {
  for (const auto& module : modules_) {
    const auto text = unseal_dcon(command, module.checksum);
    if (!text || text->size() < kHeadSize) continue;
    if (text->substr(1, 2) != fmt::format("{:02X}", module.address)) continue;
    const auto reply = answer(module, *text);
    return reply.empty() ? reply : seal_dcon(reply, module.checksum) + "\r";
  }
  return {};
}

std::string DconSession::answer(const DconModule& module, std::string_view command) const {
  const auto what = command.substr(kHeadSize);
  const auto acknowledge = [&](std::string_view text) { return fmt::format("!{:02X}{}", module.address, text); };
  if (command[0] == '#') return readings(module, what);
  if (command[0] != '$') return {};
  if (what == "2") return acknowledge(settings_text(module));
  if (what == "6") return acknowledge("FF");
  if (what == "M") return acknowledge(module.name);
  if (what == "F") return acknowledge("A0101");
  return fmt::format("?{:02X}", module.address);
}

std::string DconSession::readings(const DconModule& module, std::string_view which) const {
  std::array<double, drivers::kDconInputs> shown{};
  for (std::size_t i = 0; i < shown.size(); ++i)
    shown[i] = read_at(module.inputs[i], laboratory_).value_or(std::numeric_limits<double>::infinity());
  const auto range = drivers::dcon_range(module.type).value_or(drivers::TemperatureRange{});
  if (which.empty()) return drivers::encode_dcon_readings(shown, range, kDconDecimals);
  if (which.size() != 1 || which[0] < '0' || which[0] > '7') return {};
  return drivers::encode_dcon_readings(std::span(shown).subspan(static_cast<std::size_t>(which[0] - '0'), 1), range,
                                       kDconDecimals);
}

namespace {

/// Parses "Tn?". Returns n, counted from 1, or 0 for any other command.
std::size_t parse_input(std::string_view command) {
  if (command.size() < 3 || command.front() != 'T' || command.back() != '?') return 0;
  const auto digits = command.substr(1, command.size() - 2);
  std::size_t input{};
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), input);
  return error == std::errc{} && end == digits.data() + digits.size() && input <= drivers::kPt12Inputs ? input : 0;
}

}  // namespace

std::string Pt12Session::connected_inputs() const {
  std::vector<std::size_t> numbers;
  for (std::size_t i = 0; i < inputs_.size(); ++i)
    if (inputs_[i]) numbers.push_back(i + 1);
  return fmt::format("{}\r\n", fmt::join(numbers, ", "));
}

std::string Pt12Session::answer(std::string_view command) const {
  std::string upper(command);
  std::ranges::transform(upper, upper.begin(), [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
  if (upper == "ID?") return "PT12\r\n";
  if (upper == "SN?") return "VIRTUAL1\r\n";
  if (upper == "CONNECTED?") return connected_inputs();
  std::array<std::optional<double>, drivers::kPt12Inputs> shown;
  for (std::size_t i = 0; i < shown.size(); ++i) shown[i] = read_at(inputs_[i], laboratory_);
  if (upper == "T?") return drivers::encode_pt12_temperatures(shown) + "\r\n";
  if (const auto input = parse_input(upper); input > 0)
    return drivers::encode_pt12_temperatures(std::span(shown).subspan(input - 1, 1)) + "\r\n";
  return {};
}

std::string ProcessSession::answer(std::string_view command) const {
  const auto question = drivers::split_numbered_line(command);
  if (!question) return {};
  if (question->rest == "hello")
    return fmt::format("{} {}\n", question->number,
                       drivers::encode_process_greeting({inputs_.size(), "a virtual program"}));
  if (question->rest != "read") return {};
  std::vector<std::optional<double>> shown;
  for (const auto input : inputs_) shown.push_back(read_at(input, laboratory_));
  return fmt::format("{} {}\n", question->number, drivers::encode_process_readings(shown));
}

namespace {

constexpr float kColdJunctionC = 25;
/// Date of the last calibration, at address F0 of the device's memory: 2025-06-01 10:00:00.
constexpr std::array<std::uint8_t, 6> kCalibrated{25, 6, 1, 10, 0, 0};
constexpr std::size_t kCalibrationDateAddress = 0xF0;

}  // namespace

VirtualUsbTemp::VirtualUsbTemp(const VirtualLaboratory& laboratory, std::mutex& laboratory_guard, const Inputs& inputs)
    : laboratory_(laboratory), laboratory_guard_(laboratory_guard), inputs_(inputs) {
  for (std::uint8_t input = 0; input < drivers::kMccInputs; ++input)
    for (const auto& request : mcc_setup(input, drivers::MccRtd{})) execute(request);
}

Result<void> VirtualUsbTemp::write(std::span<const std::byte> report) {
  if (const auto request = drivers::decode_mcc_request(report)) execute(*request);
  return {};
}

Result<std::size_t> VirtualUsbTemp::read(std::span<std::byte> report, Duration) {
  if (replies_.empty()) return failure(FaultKind::timeout, "virtual USB-TEMP", "no reply is pending");
  const auto size = std::min(report.size(), replies_.front().size());
  std::copy_n(replies_.front().begin(), size, report.begin());
  replies_.pop_front();
  return size;
}

float VirtualUsbTemp::temperature(std::size_t input) {
  if (!inputs_[input]) return drivers::kMccDisabled;
  const std::scoped_lock lock(laboratory_guard_);
  const auto celsius = read_at(inputs_[input], laboratory_);
  return celsius ? static_cast<float>(*celsius) : drivers::kMccOpen;
}

void VirtualUsbTemp::reply(const drivers::MccRequest& request, const std::vector<std::uint8_t>& bytes) {
  replies_.push_back(encode_mcc_bytes(request.command, bytes));
}

/// Returns the stored settings of an item, or zeros if none are stored.
std::vector<std::uint8_t> VirtualUsbTemp::item(const drivers::MccRequest& request) const {
  const auto found = items_.find({request.arguments[0], request.arguments[1]});
  auto bytes = found == items_.end() ? std::vector<std::uint8_t>() : found->second;
  bytes.resize(mcc_reply_length(request));
  return bytes;
}

void VirtualUsbTemp::execute(const drivers::MccRequest& request) {
  const auto& a = request.arguments;
  switch (request.command) {
    case drivers::MccCommand::read_input:
      return replies_.push_back(encode_mcc_numbers(
          request.command, std::array{a[0] < drivers::kMccInputs ? temperature(a[0]) : kColdJunctionC}));
    case drivers::MccCommand::scan: {
      std::vector<float> readings;
      for (std::size_t input = a[0]; input <= a[1]; ++input) readings.push_back(temperature(input));
      return replies_.push_back(encode_mcc_numbers(request.command, readings));
    }
    case drivers::MccCommand::read_memory: {
      std::vector<std::uint8_t> bytes(a[3], 0xFF);
      for (std::size_t i = 0; i < bytes.size(); ++i)
        if (const std::size_t at = a[0] + i;
            at >= kCalibrationDateAddress && at < kCalibrationDateAddress + kCalibrated.size())
          bytes[i] = kCalibrated[at - kCalibrationDateAddress];
      return reply(request, bytes);
    }
    case drivers::MccCommand::set_item: items_[{a[0], a[1]}] = {a.begin() + 2, a.end()}; return;
    case drivers::MccCommand::read_item: return reply(request, item(request));
    default:
      if (const auto length = mcc_reply_length(request); length > 0) reply(request, std::vector<std::uint8_t>(length));
  }
}

}  // namespace gyrotherm::simulator
