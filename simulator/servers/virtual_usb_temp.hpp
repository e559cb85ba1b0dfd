// SPDX-License-Identifier: Apache-2.0
/// A virtual MCC USB-TEMP, in memory: what would be at the other end of its HID reports.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <map>
#include <mutex>
#include <utility>
#include <vector>

#include "drivers/thermometer/mcc_usb_temp_codec.hpp"
#include "drivers/wires.hpp"
#include "simulator/servers/session.hpp"
#include "simulator/virtual_laboratory.hpp"

namespace gyrotherm::simulator {

/// Keeps what its items are set to, at first a platinum thermometer of 100 Ω at each input; calibrates in no time. An
/// input without a thermometer is disabled. What it does not understand has no reply.
class VirtualUsbTemp final : public drivers::HidReports {
 public:
  using Inputs = simulator::Inputs<drivers::kMccInputs>;

  /// Both must outlive this; `laboratory_guard` is held while the world is read.
  VirtualUsbTemp(const VirtualLaboratory& laboratory, std::mutex& laboratory_guard, const Inputs& inputs);

  [[nodiscard]] Result<std::string> open() override { return std::string("USB-TEMP 0VIRTUAL"); }
  [[nodiscard]] Result<void> write(std::span<const std::byte> report) override;
  /// Nothing comes later: without a reply it times out at once.
  [[nodiscard]] Result<std::size_t> read(std::span<std::byte> report, Duration within) override;

 private:
  using Item = std::pair<std::uint8_t, std::uint8_t>;  ///< converter and what of it
  void obey(const drivers::MccRequest& request);
  void reply(const drivers::MccRequest& request, const std::vector<std::uint8_t>& bytes);
  [[nodiscard]] float temperature(std::size_t input);
  [[nodiscard]] std::vector<std::uint8_t> item(const drivers::MccRequest& request) const;

  const VirtualLaboratory& laboratory_;
  std::mutex& laboratory_guard_;
  Inputs inputs_;
  std::map<Item, std::vector<std::uint8_t>> items_;
  std::deque<std::vector<std::byte>> replies_;
};

}  // namespace gyrotherm::simulator
