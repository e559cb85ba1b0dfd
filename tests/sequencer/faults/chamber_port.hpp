// SPDX-License-Identifier: Apache-2.0
/// The chamber's end of its Modbus line, with TCP or RTU frames. Breaks on command and records the requests.
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

/// Faults of the chamber's end, in addition to the faults of any line.
struct ChamberTrouble {
  /// Exception to every request; 0: none.
  std::uint8_t exception{};
  /// Exception only to writes.
  bool only_writes{};
  bool foreign_unit{};  ///< another unit answers
  /// TCP: answers carry the number of another transaction.
  bool wrong_number{};
  /// TCP: a connection is neither established nor refused.
  bool half_open{};
  /// Acknowledges writes and does not apply them.
  bool ignores_writes{};
  /// Another chamber answers. Its identity is in the registers.
  bool exchanged{};
  /// Largest applied magnitude; a set point of larger magnitude is clamped to it.
  std::optional<Celsius> clamps_at;
};

/// Set point that the chamber received in a separate frame.
struct SetPointSent {
  Celsius value;
  bool applied{};
  /// Sent before the previous set point was read back.
  bool before_read_back{};
};

class ChamberPort {
 public:
  /// All references must outlive this object.
  ChamberPort(simulator::ChamberRegisters& registers, simulator::VirtualLaboratory& laboratory, const Clock& rig,
              std::uint64_t seed);

  ChamberTrouble trouble;
  [[nodiscard]] LineEnd& line() { return line_; }
  [[nodiscard]] bool is_tcp() const { return registers_.map().link.kind == drivers::LinkKind::tcp; }

  /// Answers one frame. `answer` stays empty if the chamber is silent.
  void answer(std::span<const std::byte> frame, Bytes& answer);

  /// Returns the set points since the last call of forget().
  [[nodiscard]] const std::vector<SetPointSent>& set_points_sent() const { return sent_; }
  [[nodiscard]] int unread_set_points() const { return not_read_back_; }
  [[nodiscard]] std::int64_t exchanges() const { return exchanges_; }
  /// Returns the number of writes since the last call that reached another chamber connected in place of this one.
  [[nodiscard]] int take_writes_to_other_chamber() { return std::exchange(sent_to_another_, 0); }
  /// Ends the wait for a read-back, because the program has died.
  void reset() { to_be_read_back_.reset(); }
  void forget() { sent_.clear(), not_read_back_ = 0, exchanges_ = 0; }

 private:
  [[nodiscard]] std::optional<Celsius> set_point_in(const drivers::ModbusRequest& request) const;
  [[nodiscard]] bool shows_set_point(const drivers::ModbusRequest& request) const;
  /// Returns true for a read of the identity, or of only the air temperature, which is read to check the word order.
  [[nodiscard]] bool is_identity_request(const drivers::ModbusRequest& request) const;
  void note(const drivers::ModbusRequest& request);
  void clamp();
  void corrupt(Bytes& answer);

  simulator::ChamberRegisters& registers_;
  simulator::VirtualLaboratory& laboratory_;
  const drivers::RegisterItem& set_point_;
  std::unique_ptr<simulator::Session> session_;
  LineEnd line_;
  std::vector<SetPointSent> sent_;
  std::optional<Celsius> to_be_read_back_;
  bool is_refused_ = false;  ///< the last command
  int not_read_back_ = 0, lost_before_ = 0;
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
  bool is_silent_for(Duration time) override;

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
