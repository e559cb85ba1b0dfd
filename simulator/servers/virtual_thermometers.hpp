// SPDX-License-Identifier: Apache-2.0
/// The server side of the thermometer protocols: Lake Shore 218, DCON modules, RH Systems PT12, MCC USB-TEMP, and
/// process drivers. A dead thermometer appears as an input without a thermometer; on a USB-TEMP its wire is open.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <map>
#include <mutex>
#include <utility>
#include <vector>

#include "drivers/thermometer/dcon_thermometer.hpp"
#include "drivers/thermometer/lakeshore_218.hpp"
#include "drivers/thermometer/mcc_usb_temp.hpp"
#include "drivers/thermometer/process_thermometer.hpp"
#include "drivers/thermometer/pt12.hpp"
#include "drivers/wires.hpp"
#include "simulator/servers/session.hpp"
#include "simulator/virtual_laboratory.hpp"

namespace gyrotherm::simulator {

/// The virtual Lake Shore 218 (user's manual pp. 6-10 to 6-29). Answers *IDN?, CRDG? and KRDG? (no argument or 0: all
/// eight inputs; 1…8: one), with three decimals. Like the real instrument, it does not reply to anything else. An input
/// without a thermometer reads 0 K.
class Lakeshore218Session final : public TextSession {
 public:
  using Inputs = simulator::Inputs<drivers::kLakeshore218Inputs>;

  /// Creates a session. `laboratory` must outlive it.
  Lakeshore218Session(const VirtualLaboratory& laboratory, const Inputs& inputs)
      : TextSession('\n'), laboratory_(laboratory), inputs_(inputs) {}

 private:
  [[nodiscard]] std::string answer(std::string_view command) const override;
  [[nodiscard]] std::string readings(std::string_view argument, double zero_c) const;

  const VirtualLaboratory& laboratory_;
  Inputs inputs_;
};

/// One thermocouple module with the DCON protocol (I-7018 user's manual rev. B1.0, chapters 1.10 and 2) and its
/// settings.
struct DconModule {
  std::uint8_t address = 1;
  /// Thermocouple type: 0E, 0F, 10 or 11 for J, K, T, E.
  std::uint8_t type = 0x10;
  drivers::DconChecksum checksum = drivers::DconChecksum::off;
  /// The name that the module reports, at most six characters.
  std::string name = "7018";
  Inputs<drivers::kDconInputs> inputs;
};

/// Modules on one line. Each answers #AA and #AAN in engineering units with two decimals, and $AA2, $AA6, $AAM and
/// $AAF, at its address. Another command after $AA is invalid (?AA). Any other command has no reply. An input without a
/// thermometer is an open wire: over range.
class DconSession final : public TextSession {
 public:
  /// Creates a session. `laboratory` must outlive it.
  DconSession(const VirtualLaboratory& laboratory, std::vector<DconModule> modules)
      : TextSession('\r'), laboratory_(laboratory), modules_(std::move(modules)) {}

 private:
  [[nodiscard]] std::string answer(std::string_view command) const override;
  [[nodiscard]] std::string answer(const DconModule& module, std::string_view command) const;
  [[nodiscard]] std::string readings(const DconModule& module, std::string_view which) const;

  const VirtualLaboratory& laboratory_;
  std::vector<DconModule> modules_;
};

/// The virtual RH Systems PT12 (manual of 7/20/2021, chapter 5). Answers ID?, SN?, T?, T1? to T12? and CONNECTED?, in
/// any letter case, with five decimals. Does not reply to anything else. An input without a thermometer reads NaN.
class Pt12Session final : public TextSession {
 public:
  using Inputs = simulator::Inputs<drivers::kPt12Inputs>;

  /// Creates a session. `laboratory` must outlive it.
  Pt12Session(const VirtualLaboratory& laboratory, const Inputs& inputs)
      : TextSession('\r'), laboratory_(laboratory), inputs_(inputs) {}

 private:
  [[nodiscard]] std::string answer(std::string_view command) const override;
  [[nodiscard]] std::string connected_inputs() const;

  const VirtualLaboratory& laboratory_;
  Inputs inputs_;
};

/// The server side of a process driver (docs/adding-an-instrument.md). Answers the commands hello and read; each reply
/// repeats the number of its command. Any other command has no reply.
class ProcessSession final : public TextSession {
 public:
  /// Creates a session. `inputs` are indices of the laboratory's thermometers. `laboratory` must outlive it.
  ProcessSession(const VirtualLaboratory& laboratory, std::vector<std::size_t> inputs)
      : TextSession('\n'), laboratory_(laboratory), inputs_(std::move(inputs)) {}

 private:
  [[nodiscard]] std::string answer(std::string_view command) const override;

  const VirtualLaboratory& laboratory_;
  std::vector<std::size_t> inputs_;
};

/// A simulated MCC USB-TEMP that exchanges HID reports in memory. Stores the settings of its items, initially a 100 Ω
/// platinum thermometer at each input. A calibration finishes immediately. An input without a thermometer is disabled.
/// Unknown requests have no reply.
class VirtualUsbTemp final : public drivers::HidReports {
 public:
  using Inputs = simulator::Inputs<drivers::kMccInputs>;

  /// Creates the device. Both references must outlive it. `laboratory_guard` is held while the laboratory is read.
  VirtualUsbTemp(const VirtualLaboratory& laboratory, std::mutex& laboratory_guard, const Inputs& inputs);

  [[nodiscard]] Result<std::string> open() override { return std::string("USB-TEMP 0VIRTUAL"); }
  [[nodiscard]] Result<void> write(std::span<const std::byte> report) override;
  /// Returns the next reply. Without one, fails with timeout immediately, because no reply can arrive later.
  [[nodiscard]] Result<std::size_t> read(std::span<std::byte> report, Duration within) override;

 private:
  /// Index of the converter and of its item.
  using Item = std::pair<std::uint8_t, std::uint8_t>;
  void execute(const drivers::MccRequest& request);
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
