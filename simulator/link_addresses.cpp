#include "simulator/link_addresses.hpp"

namespace gyrotherm {

LinkAddresses::LinkAddresses(const RegisterMap& map, LinkKind kind) {
  const auto* link = map.find(kind);
  if (!link) link = &map.link;
  link_ = link->modbus;
  if ((link->kind == LinkKind::tcp) == (map.link.kind == LinkKind::tcp)) return;
  for (const auto& item : map.items) {
    if (!item.rtu_address) continue;  // the other kind's place, whichever is in use
    for (std::uint16_t i = 0; i < word_count(item); ++i) {
      moved_[static_cast<std::uint16_t>(*item.rtu_address + i)] = static_cast<std::uint16_t>(item.address + i);
      away_.insert(static_cast<std::uint16_t>(item.address + i));
    }
  }
}

std::optional<std::uint16_t> LinkAddresses::in_use(std::uint16_t address) const {
  if (const auto moved = moved_.find(address); moved != moved_.end()) return moved->second;
  return away_.contains(address) ? std::nullopt : std::optional(address);
}

}  // namespace gyrotherm
