// SPDX-License-Identifier: Apache-2.0
/// One item of a chamber's register map, and its value as words on the wire. Pure.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/quantity.hpp"
#include "core/result.hpp"
#include "drivers/wires.hpp"

namespace gyrotherm::drivers {

enum class RegisterType { u16, s16, u32, s32, f32, bits, text, date_time };
enum class WordOrder { abcd, cdab, badc, dcba };  ///< −40.25 is C221 0000 in abcd and 0000 C221 in cdab

/// How sure a fact of the map is: tried on the instrument, from the vendor's manual, from a public source or an
/// excerpt, or from nothing better than one contradicted source.
enum class Confidence { verified, manual, secondary, unverified };

/// Characters, padded: ASCII, one or two a register.
struct TextForm {
  std::uint16_t characters{};
  std::uint8_t per_register = 2;
  bool low_byte_first{};     ///< of two a register
  std::uint16_t stride = 1;  ///< registers from one character (or pair) to the next
  char padding = ' ';
};

enum class DatePart { year, month, day, weekday, hour, minute, second };

/// Civil time of the instrument, one part a register, or two packed: high byte, low byte.
struct DateForm {
  struct Word {
    DatePart high{};                ///< the only one if there is no low one
    std::optional<DatePart> low{};  ///< then `high` is the high byte
  };
  std::vector<Word> words;
  std::uint16_t stride = 1;
  int century = 0;  ///< added to the year: 2000 for years of two digits
};

struct CivilTime {
  int year = 2000, month = 1, day = 1, hour = 0, minute = 0, second = 0;
  auto operator<=>(const CivilTime&) const = default;
};

/// A value written to another item together with this one's, as one block of adjacent registers.
struct Companion {
  std::string item;
  double value{};
};

struct RegisterItem {
  std::string name;  ///< "air_temperature", "set_point", "control_mode", …
  std::uint16_t address{};
  std::optional<std::uint16_t> rtu_address;  ///< where RTU links (over TCP too) have it elsewhere
  RegisterType type{};
  WordOrder order = WordOrder::abcd;
  double scale = 1;  ///< value = raw × scale + offset
  double offset = 0;
  std::optional<double> write_scale;  ///< where what is written is scaled otherwise than what is read
  /// The finest step that the controller keeps; by default the scale, a tenth of it where there are `decimals`, 0.001
  /// for f32. In its context that of its decimals.
  double resolution = 1;
  bool fahrenheit{};     ///< the register speaks °F; values of this program are °C
  bool step{};           ///< a difference: °F are converted without the 32
  std::string decimals;  ///< item that says by which power of ten the raw value is divided
  std::string unit;      ///< item whose codes "celsius" and "fahrenheit" say what the register speaks
  std::uint8_t first_bit = 0, bit_count = 1;  ///< of type bits
  TextForm text;
  DateForm date;

  bool readable = true;
  bool writable{};
  bool self_clearing{};                         ///< a command: it reads 0 again at once, and is not read back
  std::uint16_t read_count = 0;                 ///< registers that one read takes, if more than the item has
  std::optional<ReadFunction> read_function;    ///< default: holding registers
  std::optional<WriteFunction> write_function;  ///< default: 6 for one register, 16 for more
  std::string seen_in;                          ///< item that shows what was written here; default: this one
  std::optional<double> tolerance;              ///< of what is read back; default: ¾ of the resolution
  Duration seen_within{};                       ///< how long it may take to show
  bool seen_later{};                            ///< at the next reading of the chamber, to spare an exchange
  std::vector<std::string> also;                ///< items that are given the same value, before this one
  std::optional<Companion> companion;           ///< in the registers that follow, written in the same block

  std::map<std::string, std::vector<std::int64_t>> codes;  ///< meaning → its codes, the one that is written first
  std::map<std::string, std::uint8_t> flags;               ///< meaning → its bit
  std::string otherwise;                                   ///< meaning of a code that is not listed; empty: unknown
  std::map<std::string, double> sentinels;                 ///< raw values that stand for the lack of one, and why
  bool stray_zeros{};                                      ///< the instrument sends zeros for nothing
  std::optional<double> lowest, highest;                   ///< a value outside cannot be
  Confidence confidence = Confidence::unverified;
  std::string note;
};

/// What the values of one item depend on beside the item.
struct ItemContext {
  std::optional<int> decimals;
  std::optional<bool> fahrenheit;
  [[nodiscard]] bool is_empty() const { return !decimals && !fahrenheit; }
};
/// The item with its scale and unit as the instrument has them set.
[[nodiscard]] RegisterItem in_context(RegisterItem item, const ItemContext& context);

/// Words of one number (of any type but text and date_time), as on the wire; 1 or 2 of them. `value` must be finite.
/// Rounds to the nearest that the type can hold, and saturates at its range. A bit field's word has the other bits 0.
[[nodiscard]] std::vector<std::uint16_t> encode(const RegisterItem& item, double value);
/// `words` must hold the item's count. Fails with corrupted (not finite) or out_of_range (a sentinel, named, or a value
/// that cannot be).
[[nodiscard]] Result<double> decode(const RegisterItem& item, std::span<const std::uint16_t> words);
/// What the words of a *read* would be if the item held `value`: encode() with the scale of reading.
[[nodiscard]] std::vector<std::uint16_t> encode_as_read(const RegisterItem& item, double value);
/// The value that words *written* mean: decode() with the scale of writing, sentinels and limits aside.
[[nodiscard]] double decode_as_written(const RegisterItem& item, std::span<const std::uint16_t> words);
/// Raw, before scale and offset.
[[nodiscard]] double raw_value(const RegisterItem& item, std::span<const std::uint16_t> words);

/// Cut or padded to its length.
[[nodiscard]] std::vector<std::uint16_t> encode_text(const TextForm& form, std::string_view text);
/// Without the padding behind it; a character that is none of ASCII's printable ones becomes "?".
[[nodiscard]] std::string decode_text(const TextForm& form, std::span<const std::uint16_t> words);
[[nodiscard]] std::vector<std::uint16_t> encode_date(const DateForm& form, const CivilTime& time);
/// Fails with out_of_range for what no calendar has.
[[nodiscard]] Result<CivilTime> decode_date(const DateForm& form, std::span<const std::uint16_t> words);
[[nodiscard]] CivilTime civil_time_of(Duration utc);
[[nodiscard]] CivilTime later(const CivilTime& time, Duration by);

/// Registers of a number of this type.
[[nodiscard]] std::uint16_t word_count(RegisterType type);
/// Registers of any item.
[[nodiscard]] std::uint16_t word_count(const RegisterItem& item);

/// "chamber register 2782 (set_point)": of a fault.
[[nodiscard]] std::string place(const RegisterItem& item);

/// `word`, of a bit field's register that holds `present`: the other bits stay as they are.
[[nodiscard]] std::uint16_t with_other_bits(const RegisterItem& item, std::uint16_t word, std::uint16_t present);

/// Function 6 or 16 (5 for a coil) as the item says, or by the count of registers.
[[nodiscard]] WriteFunction write_function(const std::optional<WriteFunction>& said, std::size_t count);

/// The word for a code that the item holds: its meaning, or `otherwise`, or the number.
[[nodiscard]] std::string meaning(const RegisterItem& item, double value);

}  // namespace gyrotherm::drivers
