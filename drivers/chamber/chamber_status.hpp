/// What the contents of some registers say of the chamber's state and alarms. Pure.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "drivers/chamber/register_map.hpp"

namespace gyrotherm {

struct ChamberStatus {
  ChamberActivity activity = ChamberActivity::unknown;
  std::vector<std::string> alarms;  ///< the gravest first
  bool must_stop{};
};

/// The value of an item by name; nothing where it is not known, and then its rules say nothing.
using ItemValue = std::function<std::optional<double>(const std::string&)>;

[[nodiscard]] ChamberStatus status_of(const RegisterMap& map, const ItemValue& value);
/// The items that status_of() asks for, each once.
[[nodiscard]] std::vector<const RegisterItem*> status_items(const RegisterMap& map);

/// Whether `text` is what `pattern` says, in which "*" stands for any characters or none.
[[nodiscard]] bool matches(std::string_view pattern, std::string_view text);

}  // namespace gyrotherm
