// SPDX-License-Identifier: Apache-2.0
/// The chamber's end of its Modbus line, by TCP or RTU frames: what breaks there, and a protocol of what was asked.
#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <utility>
#include <vector>

#include "drivers/line/modbus_lines.hpp"
#include "simulator/chamber_registers.hpp"
#include "simulator/servers/modbus_server.hpp"
#include "tests/sequencer/faults/memory_line.hpp"

namespace gyrotherm::faults {

/// Beside what can be wrong with any line.
struct ChamberTrouble {
  std::uint8_t exception{};          ///< answers everything so; 0: no
  bool only_writes{};                ///< … everything that writes
  bool foreign_unit{};               ///< another unit answers
  bool wrong_number{};               ///< TCP: answers carry another transaction's number
  bool half_open{};                  ///< TCP: no connection comes about, and nobody says so
  bool ignores_writes{};             ///< acknowledged and not applied
  bool exchanged{};                  ///< another chamber answers; its identity is the registers'
  std::optional<Celsius> clamps_at;  ///< a set point further from zero is applied as this one, by its magnitude
};

/// A set point that came to the chamber in a frame of its own.
struct SetPointSent {
  Celsius value;
  bool applied{};
  bool before_read_back{};  ///< of another one that had been sent
};

class ChamberPort {
 public:
  /// `registers` and `world` outlive it.
  ChamberPort(simulator::ChamberRegisters& registers, simulator::VirtualLaboratory& laboratory, const Clock& rig,
              std::uint64_t seed);

  ChamberTrouble trouble;
  [[nodiscard]] LineEnd& line() { return line_; }
  [[nodiscard]] bool is_tcp() const { return registers_.map().link.kind == drivers::LinkKind::tcp; }

  /// What the chamber does about one frame; `answer` stays empty where it is silent.
  void answer(std::span<const std::byte> frame, Bytes& answer);

  /// Since the last call of forget().
  [[nodiscard]] const std::vector<SetPointSent>& set_points_sent() const { return sent_; }
  [[nodiscard]] int not_read_back() const { return not_read_back_; }
  [[nodiscard]] std::int64_t exchanges() const { return exchanges_; }
  /// Returns how many writes another chamber in this one's place was sent since the last call.
  [[nodiscard]] int take_sent_to_another() { return std::exchange(sent_to_another_, 0); }
  /// The program died: what it would have read back it cannot.
  void start_afresh() { to_be_read_back_.reset(); }
  void forget() { sent_.clear(), not_read_back_ = 0, exchanges_ = 0; }

 private:
  [[nodiscard]] std::optional<Celsius> set_point_in(const drivers::ModbusRequest& request) const;
  [[nodiscard]] bool shows_set_point(const drivers::ModbusRequest& request) const;
  /// Reads the fingerprint, or the air alone, by whose words the order is compared.
  [[nodiscard]] bool asks_who(const drivers::ModbusRequest& request) const;
  void note(const drivers::ModbusRequest& request);
  void clamp();
  void spoil(Bytes& answer);

  simulator::ChamberRegisters& registers_;
  simulator::VirtualLaboratory& laboratory_;
  const drivers::RegisterItem& set_point_;
  std::unique_ptr<simulator::Session> session_;
  LineEnd line_;
  std::vector<SetPointSent> sent_;
  std::optional<Celsius> to_be_read_back_;
  int not_read_back_ = 0;
  std::int64_t exchanges_ = 0;
  int sent_to_another_ = 0;
};

/// A Modbus TCP connection to the port.
class MemoryConnection final : public drivers::FrameConnection {
 public:
  explicit MemoryConnection(ChamberPort& port) : port_(port) {}

  bool is_open() const override { return open_; }
  Result<void> open(Duration within) override;
  void close() override { open_ = false, coming_.clear(); }
  Result<void> send(std::span<const std::byte> frame) override;
  Result<std::size_t> receive(std::span<std::byte> frame, Duration within) override;
  bool silent_for(Duration time) override;

 private:
  struct Coming {
    Duration at{};
    Bytes frame;
    bool cut{};
  };
  ChamberPort& port_;
  bool open_ = false;
  std::deque<Coming> coming_;
  Bytes answer_;
};

}  // namespace gyrotherm::faults
