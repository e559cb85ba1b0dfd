/// Where one link of a unit has the registers that its map describes: some units have an item at another place on a
/// serial line than on TCP.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <set>

#include "drivers/chamber/register_map.hpp"

namespace gyrotherm {

class LinkAddresses {
 public:
  /// `map` with its link in use, by which the registers are kept; `kind`: the link that is served. A map that does not
  /// describe such a link is served as it is in use.
  LinkAddresses(const RegisterMap& map, LinkKind kind);

  [[nodiscard]] std::uint8_t unit() const { return link_.unit; }
  [[nodiscard]] std::uint16_t read_at_most() const { return link_.read_at_most; }
  /// Where the map in use has the register that this link has at `address`; nothing if it has none there.
  [[nodiscard]] std::optional<std::uint16_t> in_use(std::uint16_t address) const;

 private:
  ModbusLink link_;
  std::map<std::uint16_t, std::uint16_t> moved_;  ///< on this link → in use
  std::set<std::uint16_t> away_;                  ///< in use, and elsewhere on this link
};

}  // namespace gyrotherm
