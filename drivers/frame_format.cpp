#include "drivers/frame_format.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "drivers/description.hpp"

namespace gyrotherm {

namespace {

constexpr std::size_t kMostSyncBytes = 8, kLongestFrame = 1024;

constexpr Vocabulary<FieldRole, 5> kRoles{{{"pulse_count", FieldRole::pulse_count},
                                           {"increment", FieldRole::increment},
                                           {"sequence", FieldRole::sequence},
                                           {"timestamp", FieldRole::timestamp},
                                           {"status", FieldRole::status}}};
constexpr Vocabulary<FieldType, 8> kTypes{{{"u8", FieldType::u8},
                                           {"u16", FieldType::u16},
                                           {"u24", FieldType::u24},
                                           {"u32", FieldType::u32},
                                           {"i8", FieldType::i8},
                                           {"i16", FieldType::i16},
                                           {"i24", FieldType::i24},
                                           {"i32", FieldType::i32}}};
constexpr Vocabulary<CheckKind, 5> kKinds{{{"none", CheckKind::none},
                                           {"sum8", CheckKind::sum8},
                                           {"xor8", CheckKind::xor8},
                                           {"crc16", CheckKind::crc16},
                                           {"crc32", CheckKind::crc32}}};
constexpr Vocabulary<bool, 2> kEndians{{{"little", false}, {"big", true}}};
constexpr Vocabulary<double, 4> kUnits{{{"us", 1e-6}, {"ns", 1e-9}, {"ms", 1e-3}, {"s", 1}}};

std::uint32_t word32(const TomlTable& table, const char* key, std::int64_t fallback) {
  return bounded<std::uint32_t>(table, key, table.integer(key, fallback), 0, 0xFFFFFFFF);
}

std::vector<std::byte> read_sync(const TomlTable& table) {
  std::vector<std::byte> sync;
  for (const double value : table.numbers("sync")) {
    if (value < 0 || value > 255 || value != std::floor(value))
      table.mistake("sync", fmt::format("\"sync\" holds {}, expected bytes 0 to 255", value));
    else
      sync.push_back(static_cast<std::byte>(value));
  }
  if (sync.empty() || sync.size() > kMostSyncBytes)
    table.mistake("sync", fmt::format("\"sync\" has {} bytes, expected 1 to {}", sync.size(), kMostSyncBytes));
  return sync;
}

FrameField read_field(const TomlTable& table, const FrameFormat& format) {
  FrameField field{.role = one_of(kRoles, table, "role"), .type = one_of(kTypes, table, "type")};
  field.offset = bounded<std::size_t>(table, "offset", table.integer("offset"), 0, kLongestFrame);
  field.big_endian = one_of(kEndians, table, "endian", "little");
  if (field.role == FieldRole::timestamp) field.unit_s = one_of(kUnits, table, "unit", "us");
  if (field.role == FieldRole::status) {
    field.mask = word32(table, "mask", 0xFFFFFFFF);
    field.good = word32(table, "good", 0);
  }
  if (field.offset < format.sync.size() || field.offset + byte_count(field.type) > format.length)
    table.mistake("offset", "the field lies outside the frame, or over its sync bytes");
  const bool counts = field.role == FieldRole::pulse_count || field.role == FieldRole::increment;
  if (!counts && is_signed(field.type))
    table.mistake("type", "a signed type, expected u8, u16, u24 or u32 for this role");
  return field;
}

std::size_t check_size(CheckKind kind) {
  switch (kind) {
    case CheckKind::none: return 0;
    case CheckKind::sum8:
    case CheckKind::xor8: return 1;
    case CheckKind::crc16: return 2;
    case CheckKind::crc32: return 4;
  }
  return 0;
}

FrameCheck read_check(const TomlTable& table, const FrameFormat& format) {
  FrameCheck check{.kind = one_of(kKinds, table, "kind")};
  if (check.kind == CheckKind::none) return check;
  check.from = bounded<std::size_t>(table, "from", table.integer("from", 0), 0, kLongestFrame);
  check.offset = bounded<std::size_t>(table, "offset", table.integer("offset"), 0, kLongestFrame);
  check.big_endian = one_of(kEndians, table, "endian", "little");
  if (check.kind == CheckKind::crc16 || check.kind == CheckKind::crc32) {
    check.polynomial = word32(table, "polynomial", 0);
    if (check.polynomial == 0)
      table.mistake("polynomial", "the polynomial of a crc is missing, expected a number like 0x1021");
    check.initial = word32(table, "initial", 0);
    check.reflected = table.boolean("reflected", false);
    check.final_xor = word32(table, "final_xor", 0);
  }
  if (check.from >= check.offset || check.offset + check_size(check.kind) > format.length)
    table.mistake("offset", "the check lies outside the frame, or covers nothing");
  return check;
}

void check_roles(const TomlTable& table, const FrameFormat& format) {
  for (const auto& [name, role] : kRoles) {
    const auto count =
        std::count_if(format.fields.begin(), format.fields.end(), [&](auto& f) { return f.role == role; });
    if (count > 1) table.mistake("", fmt::format("{} fields have the role \"{}\", expected one", count, name));
  }
  if ((format.find(FieldRole::pulse_count) != nullptr) == (format.find(FieldRole::increment) != nullptr))
    table.mistake("", "the frame needs either a field with the role \"pulse_count\" or one with \"increment\"");
}

}  // namespace

std::size_t byte_count(FieldType type) {
  switch (type) {
    case FieldType::u8:
    case FieldType::i8: return 1;
    case FieldType::u16:
    case FieldType::i16: return 2;
    case FieldType::u24:
    case FieldType::i24: return 3;
    case FieldType::u32:
    case FieldType::i32: return 4;
  }
  return 0;
}

bool is_signed(FieldType type) { return type >= FieldType::i8; }

const FrameField* FrameFormat::find(FieldRole role) const {
  const auto found = std::find_if(fields.begin(), fields.end(), [&](const auto& field) { return field.role == role; });
  return found == fields.end() ? nullptr : &*found;
}

FrameFormat read_frame_format(const TomlTable& table) {
  FrameFormat format;
  format.name = table.text("name");
  format.sync = read_sync(table);
  format.length = bounded<std::size_t>(table, "length", table.integer("length"), 0, kLongestFrame);
  for (const auto& field : table.tables("field")) format.fields.push_back(read_field(field, format));
  if (table.has("check")) format.check = read_check(table.table("check"), format);
  check_roles(table, format);
  return format;
}

}  // namespace gyrotherm
