// SPDX-License-Identifier: Apache-2.0
/// An item of a register map, and the encoding of its value in registers. Pure functions.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/quantity.hpp"
#include "core/result.hpp"
#include "drivers/wires.hpp"

namespace gyrotherm::drivers {

/// Largest magnitude of a code: the largest up to which a double holds every integer.
inline constexpr std::int64_t kLargestCode = std::int64_t{1} << 53;

enum class RegisterType { u16, s16, u32, s32, f32, f64, bits, text, date_time };
/// Order of the bytes in two registers, written for the value ABCD: −40.25 is C221 0000 in abcd and 0000 C221 in cdab.
/// In four registers cdab reverses the registers, and badc swaps the bytes of each.
enum class WordOrder { abcd, cdab, badc, dcba };

/// Source of a fact in the map: a test on the instrument, the vendor's manual, another public source or an excerpt, or
/// only a source that is contradicted by another one.
enum class Confidence { verified, manual, secondary, unverified };

/// Padded ASCII text with one or two characters per register.
struct TextForm {
  std::uint16_t characters{};
  std::uint8_t per_register = 2;
  /// The first of two characters is the low byte.
  bool low_byte_first{};
  std::uint16_t stride = 1;  ///< registers between characters
  char padding = ' ';
};

enum class DatePart { year, month, day, weekday, hour, minute, second };

/// Civil time in registers. A register holds one part, or two parts in its high and low byte.
struct DateForm {
  struct Word {
    /// The only part if `low` is empty, otherwise the high byte.
    DatePart high{};
    std::optional<DatePart> low{};
  };
  std::vector<Word> words;
  std::uint16_t stride = 1;
  int century = 0;  ///< added to two-digit years
};

struct CivilTime {
  int year = 2000, month = 1, day = 1, hour = 0, minute = 0, second = 0;
  auto operator<=>(const CivilTime&) const = default;
};

/// Another item and its value, written together with this item as one block of adjacent registers.
struct Companion {
  std::string item;
  double value{};
};

/// Texts of a text unit that are not codes of their item. Each text has a negative number, so that a register can hold
/// it. Any thread.
class UnknownTexts {
 public:
  /// Returns the number of a text, and assigns one to a new text: −1 to the first. Texts beyond the first 16 share a
  /// number without a text.
  [[nodiscard]] double assign_number(std::string_view text);
  [[nodiscard]] std::optional<std::string> find_text(double number) const;

 private:
  mutable std::mutex mutex_;
  std::vector<std::string> texts_;
};

struct RegisterItem {
  /// Name such as "air_temperature", "set_point" or "control_mode".
  std::string name;
  /// Question or command of a text unit, for messages; empty for a Modbus unit.
  std::string line;
  std::uint16_t address{};
  /// Address on RTU links, including RTU over TCP, if it differs.
  std::optional<std::uint16_t> rtu_address;
  RegisterType type{};
  WordOrder order = WordOrder::abcd;
  /// The value is raw × scale + offset.
  double scale = 1;
  double offset = 0;
  /// Scale of written values if it differs.
  std::optional<double> write_scale;
  /// Smallest step that the controller stores. The default is the scale, a tenth of the scale with `decimals`, or 0.001
  /// for f32. apply_context() replaces it according to the present number of decimals.
  double resolution = 1;
  /// The register contains °F; encode() and decode() convert from and to °C.
  bool fahrenheit{};
  /// The value is a temperature difference: °F are converted without the offset of 32.
  bool step{};
  /// Item whose value is the number of decimals of the raw value.
  std::string decimals;
  /// Item whose codes "celsius" and "fahrenheit" state the unit of the register.
  std::string unit;
  std::uint8_t first_bit = 0, bit_count = 1;  ///< bits
  TextForm text;
  DateForm date;

  bool readable = true;
  bool writable{};
  /// The item is a command: its register returns to 0 immediately and is not read back.
  bool self_clearing{};
  /// Number of registers per read, if more than the item has.
  std::uint16_t read_count = 0;
  std::optional<ReadFunction> read_function;  ///< default: holding registers
  /// Default: function 6 for one register, 16 for several.
  std::optional<WriteFunction> write_function;
  /// Item in which the written value is read back; this item if empty.
  std::string seen_in;
  /// Tolerance of the value read back; three quarters of the resolution if empty.
  std::optional<double> tolerance;
  /// Maximum time until the written value can be read back.
  Duration seen_within{};
  /// The write is verified by the next reading of the chamber, which saves an exchange.
  bool seen_later{};
  /// Items to which the same value is written before this one.
  std::vector<std::string> also;
  /// Item that is written in the same block, in the registers after this one.
  std::optional<Companion> companion;

  /// Codes, keyed by their meaning. If a meaning has several codes, the first one is written.
  std::map<std::string, std::vector<std::int64_t>> codes;
  std::map<std::string, std::uint8_t> flags;  ///< bit numbers, keyed by their meaning
  /// Meaning of an unlisted code; unknown if empty.
  std::string otherwise;
  /// Set if the codes are texts. All copies of the item share it.
  std::shared_ptr<UnknownTexts> unknown_texts;
  /// Raw values that mark a missing value, keyed by the reason.
  std::map<std::string, double> sentinels;
  /// The instrument sometimes returns zero instead of the value.
  bool stray_zeros{};
  /// Bounds of possible values.
  std::optional<double> lowest, highest;
  Confidence confidence = Confidence::unverified;
  std::string note;
};

/// Properties of an item that other registers determine.
struct ItemContext {
  std::optional<int> decimals;
  std::optional<bool> fahrenheit;
  [[nodiscard]] bool is_empty() const { return !decimals && !fahrenheit; }
};
/// Returns the item with the scale, resolution and unit that the context determines.
[[nodiscard]] RegisterItem apply_context(RegisterItem item, const ItemContext& context);

/// Returns the words of a number on the wire: four for f64, otherwise one or two. The type must not be text or
/// date_time, and `value` must be finite. The value is rounded to the nearest one of the type and saturates at the
/// limits of the type. In the word of a bit field the other bits are 0.
[[nodiscard]] std::vector<std::uint16_t> encode(const RegisterItem& item, double value);
/// Decodes `words`, which must have word_count() elements. Fails with corrupted if the value is not finite, and with
/// out_of_range if it is a sentinel, which is named, or outside `lowest` and `highest`.
[[nodiscard]] Result<double> decode(const RegisterItem& item, std::span<const std::uint16_t> words);
/// Returns the words that a read of the item returns if its value is `value`: encode() with `scale` in place of
/// `write_scale`.
[[nodiscard]] std::vector<std::uint16_t> encode_as_read(const RegisterItem& item, double value);
/// Returns the value of words that were written: decode() with the write scale, ignoring sentinels and limits.
[[nodiscard]] double decode_as_written(const RegisterItem& item, std::span<const std::uint16_t> words);
/// Returns the raw value, before scale and offset.
[[nodiscard]] double raw_value(const RegisterItem& item, std::span<const std::uint16_t> words);

/// Encodes a text, truncated or padded to the length of the field.
[[nodiscard]] std::vector<std::uint16_t> encode_text(const TextForm& form, std::string_view text);
/// Decodes a text without its padding. Characters outside printable ASCII become "?".
[[nodiscard]] std::string decode_text(const TextForm& form, std::span<const std::uint16_t> words);
[[nodiscard]] std::vector<std::uint16_t> encode_date(const DateForm& form, const CivilTime& time);
/// Decodes a date. Fails with out_of_range for an impossible date or time.
[[nodiscard]] Result<CivilTime> decode_date(const DateForm& form, std::span<const std::uint16_t> words);
[[nodiscard]] CivilTime to_civil_time(Duration utc);
/// Returns the time `by` after `time`, without time zones.
[[nodiscard]] CivilTime add_duration(const CivilTime& time, Duration by);

/// Returns the number of registers of a number of this type.
[[nodiscard]] std::uint16_t word_count(RegisterType type);
/// Returns the number of registers of any item.
[[nodiscard]] std::uint16_t word_count(const RegisterItem& item);

/// Returns the item's location for faults: "chamber register 2782 (set_point)" or "chamber item set_point (TEMP?)".
[[nodiscard]] std::string place(const RegisterItem& item);

/// Returns `word` with all bits outside the bit field `item` taken from `present`.
[[nodiscard]] std::uint16_t merge_bits(const RegisterItem& item, std::uint16_t word, std::uint16_t present);

/// Returns `specified` if it is set, otherwise function 6 for one register and 16 for more.
[[nodiscard]] WriteFunction write_function(const std::optional<WriteFunction>& specified, std::size_t count);

/// Returns the lower 32 bits of a value, of a negative one in two's complement. Returns nothing for a value whose
/// magnitude exceeds kLargestCode, and for NaN.
[[nodiscard]] std::optional<std::uint32_t> lower_bits(double value);
/// Returns the meaning of a code: its name in the map, `otherwise` if that is set, the text that has no name, or the
/// number as text.
[[nodiscard]] std::string meaning(const RegisterItem& item, double value);
/// Describes two names of one code: "constant and standby are both 0". If the codes are texts, `texts` has them at the
/// positions that are the codes. Returns an empty text if all codes differ.
[[nodiscard]] std::string describe_shared_code(const RegisterItem& item, std::span<const std::string> texts = {});
/// Describes a code or flag of a readable item that no value can have: it exceeds the type, is a sentinel, is outside
/// the possible values, or shares its name. Returns an empty text if there is none, or if other registers determine the
/// scale.
[[nodiscard]] std::string describe_unreachable_name(const RegisterItem& item);
/// Describes two flags on one bit: "fan and heater are both bit 3". Returns an empty text if all bits differ.
[[nodiscard]] std::string describe_shared_bit(const RegisterItem& item);

}  // namespace gyrotherm::drivers
