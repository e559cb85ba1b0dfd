// SPDX-License-Identifier: Apache-2.0
#include "simulator/servers/virtual_usb_temp.hpp"

#include <algorithm>

#include "drivers/thermometer/mcc_usb_temp.hpp"

namespace gyrotherm::simulator {
namespace {

constexpr float kColdJunctionC = 25;
/// Of the last calibration, at address F0 of its memory: 2025-06-01 10:00:00.
constexpr std::array<std::uint8_t, 6> kCalibrated{25, 6, 1, 10, 0, 0};
constexpr std::size_t kCalibratedAt = 0xF0;

}  // namespace

VirtualUsbTemp::VirtualUsbTemp(const VirtualLaboratory& laboratory, std::mutex& laboratory_guard, const Inputs& inputs)
    : laboratory_(laboratory), laboratory_guard_(laboratory_guard), inputs_(inputs) {
  for (std::uint8_t input = 0; input < drivers::kMccInputs; ++input)
    for (const auto& request : mcc_setup(input, drivers::MccRtd{})) obey(request);
}

Result<void> VirtualUsbTemp::write(std::span<const std::byte> report) {
  if (const auto request = drivers::decode_mcc_request(report)) obey(*request);
  return {};
}

Result<std::size_t> VirtualUsbTemp::read(std::span<std::byte> report, Duration) {
  if (replies_.empty()) return failure(FaultKind::timeout, "virtual USB-TEMP", "no report came");
  const auto size = std::min(report.size(), replies_.front().size());
  std::copy_n(replies_.front().begin(), size, report.begin());
  replies_.pop_front();
  return size;
}

float VirtualUsbTemp::temperature(std::size_t input) {
  if (!inputs_[input]) return drivers::kMccDisabled;
  const std::scoped_lock lock(laboratory_guard_);
  return static_cast<float>(laboratory_.thermometers_as_measured_c()[*inputs_[input]]);
}

void VirtualUsbTemp::reply(const drivers::MccRequest& request, const std::vector<std::uint8_t>& bytes) {
  replies_.push_back(encode_mcc_bytes(request.command, bytes));
}

/// As it was set; zeros if it never was.
std::vector<std::uint8_t> VirtualUsbTemp::item(const drivers::MccRequest& request) const {
  const auto found = items_.find({request.arguments[0], request.arguments[1]});
  auto bytes = found == items_.end() ? std::vector<std::uint8_t>() : found->second;
  bytes.resize(mcc_reply_length(request));
  return bytes;
}

void VirtualUsbTemp::obey(const drivers::MccRequest& request) {
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
        if (const std::size_t at = a[0] + i; at >= kCalibratedAt && at < kCalibratedAt + kCalibrated.size())
          bytes[i] = kCalibrated[at - kCalibratedAt];
      return reply(request, bytes);
    }
    case drivers::MccCommand::set_item: items_[{a[0], a[1]}] = {a.begin() + 2, a.end()}; return;
    case drivers::MccCommand::read_item: return reply(request, item(request));
    default:
      if (const auto length = mcc_reply_length(request); length > 0) reply(request, std::vector<std::uint8_t>(length));
  }
}

}  // namespace gyrotherm::simulator
