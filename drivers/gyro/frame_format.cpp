#include "drivers/gyro/frame_format.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "core/toml_reader.hpp"
#include "drivers/gyro/frame_field_reader.hpp"

namespace gyrotherm {

namespace {

constexpr std::size_t kMostSyncBytes = 8;
constexpr Vocabulary<bool, 2> kClocks{{{"device", false}, {"sequence", true}}};

std::vector<std::byte> read_bytes(const TomlTable& table, const char* key) {
  std::vector<std::byte> bytes;
  for (const auto value : read_whole_numbers(table, key, 255, "bytes")) bytes.push_back(static_cast<std::byte>(value));
  if (bytes.size() > kMostSyncBytes)
    table.mistake(key, fmt::format("\"{}\" has {} bytes, expected at most {}", key, bytes.size(), kMostSyncBytes));
  return bytes;
}

HeadNumber read_head_number(const TomlTable& table) {
  HeadNumber number;
  number.offset = bounded<std::size_t>(table, "offset", table.integer("offset"), 0, 255);
  number.bytes = bounded<std::size_t>(table, "bytes", table.integer("bytes", 1), 1, 4);
  number.big_endian = one_of(kEndians, table, "endian", "little");
  return number;
}

/// Bytes that must be seen before a frame's length is known.
std::size_t head_size(const FrameFormat& format) {
  auto head = format.sync.size();
  for (const auto& number : {format.id, format.length_at})
    if (number) head = std::max(head, number->offset + number->bytes);
  return head;
}

void read_variants(const TomlTable& table, FrameFormat& format) {
  for (const auto& each : table.tables("message")) {
    FrameVariant variant;
    variant.id = bounded<std::uint32_t>(each, "id", each.integer("id"), 0, 0xFFFFFFFF);
    const auto fallback = format.length_at ? 0 : static_cast<std::int64_t>(format.length);
    variant.length = bounded<std::size_t>(each, "length", each.integer("length", fallback), 0, kLongestFrame);
    if (variant.length < head_size(format) && (variant.length != 0 || !format.length_at))
      each.mistake("length", fmt::format("{} bytes, expected at least the frame's head", variant.length));
    if (each.has("check"))
      variant.check = read_frame_check(each.table("check"), variant.length ? variant.length : format.length, false);
    each.ignore("meaning");
    format.variants.push_back(std::move(variant));
  }
  if (!format.variants.empty() && !format.id)
    table.mistake("message", "several messages and no id, expected a table [frame.id]");
}

void read_framing(const TomlTable& table, FrameFormat& format) {
  format.sync = read_bytes(table, "sync");
  format.tail = read_bytes(table, "tail");
  if (table.has("id")) format.id = read_head_number(table.table("id"));
  if (table.has("length_at")) {
    const auto at = table.table("length_at");
    format.length_at = read_head_number(at);
    format.length_plus = bounded<std::size_t>(at, "plus", at.integer("plus", 0), 0, kLongestFrame);
  }
  const bool by_message = format.id && !table.has("length");
  format.length = bounded<std::size_t>(table, "length", by_message ? 1 : table.integer("length"), 1, kLongestFrame);
  read_variants(table, format);
  if (by_message && format.variants.empty())
    table.mistake("length", "no length, expected one here or in every [[frame.message]]");
  if (by_message && !format.variants.empty()) format.length = format.variants.front().length;
  if (head_size(format) > format.length) table.mistake("length", "the frame is shorter than its head");
  format.lock_frames = bounded<std::size_t>(table, "lock_frames", table.integer("lock_frames", 0), 0, 1000);
  if (format.sync.empty() && format.lock_frames == 0 && format.variants.empty())
    table.mistake("sync", "\"sync\" has 0 bytes: expected some, message ids, or \"lock_frames\"");
  if (format.length_at && format.lock_frames > 0)
    table.mistake("lock_frames", "frames in a row are for frames of fixed length");
}

std::size_t shortest_frame(const FrameFormat& format) {
  auto shortest = format.length;
  for (const auto& variant : format.variants)
    if (variant.length != 0 && !variant.check) shortest = std::min(shortest, variant.length);
  return shortest;
}

/// No message may have both.
bool collide(const FrameField& one, const FrameField& other) {
  if (one.ids.empty() || other.ids.empty()) return true;
  return std::any_of(one.ids.begin(), one.ids.end(),
                     [&](auto id) { return std::find(other.ids.begin(), other.ids.end(), id) != other.ids.end(); });
}

bool is_single(FieldRole role) {
  return is_gyro(role) || role == FieldRole::sequence || role == FieldRole::timestamp || role == FieldRole::temperature;
}

void check_roles(const TomlTable& table, const FrameFormat& format) {
  bool two_kinds = false;
  for (const auto& field : format.fields) {
    if (!is_single(field.role)) continue;
    const auto same = std::count_if(format.fields.begin(), format.fields.end(), [&](const auto& other) {
      return other.role == field.role && collide(field, other) && other.every == field.every &&
             other.turn == field.turn;
    });
    if (same > 1)
      table.mistake("", fmt::format("{} fields have the role \"{}\", expected one", same, name(field.role)));
    two_kinds = two_kinds || (is_gyro(field.role) && field.role != format.gyro()->role);
  }
  if (!format.gyro() || two_kinds)
    table.mistake("",
                  "the frame needs either a field with the role \"pulse_count\" or one with \"increment\", \"rate\" or "
                  "\"integrated_angle\"");
  if (format.clocked_by_sequence && (!format.find(FieldRole::sequence) || format.rate_hz <= 0))
    table.mistake("clock", "the clock is the sequence, expected a field with that role and \"rate_hz\"");
}

/// Fields of other axes are values like any other.
void choose_axis(const TomlTable& table, const std::string& wanted, FrameFormat& format) {
  std::vector<std::string> axes;
  for (const auto& field : format.fields)
    if (is_gyro(field.role) && !field.axis.empty()) axes.push_back(field.axis);
  format.axis = wanted.empty() ? table.text("axis", axes.empty() ? "" : axes.front()) : wanted;
  if (!wanted.empty()) table.ignore("axis");
  if (!format.axis.empty() && std::find(axes.begin(), axes.end(), format.axis) == axes.end())
    table.mistake("axis", fmt::format("no gyro's field has the axis \"{}\"", format.axis));
  for (auto& field : format.fields)
    if (is_gyro(field.role) && field.axis != format.axis) field.role = FieldRole::value;
}

}  // namespace

const FrameField* FrameFormat::find(FieldRole role) const {
  const auto found = std::find_if(fields.begin(), fields.end(), [&](const auto& field) { return field.role == role; });
  return found == fields.end() ? nullptr : &*found;
}

const FrameField* FrameFormat::gyro() const {
  const auto found = std::find_if(fields.begin(), fields.end(), [](const auto& field) { return is_gyro(field.role); });
  return found == fields.end() ? nullptr : &*found;
}

FrameFormat read_frame_format(const TomlTable& table, const std::string& axis) {
  FrameFormat format;
  format.name = table.text("name");
  if (table.has("line")) {
    format.line = read_line_format(table.table("line"));
    format.length = format.line->longest;
  } else {
    read_framing(table, format);
  }
  format.rate_hz = table.number("rate_hz", 0);
  if (!(format.rate_hz >= 0)) table.mistake("rate_hz", "expected a positive number of frames a second");
  format.clocked_by_sequence = one_of(kClocks, table, "clock", "device");
  for (const auto& field : table.tables("field")) format.fields.push_back(read_frame_field(field, format));
  if (table.has("check"))
    format.check = read_frame_check(table.table("check"), shortest_frame(format), format.line.has_value());
  if (format.line && (format.check.kind == CheckKind::none) != format.line->mark.empty())
    table.mistake("line", "a check and the mark before it belong together");
  choose_axis(table, axis, format);
  check_roles(table, format);
  return format;
}

}  // namespace gyrotherm
