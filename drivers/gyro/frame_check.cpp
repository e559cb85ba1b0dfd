// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <bit>
#include <string>
#include <utility>
#include <vector>

#include "drivers/gyro/frame_format.hpp"

namespace gyrotherm::drivers {

namespace {

struct CheckKeyword {
  CheckKind kind;
  int width;  // width of a CRC, or 0
};
constexpr Vocabulary<CheckKeyword, 12> kCheckKinds{{{"none", {CheckKind::none, 0}},
                                                    {"sum8", {CheckKind::sum8, 0}},
                                                    {"sum16", {CheckKind::sum16, 0}},
                                                    {"fletcher8", {CheckKind::fletcher8, 0}},
                                                    {"fletcher16", {CheckKind::fletcher16, 0}},
                                                    {"xor8", {CheckKind::xor8, 0}},
                                                    {"crc", {CheckKind::crc, 0}},
                                                    {"crc8", {CheckKind::crc, 8}},
                                                    {"crc16", {CheckKind::crc, 16}},
                                                    {"crc32", {CheckKind::crc, 32}},
                                                    {"odd_parity", {CheckKind::odd_parity, 0}},
                                                    {"even_parity", {CheckKind::even_parity, 0}}}};

Crc read_crc(const TomlTable& table, int width) {
  Crc model;
  model.width = width != 0 ? width : whole<int>(table, "width", 3, 32);
  model.polynomial = read_uint32(table, "polynomial", 0);
  if (model.polynomial == 0)
    table.note_error("polynomial", "the polynomial of a crc is missing, expected a number like 0x1021");
  model.initial = read_uint32(table, "initial", 0);
  model.reflected = table.boolean("reflected", false);
  model.reflected_out = table.boolean("reflected_out", model.reflected);
  model.final_xor = read_uint32(table, "final_xor", 0);
  return model;
}

bool is_parity(CheckKind kind) { return kind == CheckKind::odd_parity || kind == CheckKind::even_parity; }

/// Returns a position from the start of a frame. A position before the start remains negative.
std::ptrdiff_t absolute_position(std::ptrdiff_t position, std::size_t length) {
  return position < 0 ? position + static_cast<std::ptrdiff_t>(length) : position;
}

struct Extent {
  std::size_t from, to, stored;
};

/// Returns the extent of the check in a frame of this length, or nothing if it does not fit or covers nothing.
std::optional<Extent> find_extent(const FrameCheck& check, std::size_t length) {
  const auto from = absolute_position(check.from, length), to = absolute_position(check.to, length),
             stored = absolute_position(check.offset, length), end = static_cast<std::ptrdiff_t>(length);
  if (from < 0 || from >= to || to > end || stored < 0) return std::nullopt;
  if (stored + static_cast<std::ptrdiff_t>(byte_count(check)) > end) return std::nullopt;
  return Extent{static_cast<std::size_t>(from), static_cast<std::size_t>(to), static_cast<std::size_t>(stored)};
}

bool has_odd_parity(std::span<const std::byte> bytes) { return std::popcount(xor8(bytes)) % 2 != 0; }

}  // namespace

std::size_t byte_count(const FrameCheck& check) {
  switch (check.kind) {
    case CheckKind::none: return 0;
    case CheckKind::sum8:
    case CheckKind::xor8:
    case CheckKind::odd_parity:
    case CheckKind::even_parity: return 1;
    case CheckKind::sum16:
    case CheckKind::fletcher8:
    case CheckKind::fletcher16: return 2;
    case CheckKind::crc: return static_cast<std::size_t>(check.model.width + 7) / 8;
  }
  return 0;
}

FrameCheck read_frame_check(const TomlTable& table, std::size_t shortest, bool in_line) {
  const auto keyword = one_of(kCheckKinds, table, "kind");
  FrameCheck check{.kind = keyword.kind};
  if (check.kind == CheckKind::none) return check;
  if (check.kind == CheckKind::crc) check.model = read_crc(table, keyword.width);
  if (check.kind == CheckKind::sum8) check.is_negated = table.boolean("negated", false);
  check.from = whole<std::ptrdiff_t>(table, "from", -kLongestFrame, kLongestFrame, 0);
  if (in_line) {
    if (is_parity(check.kind)) table.note_error("kind", "a line of text has no parity bit, expected a sum or a crc");
    if (check.from < 0) table.note_error("from", "expected a position from the start of the line");
    return check;
  }
  check.offset = whole<std::ptrdiff_t>(table, "offset", -kLongestFrame, kLongestFrame);
  const auto end = is_parity(check.kind) ? static_cast<std::int64_t>(shortest) : check.offset;
  check.to = whole<std::ptrdiff_t>(table, "to", -kLongestFrame, kLongestFrame, end);
  check.big_endian = one_of(kEndians, table, "endian", "little");
  check.padded_to = whole<std::size_t>(table, "padded_to", 1, 64, 1);
  check.mask = read_uint32(table, "mask", 0xFFFFFFFF);
  if (is_parity(check.kind)) check.bit = whole<unsigned>(table, "bit", 0, 7);
  if (!find_extent(check, shortest)) table.note_error("offset", "the check lies outside the frame, or covers nothing");
  return check;
}

std::uint32_t compute_check_value(const FrameCheck& check, std::span<const std::byte> bytes) {
  std::vector<std::byte> padded;
  if (bytes.size() % check.padded_to != 0) {
    padded.assign(bytes.begin(), bytes.end());
    padded.resize((bytes.size() / check.padded_to + 1) * check.padded_to);
    bytes = padded;
  }
  switch (check.kind) {
    case CheckKind::none:
    case CheckKind::odd_parity:
    case CheckKind::even_parity: return 0;
    case CheckKind::sum8: return (check.is_negated ? 0u - sum8(bytes) : sum8(bytes)) & 0xFF;
    case CheckKind::sum16: return sum16(bytes, check.big_endian);
    case CheckKind::fletcher8: return fletcher(bytes, 256);
    case CheckKind::fletcher16: return fletcher(bytes, 255);
    case CheckKind::xor8: return xor8(bytes);
    case CheckKind::crc: return crc(check.model, bytes);
  }
  return 0;
}

bool has_valid_check(const FrameCheck& check, std::span<const std::byte> frame) {
  if (check.kind == CheckKind::none) return true;
  const auto extent = find_extent(check, frame.size());
  if (!extent) return false;
  const auto covered = frame.subspan(extent->from, extent->to - extent->from);
  if (is_parity(check.kind)) return has_odd_parity(covered) == (check.kind == CheckKind::odd_parity);
  const auto stored = load_bits(frame.subspan(extent->stored, byte_count(check)), check.big_endian);
  return ((stored ^ compute_check_value(check, covered)) & check.mask) == 0;
}

void write_check(const FrameCheck& check, std::span<std::byte> frame) {
  const auto extent = find_extent(check, frame.size());
  if (check.kind == CheckKind::none || !extent) return;
  const auto covered = frame.subspan(extent->from, extent->to - extent->from);
  if (is_parity(check.kind)) {
    if (!has_valid_check(check, frame)) frame[extent->stored] ^= static_cast<std::byte>(1u << check.bit);
    return;
  }
  const auto value = compute_check_value(check, covered) & check.mask;
  store_bits(frame.subspan(extent->stored, byte_count(check)), check.big_endian, value);
}

}  // namespace gyrotherm::drivers
