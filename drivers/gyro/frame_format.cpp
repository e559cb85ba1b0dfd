// SPDX-License-Identifier: Apache-2.0
#include "drivers/gyro/frame_format.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/toml_reader.hpp"

namespace gyrotherm::drivers {
namespace {

constexpr std::size_t kMostSyncBytes = 8;
constexpr Vocabulary<bool, 2> kClocks{{{"device", false}, {"sequence", true}}};

/// Reads a list of whole numbers from 0 to `highest`. `what` is their plural in the message.
std::vector<std::uint32_t> read_whole_numbers(const TomlTable& table, const char* key, double highest,
                                              const char* what) {
  std::vector<std::uint32_t> found;
  for (const double value : table.numbers(key)) {
    if (!(value >= 0 && value <= highest) || value != std::floor(value))
      table.note_error(key, fmt::format("\"{}\" contains {}, expected {} from 0 to {:.0f}", key, value, what, highest));
    else
      found.push_back(static_cast<std::uint32_t>(value));
  }
  return found;
}

HeadNumber read_head_number(const TomlTable& table) {
  HeadNumber number;
  number.offset = whole<std::size_t>(table, "offset", 0, 255);
  number.bytes = whole<std::size_t>(table, "bytes", 1, 4, 1);
  number.big_endian = one_of(kEndians, table, "endian", "little");
  return number;
}

void read_variants(const TomlTable& table, FrameFormat& format) {
  for (const auto& each : table.tables("message")) {
    FrameVariant variant;
    variant.id = whole<std::uint32_t>(each, "id", 0, 0xFFFFFFFF);
    const auto fallback = format.length_at ? 0 : static_cast<std::int64_t>(format.length);
    variant.length = whole<std::size_t>(each, "length", 0, kLongestFrame, fallback);
    if (variant.length < format.head_size() && (variant.length != 0 || !format.length_at))
      each.note_error("length", fmt::format("{} bytes, expected at least the frame's head", variant.length));
    if (each.has("check"))
      variant.check = read_frame_check(each.table("check"), variant.length ? variant.length : format.length, false);
    each.ignore("meaning");
    format.variants.push_back(variant);
  }
  if (!format.variants.empty() && !format.id)
    table.note_error("message", "several messages and no id, expected a table [frame.id]");
}

void read_framing(const TomlTable& table, FrameFormat& format) {
  format.sync = read_bytes(table, "sync", kMostSyncBytes);
  format.tail = read_bytes(table, "tail", kMostSyncBytes);
  if (table.has("id")) format.id = read_head_number(table.table("id"));
  if (table.has("length_at")) {
    const auto at = table.table("length_at");
    format.length_at = read_head_number(at);
    format.length_plus = whole<std::size_t>(at, "plus", 0, kLongestFrame, 0);
  }
  const bool has_length_per_message = format.id && !table.has("length");
  format.length =
      bounded<std::size_t>(table, "length", has_length_per_message ? 1 : table.integer("length"), 1, kLongestFrame);
  read_variants(table, format);
  if (has_length_per_message && format.variants.empty())
    table.note_error("length", "no length, expected one here or in every [[frame.message]]");
  if (has_length_per_message && !format.variants.empty()) format.length = format.variants.front().length;
  if (format.head_size() > format.length) table.note_error("length", "the frame is shorter than its head");
  format.lock_frames = whole<std::size_t>(table, "lock_frames", 0, 1000, 0);
  if (format.sync.empty() && format.lock_frames == 0 && format.variants.empty())
    table.note_error("sync", "\"sync\" is empty, expected sync bytes, message ids or \"lock_frames\"");
  if (format.length_at && format.lock_frames > 0)
    table.note_error("lock_frames", "allowed only for frames of fixed length");
}

std::size_t shortest_frame(const FrameFormat& format) {
  auto shortest = format.length;
  for (const auto& variant : format.variants)
    if (variant.length != 0 && !variant.check) shortest = std::min(shortest, variant.length);
  return shortest;
}

constexpr std::int64_t kMostCounts = std::int64_t{1} << 62;

constexpr auto kFieldTypes = make_vocabulary<FieldType::u8, FieldType::f64>("u8", "u16", "u24", "u32", "u64", "i8",
                                                                            "i16", "i24", "i32", "i64", "f32", "f64");
constexpr auto kWordTypes = make_vocabulary<FieldType::hexadecimal, FieldType::decimal>(
    "hexadecimal", "signed_hexadecimal", "integer", "decimal");
constexpr Vocabulary<double, 4> kTimes{{{"us", 1e-6}, {"ns", 1e-9}, {"ms", 1e-3}, {"s", 1}}};
constexpr auto kMeanings =
    make_vocabulary<StatusMeaning::invalid, StatusMeaning::mismatch>("invalid", "warning", "reject", "mismatch");

/// Reads the type, offset, byte order and bit range of a field.
void read_bit_layout(const TomlTable& table, const FrameFormat& format, FrameField& field) {
  if (format.line) {
    field.type = one_of(kWordTypes, table, "type");
    field.offset = whole<std::ptrdiff_t>(table, "word", 0, static_cast<std::int64_t>(format.line->words) - 1);
    field.bits = 64;
  } else {
    field.type = one_of(kFieldTypes, table, "type");
    field.offset = whole<std::ptrdiff_t>(table, "offset", -kLongestFrame, kLongestFrame);
    field.big_endian = one_of(kEndians, table, "endian", "little");
    field.bits_per_byte = whole<unsigned>(table, "bits_per_byte", 7, 8, 8);
    const auto size = static_cast<std::int64_t>(byte_count(field.type));
    field.bytes = whole<std::size_t>(table, "bytes", 1, field.bits_per_byte == 7 ? 9 : 8, size);
    field.bits =
        static_cast<unsigned>(std::min<std::size_t>(field.bits_per_byte * field.bytes, 8 * byte_count(field.type)));
  }
  if (is_real(field.type)) {
    if (field.bits_per_byte != 8 || (!format.line && field.bytes != byte_count(field.type)))
      table.note_error("type", "a floating-point number needs whole bytes, expected an integer type");
    return;
  }
  const auto width = static_cast<std::int64_t>(field.bits);
  field.low_bit = whole<unsigned>(table, "bit", 0, width - 1, 0);
  field.bits = whole<unsigned>(table, "bits", 1, width - field.low_bit, width - field.low_bit);
}

/// Reads the conditions under which a frame contains the field.
void read_presence(const TomlTable& table, const FrameFormat& format, FrameField& field) {
  field.ids = read_whole_numbers(table, "ids", 0xFFFFFFFF, "message ids");
  if (!field.ids.empty() && !format.id) table.note_error("ids", "the messages have no id, expected a table [frame.id]");
  for (const auto id : field.ids)
    if (!format.variants.empty() && std::none_of(format.variants.begin(), format.variants.end(),
                                                 [&](const auto& variant) { return variant.id == id; }))
      table.note_error("ids", fmt::format("no message has the id {:#x}", id));
  field.every = whole<std::uint32_t>(table, "every", 1, 65536, 1);
  field.turn = whole<std::uint32_t>(table, "turn", 0, field.every - 1, 0);
  if (format.line || is_real(field.type) || !table.has("when")) return;
  const auto when = table.table("when");
  field.when_mask = read_uint32(when, "mask", 0);
  field.when_value = read_uint32(when, "value", 0);
  const auto width = static_cast<unsigned>(std::min<std::size_t>(64, field.bits_per_byte * field.bytes));
  if (field.when_mask == 0 || (field.when_value & ~field.when_mask) != 0 ||
      (width < 32 && field.when_mask >> width != 0))
    when.note_error("mask", "the mask is empty, has bits outside the field, or does not contain the value");
}

void check_field_position(const TomlTable& table, const FrameFormat& format, const FrameField& field) {
  if (format.line) return;
  bool fits = field.offset < 0 || static_cast<std::size_t>(field.offset) >= format.sync.size();
  const auto fits_in = [&](std::size_t length) {
    const auto position = find_field_position(field, length);
    return position && *position >= format.sync.size();
  };
  if (format.variants.empty()) fits = fits && fits_in(format.length);
  for (const auto& variant : format.variants)
    if (field.ids.empty() || std::find(field.ids.begin(), field.ids.end(), variant.id) != field.ids.end())
      fits = fits && fits_in(variant.length != 0 ? variant.length : format.length);
  if (!fits) table.note_error("offset", "the field lies outside the frame, or over its sync bytes");
}

ExactScale read_scale(const TomlTable& table) {
  ExactScale scale;
  scale.numerator = whole<std::int64_t>(table, "numerator", -kMostCounts, kMostCounts, 1);
  scale.denominator = whole<std::int64_t>(table, "denominator", 1, kMostCounts, 1);
  scale.power_of_two = whole<int>(table, "power_of_two", -200, 200, 0);
  if (scale.numerator == 0) table.note_error("numerator", "the scale is zero, expected another number");
  return scale;
}

void read_status(const TomlTable& table, FrameField& field) {
  const bool has_rules = table.has("rule");
  field.mask = read_uint32(table, "mask", has_rules && !table.has("good") ? 0 : 0xFFFFFFFF);
  field.good = read_uint32(table, "good", 0);
  const auto own_bits = field.bits < 32 ? (std::uint32_t{1} << field.bits) - 1 : 0xFFFFFFFF;
  const auto check_mask = [&](const TomlTable& owner, std::uint32_t mask) {
    if ((mask & ~own_bits) != 0)
      owner.note_error(
          "mask", fmt::format("the mask {:#x} has bits that are never set: the field has {} bits", mask, field.bits));
  };
  if (table.has("mask")) check_mask(table, field.mask);
  field.mask &= own_bits;
  for (const auto& each : table.tables("rule")) {
    StatusRule rule;
    rule.mask = read_uint32(each, "mask", 0);
    check_mask(each, rule.mask);
    auto good = read_whole_numbers(each, "one_of", 0xFFFFFFFF, "values of the status");
    if (good.empty()) good = {read_uint32(each, "good", 0)};
    rule.good = good.front();
    rule.also_good.assign(good.begin() + 1, good.end());
    rule.verdict = one_of(kMeanings, each, "verdict", "invalid");
    rule.meaning = each.text("meaning");
    const bool fits =
        std::all_of(good.begin(), good.end(), [&](std::uint32_t each_good) { return (each_good & ~rule.mask) == 0; });
    if (rule.mask == 0 || !fits) each.note_error("mask", "the mask is empty, or does not contain the good value");
    field.rules.push_back(std::move(rule));
  }
  if ((field.good & ~field.mask) != 0)
    table.note_error("good", "\"good\" has bits outside \"mask\": no frame would be good");
}

/// Returns the number of values of a counter before it wraps, or 0 for 2^64. `modulus` in the file is in units of
/// `counts_per_unit`.
std::uint64_t read_range(const TomlTable& table, const FrameField& field, double counts_per_unit) {
  const auto modulus = table.integer("modulus", 0);
  if (table.has("modulus") && modulus < 2) table.note_error("modulus", "expected a whole number from 2");
  if (modulus >= 2) return static_cast<std::uint64_t>(std::min(static_cast<double>(modulus) * counts_per_unit, 9e18));
  return field.bits >= 63 || is_real(field.type) ? 0 : std::uint64_t{1} << field.bits;
}

void read_timestamp(const TomlTable& table, FrameField& field) {
  const double unit_s = one_of(kTimes, table, "unit", "us");
  if (is_real(field.type)) {
    field.scale.denominator = 1;
    field.unit_s = 1e-9;
    field.range = read_range(table, field, unit_s / field.unit_s);
    if (unit_s != 1) table.note_error("unit", "a floating-point time must be in seconds, expected \"s\"");
    return;
  }
  field.unit_s = field.scale.of(unit_s);
  if (field.unit_s <= 0) table.note_error("scale", "time runs backwards, expected a positive scale");
  field.range = read_range(table, field, 1);
}

void read_gyro_field(const TomlTable& table, FrameField& field) {
  field.axis = table.text("axis", "");
  field.unit = table.text("unit", "");
  const bool has_known_unit = arcsec_per(field.unit, field.role).has_value();
  const bool is_pulse_field = field.unit.empty() && !is_real(field.type) &&
                              (field.role == FieldRole::pulse_count || field.role == FieldRole::increment);
  if (!has_known_unit && !is_pulse_field)
    table.note_error("unit", field.role == FieldRole::rate ? "expected \"rad/s\", \"deg/s\" or \"deg/h\""
                                                           : "expected \"rad\", \"deg\" or \"arcsec\"");
  field.range = field.bits >= 63 || is_real(field.type) ? 0 : std::uint64_t{1} << field.bits;
  if (field.role == FieldRole::pulse_count) {
    field.range = read_range(table, field, 1);
    if (is_real(field.type)) table.note_error("type", "expected an integer type for a count of pulses");
  }
  if (field.role != FieldRole::integrated_angle) return;
  field.wraps_at = table.number("wraps_at", is_real(field.type) ? 0 : field.scale.of(static_cast<double>(field.range)));
  if (!(field.wraps_at > 0))
    table.note_error("wraps_at", "expected the angle at which it wraps around, in the field's unit");
}

/// Reads the step of a sequence from one frame to the next: `step`, or `ticks_hz` divided by the frame rate.
std::uint64_t read_step(const TomlTable& table, double rate_hz) {
  if (!table.has("ticks_hz")) return whole<std::uint64_t>(table, "step", 1, 65536, 1);
  if (table.has("step")) table.note_error("step", "\"step\" follows from \"ticks_hz\", expected only one of them");
  const double steps = table.number("ticks_hz") / rate_hz;
  if (steps >= 1 && steps <= 65536 && steps == std::floor(steps)) return static_cast<std::uint64_t>(steps);
  table.note_error("ticks_hz", fmt::format("expected a whole multiple of the frames' rate, {:g} Hz", rate_hz));
  return 1;
}

void read_role(const TomlTable& table, double rate_hz, FrameField& field) {
  if (is_gyro(field.role)) return read_gyro_field(table, field);
  const bool is_whole = !is_real(field.type) && !(is_signed(field.type) && !is_word(field.type)) && field.bits <= 32;
  switch (field.role) {
    case FieldRole::sequence:
      field.range = read_range(table, field, 1);
      field.step = read_step(table, rate_hz);
      break;
    case FieldRole::timestamp: read_timestamp(table, field); break;
    case FieldRole::status: read_status(table, field); break;
    default: field.unit = table.text("unit", ""); break;
  }
  const bool is_sequence_or_status = field.role == FieldRole::sequence || field.role == FieldRole::status;
  const bool is_integer_time = field.role == FieldRole::timestamp && !is_real(field.type);
  if ((is_sequence_or_status && !is_whole && !is_word(field.type)) || (is_sequence_or_status && is_real(field.type)) ||
      (is_integer_time && is_signed(field.type) && !is_word(field.type)))
    table.note_error("type", "expected an unsigned integer type; a sequence or status has at most 32 bits");
}

/// Reads one field. All other keys of `format` must have been read before.
FrameField read_frame_field(const TomlTable& table, const FrameFormat& format) {
  FrameField field{.role = one_of(kFieldRoles, table, "role")};
  read_bit_layout(table, format, field);
  read_presence(table, format, field);
  check_field_position(table, format, field);
  if (table.has("scale")) field.scale = read_scale(table.table("scale"));
  field.zero = table.number("zero", 0);
  read_role(table, format.rate_hz, field);
  field.name = table.text("name", field.axis.empty() ? keyword_for(kFieldRoles, field.role) : "gyro_" + field.axis);
  table.ignore("confidence");
  return field;
}

void read_header(const TomlTable& table, LineFormat& format) {
  if (!table.has("header_words") && !table.has("header_end")) return;
  format.header_words = whole<std::size_t>(table, "header_words", 1, 255);
  format.header_end = table.text("header_end");
  if (format.header_end.empty() || format.header_end.find_first_of(format.separators) != std::string::npos)
    table.note_error("header_end",
                     "expected the text that ends the header, such as \";\"; it must not contain a separator");
  if (format.header_words >= format.words)
    table.note_error("header_words", "no token follows the header, expected fewer than \"words\"");
}

/// Reads the [frame.line] table.
LineFormat read_line_format(const TomlTable& table) {
  LineFormat format;
  format.starts_with = table.text("starts_with", "");
  format.terminator = table.text("terminator", "\r\n");
  if (format.terminator.empty()) table.note_error("terminator", "empty, expected the end of a line, like \"\\r\\n\"");
  format.separators = table.text("separators", " ");
  if (format.separators.empty()) table.note_error("separators", "empty, expected the characters between words");
  format.merges = table.boolean("merges", true);
  format.mark = table.text("mark", "");
  format.words = whole<std::size_t>(table, "words", 1, 256);
  format.longest = whole<std::size_t>(table, "longest", 1, 4096, 256);
  read_header(table, format);
  return format;
}

}  // namespace

std::vector<std::byte> read_bytes(const TomlTable& table, const char* key, std::size_t most) {
  std::vector<std::byte> bytes;
  for (const auto value : read_whole_numbers(table, key, 255, "bytes")) bytes.push_back(static_cast<std::byte>(value));
  if (bytes.size() > most)
    table.note_error(key, fmt::format("\"{}\" has {} bytes, expected at most {}", key, bytes.size(), most));
  return bytes;
}

std::size_t FrameFormat::head_size() const {
  auto head = sync.size();
  for (const auto& number : {id, length_at})
    if (number) head = std::max(head, number->offset + number->bytes);
  return head;
}

FrameFormat read_frame_format(const TomlTable& table, const std::vector<std::string>& axes,
                              std::optional<double> rate_hz) {
  FrameFormat format;
  format.name = table.text("name");
  if (table.has("line")) {
    format.line = read_line_format(table.table("line"));
    format.length = format.line->longest;
  } else {
    read_framing(table, format);
  }
  format.rate_hz = rate_hz.value_or(table.number("rate_hz", 0));
  if (!(format.rate_hz >= 0)) table.note_error("rate_hz", "expected a positive number of frames a second");
  format.clocked_by_sequence = one_of(kClocks, table, "clock", "device");
  const auto fields = table.tables("field");
  for (const auto& field : fields) format.fields.push_back(read_frame_field(field, format));
  if (table.has("check"))
    format.check = read_frame_check(table.table("check"), shortest_frame(format), format.line.has_value());
  if (format.line && (format.check.kind == CheckKind::none) != format.line->mark.empty())
    table.note_error("line", "expected both a check and \"mark\", the text before it, or neither");
  assign_slots(table, fields, axes, format);
  return format;
}

}  // namespace gyrotherm::drivers
