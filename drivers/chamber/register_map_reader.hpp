// SPDX-License-Identifier: Apache-2.0
/// The pieces of parse_register_map(), one per table of the file. Each notes its mistakes in the table's document.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>

#include "core/toml_reader.hpp"
#include "drivers/chamber/register_map.hpp"

namespace gyrotherm::drivers {

/// What an item has where it does not say.
struct ItemDefaults {
  WordOrder order = WordOrder::abcd;
  std::int64_t address_base = 0;
  std::optional<ReadFunction> read_function;
  std::optional<WriteFunction> write_function;
};

void read_links(const TomlTable& link, RegisterMap& map);
[[nodiscard]] ItemDefaults read_item_defaults(const TomlTable& link, std::optional<WordOrder> word_order);

void read_items(const TomlTable& file, const ItemDefaults& defaults, RegisterMap& map);
/// Type, order, scale, unit and codes alone: what says how one value is written.
void read_form(const TomlTable& table, WordOrder order, RegisterItem& item);
/// The address at `key` as it is on the wire.
[[nodiscard]] std::uint16_t read_address(const TomlTable& table, const char* key, std::int64_t base);

/// The item that `key` names; nothing, and a mistake, if there is none.
[[nodiscard]] const RegisterItem* named_item(const RegisterMap& map, const TomlTable& table, const char* key,
                                             const std::string& name);
/// The first code of that meaning, a flag's bit as a mask.
[[nodiscard]] std::optional<double> code_of(const RegisterItem& item, const std::string& meaning);
/// { register, is | is_not | bits | above }
[[nodiscard]] Condition read_condition(const TomlTable& table, const RegisterMap& map);

void read_identity(const TomlTable& table, RegisterMap& map);
void read_control(const TomlTable& table, RegisterMap& map);
void read_states(const TomlTable& file, RegisterMap& map);
void read_alarms(const TomlTable& file, RegisterMap& map);
void read_limits(const TomlTable& table, RegisterMap& map);
void read_forbidden(const TomlTable& file, const ItemDefaults& defaults, RegisterMap& map);
void read_sequences(const TomlTable& table, RegisterMap& map);
void read_memory(const TomlTable& table, const ItemDefaults& defaults, RegisterMap& map);

}  // namespace gyrotherm::drivers
