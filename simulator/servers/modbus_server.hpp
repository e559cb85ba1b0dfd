// SPDX-License-Identifier: Apache-2.0
/// The server side of Modbus: executes the map's functions on its registers, with TCP or serial framing.
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
  /// Creates the conversion for a link of this kind. The registers of `map` have the addresses of the link that the map
  /// has selected. If the map does not describe a link of this kind, the addresses of the selected link are served.
  LinkAddresses(const drivers::RegisterMap& map, drivers::LinkKind kind);

  [[nodiscard]] std::uint8_t unit() const { return link_.unit; }
  [[nodiscard]] std::uint16_t read_at_most() const { return link_.read_at_most; }
  /// Converts an address on this link to the address of the same register on the selected link. Returns nothing if this
  /// link has no register at `address`.
  [[nodiscard]] std::optional<std::uint16_t> to_selected_link(std::uint16_t address) const;

 private:
  drivers::ModbusLink link_;
  /// Address on this link → address on the selected link.
  std::map<std::uint16_t, std::uint16_t> moved_;
  /// Addresses on the selected link whose registers have other addresses on this link.
  std::set<std::uint16_t> away_;
};

/// Executes a request with the addresses of one link. Appends the registers of a read to `words`. Fails with the
/// exception to send. Function 4 reads the same registers as 3; functions 1 and 2 read coils.
[[nodiscard]] tl::expected<void, ModbusException> carry_out(ServedRegisters& registers, const LinkAddresses& addresses,
                                                            const drivers::ModbusRequest& request,
                                                            std::vector<std::uint16_t>& words);

/// A Modbus TCP session. Requests to another unit are not answered, as on a shared line, nor are invalid requests if
/// the map's unit is silent on them. Bytes that cannot become a frame end the session.
class ModbusSession final : public Session {
 public:
  /// Creates a session. `registers` must outlive it.
  explicit ModbusSession(ServedRegisters& registers)
      : registers_(registers), addresses_(registers.map(), drivers::LinkKind::tcp) {}
  [[nodiscard]] bool feed(std::span<const std::byte> bytes, std::vector<std::byte>& reply) override;

 private:
  [[nodiscard]] std::vector<std::byte> answer(std::span<const std::byte> frame);

  ServedRegisters& registers_;
  LinkAddresses addresses_;
  /// Beginning of an incomplete frame.
  std::vector<std::byte> pending_;
  /// Registers of one reply; a member to reuse its memory.
  std::vector<std::uint16_t> words_;
};

/// A Modbus RTU session. A session receives bytes without the pauses that separate frames on a serial line, so it
/// determines the length of a frame from the function code. If the bytes are not a frame or their check fails, they are
/// dropped together with all bytes that arrived with them.
class ModbusRtuSession final : public Session {
 public:
  /// Creates a session with the unit and addresses of the link `kind`.
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

/// Returns a session for the link that the map has selected.
[[nodiscard]] std::unique_ptr<Session> make_modbus_session(ServedRegisters& registers);

}  // namespace gyrotherm::simulator
