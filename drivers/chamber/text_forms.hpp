// SPDX-License-Identifier: Apache-2.0
/// Agreement of the items of a text unit with the forms of their fields: codes, flags and sentinels that a field can
/// produce, and the sign of hexadecimal numbers.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "core/toml_reader.hpp"
#include "drivers/chamber/register_map.hpp"
#include "drivers/chamber/text_link.hpp"
#include "drivers/line/text_template.hpp"

namespace gyrotherm::drivers {

/// Codes of an item as the file states them: numbers, or texts on the line.
struct WrittenCodes {
  std::map<std::string, std::vector<std::int64_t>> numbers;
  std::map<std::string, std::vector<std::string>> texts;
};

/// Returns whether a field of this form is a text in the virtual registers.
[[nodiscard]] bool is_text_form(const FieldForm& form);

/// Sets the codes of an item whose field has this form. Returns the texts of a field that is a text; the codes are then
/// their positions. Notes an error for a code that the field cannot produce.
[[nodiscard]] CodeTexts assign_codes(const TomlTable& table, const FieldForm& form, const WrittenCodes& written,
                                     RegisterItem& item);
/// Notes an error for a flag or sentinel that the field cannot produce.
void check_flags_and_sentinels(const TomlTable& table, const FieldForm& form, const RegisterItem& item);

/// Largest number of bits of a value.
inline constexpr int kBitsOfAnyItem = 32;
/// Returns the number of bits of the field of an item, or kBitsOfAnyItem if the field has no such limit.
[[nodiscard]] int count_bits(const RegisterMap& map, const RegisterItem& item);

/// Selects the items whose hexadecimal fields have no sign: those with codes or flags, and those without unit and scale
/// that a condition compares with "bits" or "above". An item with a negative code keeps the sign. Converts the
/// sentinels to the numbers that the fields produce.
void select_unsigned_fields(RegisterMap& map);

}  // namespace gyrotherm::drivers
