// SPDX-License-Identifier: Apache-2.0
/// A virtual unit's side of Modbus: its map's functions over the registers of its map, framed for TCP or for a serial
/// line.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <set>

#include "drivers/chamber/register_map.hpp"
#include "drivers/line/modbus_frame.hpp"
#include "simulator/served_registers.hpp"
#include "simulator/servers/session.hpp"

namespace gyrotherm::simulator {

class LinkAddresses {
 public:
  /// `map` with its link in use, by which the registers are kept; `kind`: the link that is served. A map that does not
  /// describe such a link is served as it is in use.
  LinkAddresses(const drivers::RegisterMap& map, drivers::LinkKind kind);

  [[nodiscard]] std::uint8_t unit() const { return link_.unit; }
  [[nodiscard]] std::uint16_t read_at_most() const { return link_.read_at_most; }
  /// Where the map in use has the register that this link has at `address`; nothing if it has none there.
  [[nodiscard]] std::optional<std::uint16_t> in_use(std::uint16_t address) const;

 private:
  drivers::ModbusLink link_;
  std::map<std::uint16_t, std::uint16_t> moved_;  ///< on this link → in use
  std::set<std::uint16_t> away_;                  ///< in use, and elsewhere on this link
};

/// Carries out what is asked at the addresses of one link. `words`: what a read found. Fails with the exception that
/// answers it. Function 4 reads the same registers as 3; coils are read by 1 and 2.
[[nodiscard]] tl::expected<void, ModbusException> carry_out(ServedRegisters& registers, const LinkAddresses& addresses,
                                                            const drivers::ModbusRequest& request,
                                                            std::vector<std::uint16_t>& words);

/// Requests to another unit are not answered, as by a unit on a shared line; nor is what a map's unit meets with
/// silence. Bytes that cannot become a frame end the session.
class ModbusSession final : public Session {
 public:
  /// `registers` must outlive this.
  explicit ModbusSession(ServedRegisters& registers)
      : registers_(registers), addresses_(registers.map(), drivers::LinkKind::tcp) {}
  [[nodiscard]] bool feed(std::span<const std::byte> bytes, std::vector<std::byte>& reply) override;

 private:
  [[nodiscard]] std::vector<std::byte> answer(std::span<const std::byte> frame);

  ServedRegisters& registers_;
  LinkAddresses addresses_;
  std::vector<std::byte> pending_;    ///< the beginning of a frame
  std::vector<std::uint16_t> words_;  ///< of one reply, kept for its memory
};

/// The same with Modbus RTU's framing. There is no silence to tell frames apart in a function of bytes, so a frame ends
/// where its function says; what is no frame, or fails its check, is dropped up to the end of what came with it.
class ModbusRtuSession final : public Session {
 public:
  /// `kind`: the link's, whose unit and addresses are served.
  ModbusRtuSession(ServedRegisters& registers, drivers::LinkKind kind)
      : registers_(registers), addresses_(registers.map(), kind) {}
  [[nodiscard]] bool feed(std::span<const std::byte> bytes, std::vector<std::byte>& reply) override;

 private:
  void answer(std::span<const std::byte> frame, std::vector<std::byte>& reply);

  ServedRegisters& registers_;
  LinkAddresses addresses_;
  std::vector<std::byte> pending_;
  std::vector<std::uint16_t> words_;
};

/// The session that the map's link in use wants.
[[nodiscard]] std::unique_ptr<Session> make_modbus_session(ServedRegisters& registers);

}  // namespace gyrotherm::simulator
