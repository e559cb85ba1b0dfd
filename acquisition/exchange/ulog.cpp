// SPDX-License-Identifier: Apache-2.0
#include "acquisition/exchange/ulog.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <map>
#include <optional>

#include "acquisition/record/sqlite.hpp"

namespace gyrotherm::exchange {

namespace {

constexpr std::string_view kUlogMagic("\x55\x4C\x6F\x67\x01\x12\x35", 7);
constexpr std::size_t kUlogHeader = 16, kMessageHeader = 3, kLargestMessage = 65535;
/// The number of bytes after a header that are examined to decide whether it belongs to a message.
constexpr std::size_t kExaminedBytes = 16;
constexpr int kNewestVersion = 1, kDeepest = 8;
constexpr std::size_t kMaxExpanded = 1'000'000;  ///< fields of all series

/// A field as declared in a format: a basic type or another format.
struct DeclaredField {
  std::string type, name;
  std::size_t count = 1;
  bool is_array = false;
};

std::optional<NumberType> basic_type(std::string_view type) {
  constexpr std::array<std::pair<std::string_view, NumberType>, 11> kTypes{{{"int8_t", NumberType::int8},
                                                                            {"uint8_t", NumberType::uint8},
                                                                            {"int16_t", NumberType::int16},
                                                                            {"uint16_t", NumberType::uint16},
                                                                            {"int32_t", NumberType::int32},
                                                                            {"uint32_t", NumberType::uint32},
                                                                            {"int64_t", NumberType::int64},
                                                                            {"uint64_t", NumberType::uint64},
                                                                            {"float", NumberType::float32},
                                                                            {"double", NumberType::float64},
                                                                            {"bool", NumberType::uint8}}};
  const auto found = std::ranges::find(kTypes, type, &std::pair<std::string_view, NumberType>::first);
  return found == kTypes.end() ? std::nullopt : std::optional(found->second);
}

/// Parses "float[3] accel". Returns nothing for any other text.
std::optional<DeclaredField> parse_declared(std::string_view text) {
  const std::size_t blank = text.find(' ');
  if (blank == 0 || blank == std::string_view::npos || blank + 1 == text.size()) return std::nullopt;
  DeclaredField field{.type = std::string(text.substr(0, blank)), .name = std::string(text.substr(blank + 1))};
  const std::size_t bracket = field.type.find('[');
  if (bracket == std::string::npos) return field;
  if (!field.type.ends_with(']')) return std::nullopt;
  const char* end = field.type.data() + field.type.size() - 1;
  const auto read = std::from_chars(field.type.data() + bracket + 1, end, field.count);
  if (read.ptr != end || read.ec != std::errc() || field.count == 0 || field.count > kLargestMessage)
    return std::nullopt;
  field.is_array = true;
  field.type.resize(bracket);
  return field;
}

/// The formats of a log. Expands a format to its fields, including those of nested formats. Formats can refer to other
/// formats, so a few bytes can describe many fields. The number of fields of all series is therefore limited.
class Formats {
 public:
  /// Adds "vehicle_magnetometer:uint64_t timestamp;float[3] field;". Returns false if the text is not a format.
  bool add(std::string_view text) {
    const std::size_t colon = text.find(':');
    if (colon == std::string_view::npos) return false;
    std::vector<DeclaredField> fields;
    std::string_view rest = text.substr(colon + 1);
    while (!rest.empty()) {
      const std::size_t end = std::min(rest.find(';'), rest.size());
      const auto field = parse_declared(rest.substr(0, end));
      if (!field) return false;
      fields.push_back(*field);
      rest.remove_prefix(std::min(end + 1, rest.size()));
    }
    formats_[std::string(text.substr(0, colon))] = std::move(fields);
    return true;
  }

  /// Returns nothing if the format is missing or larger than a message, or if is_exhausted().
  [[nodiscard]] std::optional<LogSeries> series(const std::string& name, unsigned instance) {
    LogSeries series{.message = name, .instance = instance};
    std::size_t offset = 0;
    if (!expand(name, "", offset, series, kDeepest)) return std::nullopt;
    padded_size_ = offset;
    const auto time = std::ranges::find(series.fields, "timestamp", &LogField::name);
    if (time == series.fields.end() || time->type != NumberType::uint64) return std::nullopt;
    series.time = *time;
    return series;
  }

  /// Returns the size of a message of the last series, including padding at its end.
  [[nodiscard]] std::size_t padded_size() const { return padded_size_; }
  /// Returns whether the series so far have more fields than a log may have.
  [[nodiscard]] bool is_exhausted() const { return expanded_ > kMaxExpanded; }

 private:
  /// Adds the fields of a format, starting at `offset`, and advances `offset` past them.
  bool expand(const std::string& name, const std::string& prefix, std::size_t& offset, LogSeries& series, int depth) {
    const auto format = formats_.find(name);
    if (format == formats_.end() || format->second.empty() || depth == 0) return false;
    for (const DeclaredField& field : format->second) {
      const auto basic = basic_type(field.type);
      const bool is_padding = (basic || field.type == "char") && field.name.starts_with("_padding");
      if (is_padding || field.type == "char") {
        ++expanded_;
        if (!skip_field(field, basic ? number_size(*basic) : 1, is_padding, offset, series)) return false;
        continue;
      }
      for (std::size_t i = 0; i < field.count; ++i) {
        if (++expanded_ > kMaxExpanded) return false;
        const auto full = prefix + field.name + (field.is_array ? fmt::format("[{}]", i) : "");
        if (!(basic ? add_number(*basic, full, offset, series)
                    : expand(field.type, full + ".", offset, series, depth - 1)))
          return false;
      }
    }
    return true;
  }

  /// Skips a field without numbers in one step. A message does not contain the padding at its end.
  static bool skip_field(const DeclaredField& field, std::size_t bytes, bool is_padding, std::size_t& offset,
                         LogSeries& series) {
    if (offset + bytes * field.count > kLargestMessage) return false;
    offset += bytes * field.count;
    if (!is_padding) series.size = offset;
    return true;
  }

  static bool add_number(NumberType type, const std::string& name, std::size_t& offset, LogSeries& series) {
    if (offset + number_size(type) > kLargestMessage) return false;
    series.fields.push_back({.name = name, .offset = offset, .type = type});
    offset += number_size(type);
    series.size = offset;
    return true;
  }

  std::map<std::string, std::vector<DeclaredField>> formats_;
  std::size_t expanded_{};
  std::size_t padded_size_{};
};

/// Reads a log sequentially.
class UlogReader {
 public:
  UlogReader(Bytes bytes, LogReading reading) : bytes_(std::move(bytes)), reading_(std::move(reading)) {}

  Result<void> read() {
    if (auto header = read_header(); !header) return header;
    while (true) {
      const auto size = next_size();
      if (!size) return failure(size.error());
      if (*size == 0) return reading_.finish(bytes_.name());
      const auto is_whole = is_followed(*size);
      if (!is_whole) return failure(is_whole.error());
      if (!*is_whole) {
        if (auto found = skip_damage(); !found) return found;
        continue;
      }
      const std::string_view message = bytes_.peek(*size)->substr(0, *size);
      if (auto read = read_message(message[2], message.substr(kMessageHeader)); !read) return read;
      bytes_.skip(*size);
    }
  }

  Notes notes() const {
    Notes notes;
    const auto note = [&](std::size_t count, const char* what) {
      if (count > 0) notes.push_back(fmt::format("{} {}", count, what));
    };
    if (dropouts_ > 0) notes.push_back(fmt::format("{} drop-outs of the log, {} ms in all", dropouts_, dropped_ms_));
    note(unknown_, "messages of an unknown kind were skipped");
    note(reading_.damaged_messages(), "messages are damaged and were left out");
    if (damaged_sections_ > 0)
      notes.push_back(
          fmt::format("{} bytes at {} positions are not messages and were skipped", damaged_bytes_, damaged_sections_));
    if (ends_within_ > 0) notes.push_back(fmt::format("the log ends within a message, {} bytes of it", ends_within_));
    return notes;
  }
  const LogReading& reading() const { return reading_; }

 private:
  tl::unexpected<Fault> bad_file_failure(std::string what) const {
    return failure(FaultKind::bad_file, bytes_.name(), std::move(what));
  }

  Result<void> read_header() {
    const auto header = bytes_.peek(kUlogHeader);
    if (!header) return failure(header.error());
    if (!is_ulog(*header)) return bad_file_failure("not a ULog file, expected one (format = \"ulog\" in the map)");
    if (header->size() < kUlogHeader) return bad_file_failure("the log ends within its header");
    if (const auto version = static_cast<std::uint8_t>((*header)[7]); version > kNewestVersion)
      return bad_file_failure(fmt::format("ULog of version {}, expected at most {}", version, kNewestVersion));
    bytes_.skip(kUlogHeader);
    return {};
  }

  /// Returns the size of the next message with its header; 0 at the end. Skips data that is cut off by an appended part
  /// of the log.
  Result<std::size_t> next_size() {
    while (true) {
      auto ahead = bytes_.peek(kMessageHeader);
      if (!ahead) return failure(ahead.error());
      const bool has_header = ahead->size() >= kMessageHeader;
      const std::size_t size = has_header ? kMessageHeader + whole_number_at(*ahead, 0, 2) : kMessageHeader;
      ahead = bytes_.peek(size);
      if (!ahead) return failure(ahead.error());
      if (const auto to_appended = distance_to_appended(size); to_appended && *to_appended <= ahead->size()) {
        bytes_.skip(*to_appended);
        continue;
      }
      if (ahead->size() >= size) return size;
      ends_within_ = ahead->size();
      return 0;
    }
  }

  /// Returns whether a message of `size` bytes is followed by another one, or by the end of the log. A message directly
  /// before damaged bytes is not trusted. A message of unknown kind or wrong size is accepted if a valid message
  /// follows soon.
  Result<bool> is_followed(std::size_t size) {
    constexpr std::size_t kMaxBetween = 4, kLargestWhole = kLargestMessage + kMessageHeader;
    auto ahead = bytes_.peek(size + kMessageHeader + kExaminedBytes);
    if (!ahead) return failure(ahead.error());
    std::string_view rest = ahead->substr(size);
    if (!appended_.empty() || rest.size() < kMessageHeader || looks_like_message(rest)) return true;
    const std::size_t wanted = size + kMaxBetween * kLargestWhole;
    ahead = bytes_.peek(wanted);
    if (!ahead) return failure(ahead.error());
    const bool sees_end = ahead->size() < wanted;
    rest = ahead->substr(size, kMaxBetween * kLargestWhole);
    for (std::size_t between = 0; between < kMaxBetween; ++between) {
      if (rest.size() < kMessageHeader) return sees_end;
      if (looks_like_message(rest) && between > 0) return true;
      if (rest[2] <= ' ' || rest[2] > '~') return false;
      const std::size_t next = kMessageHeader + whole_number_at(rest, 0, 2);
      if (next > rest.size()) return sees_end && (looks_like_message(rest) || is_data(rest));
      rest.remove_prefix(next);
    }
    return false;
  }

  /// Returns whether the bytes are data of a known series. Does not check their size.
  bool is_data(std::string_view bytes) const {
    constexpr std::size_t kIdBytes = 2;
    return bytes.size() >= kMessageHeader + kIdBytes && bytes[2] == 'D' &&
           sizes_.contains(static_cast<std::uint16_t>(whole_number_at(bytes, kMessageHeader, kIdBytes)));
  }

  static bool is_known_kind(char kind) {
    return std::string_view("BFIMPQRLCSOAD").find(kind) != std::string_view::npos;
  }

  /// Returns whether the bytes may begin a message. Examines only the first ones.
  bool looks_like_message(std::string_view bytes) const {
    constexpr std::string_view kSync("\x2F\x73\x13\x20\x25\x0C\xBB\x12", 8);
    if (bytes.size() < kMessageHeader || !is_known_kind(bytes[2])) return false;
    const std::size_t size = whole_number_at(bytes, 0, 2);
    const std::string_view content = bytes.substr(kMessageHeader, std::min(size, kExaminedBytes));
    switch (bytes[2]) {
      case 'D': {
        if (size < 2 || content.size() < 2) return false;
        const auto known = sizes_.find(static_cast<std::uint16_t>(whole_number_at(content, 0, 2)));
        return known != sizes_.end() && size - 2 >= known->second.first && size - 2 <= known->second.second;
      }
      case 'S': return content.substr(0, kSync.size()) == kSync.substr(0, content.size());
      case 'O': return size == 2;
      case 'A': return size >= 4;
      case 'B': return size >= 40;
      case 'L': return size >= 9 && !content.empty() && content[0] >= '0' && content[0] <= '7';
      default: return size >= 2;
    }
  }

  /// Skips to the next position that is followed by three consecutive messages, or by all remaining ones.
  Result<void> skip_damage() {
    constexpr std::size_t kWindowBytes = 1 << 19, kMessagesInARow = 3;
    ++damaged_sections_;
    for (std::size_t passed = 0;;) {
      const auto ahead = bytes_.peek(kWindowBytes);
      if (!ahead) return failure(ahead.error());
      const bool is_end = ahead->size() < kWindowBytes;
      const std::size_t last =
          is_end ? ahead->size() : ahead->size() - kMessagesInARow * (kLargestMessage + kMessageHeader);
      std::size_t at = passed == 0 ? 1 : 0;
      while (at < last && !is_message_sequence(ahead->substr(at), kMessagesInARow)) ++at;
      bytes_.skip(std::min(at, ahead->size()));
      damaged_bytes_ += std::min(at, ahead->size());
      passed += at;
      if (at < last || is_end) return {};
    }
  }

  bool is_message_sequence(std::string_view bytes, std::size_t count) const {
    for (; count > 0; --count) {
      if (!looks_like_message(bytes)) return false;
      const std::size_t size = kMessageHeader + whole_number_at(bytes, 0, 2);
      if (size >= bytes.size()) return size == bytes.size();
      bytes.remove_prefix(size);
    }
    return true;
  }

  /// Returns the distance to data appended after a crash, if it is less than `size`.
  std::optional<std::size_t> distance_to_appended(std::size_t size) const {
    for (const std::uint64_t offset : appended_)
      if (offset > bytes_.position() && offset < bytes_.position() + size) return offset - bytes_.position();
    return std::nullopt;
  }

  Result<void> read_message(char kind, std::string_view message) {
    switch (kind) {
      case 'B': return read_flags(message);
      case 'F': unknown_ += formats_.add(message) ? 0 : 1; return {};
      case 'A': return read_subscription(message);
      case 'D': return read_data(message);
      case 'O':
        ++dropouts_;
        if (message.size() >= 2) dropped_ms_ += whole_number_at(message, 0, 2);
        return {};
      // Information, parameters, texts and synchronisation marks contain no measurements.
      case 'I':
      case 'M':
      case 'P':
      case 'Q':
      case 'R':
      case 'L':
      case 'C':
      case 'S': return {};
      default: ++unknown_; return {};
    }
  }

  Result<void> read_flags(std::string_view message) {
    constexpr std::size_t kFlags = 8, kIncompatible = 8, kOffsets = 16, kSize = 40;
    constexpr unsigned char kAppended = 1;
    if (message.size() < kSize) return bad_file_failure("the flags message is shorter than 40 bytes");
    for (std::size_t i = 0; i < kFlags; ++i) {
      const auto flags = static_cast<unsigned char>(message[kIncompatible + i]);
      if ((i == 0 ? flags & ~kAppended : flags) != 0)
        return bad_file_failure("the log has incompatible flags that this version does not support");
    }
    appended_.clear();  // compared with each message
    if ((message[kIncompatible] & kAppended) == 0) return {};
    for (std::size_t at = kOffsets; at + 8 <= kSize; at += 8) appended_.push_back(whole_number_at(message, at, 8));
    return {};
  }

  Result<void> read_subscription(std::string_view message) {
    if (message.size() < 4) return {};
    const auto instance = static_cast<unsigned char>(message[0]);
    const auto id = static_cast<std::uint16_t>(whole_number_at(message, 1, 2));
    auto series = formats_.series(std::string(message.substr(3)), instance);
    subscribed_.erase(id);
    sizes_[id] = series ? std::pair(std::min(series->size, formats_.padded_size()), formats_.padded_size())
                        : std::pair(std::size_t{}, kLargestMessage);
    if (formats_.is_exhausted())
      return bad_file_failure(
          fmt::format("the subscribed messages have more than {} fields in all, expected fewer", kMaxExpanded));
    if (!series) return {};
    return record::assign_result(subscribed_[id], reading_.add(*series, bytes_.name()));
  }

  Result<void> read_data(std::string_view message) {
    if (message.size() < 2) return {};
    const auto found = subscribed_.find(static_cast<std::uint16_t>(whole_number_at(message, 0, 2)));
    if (found == subscribed_.end()) return {};
    return reading_.take(found->second, message.substr(2), bytes_.name(), bytes_.position());
  }

  Bytes bytes_;
  LogReading reading_;
  Formats formats_{};
  std::map<std::uint16_t, std::size_t> subscribed_{};
  std::vector<std::uint64_t> appended_{};
  std::map<std::uint16_t, std::pair<std::size_t, std::size_t>> sizes_{};  ///< data sizes of each series
  std::size_t dropouts_{}, unknown_{}, ends_within_{}, damaged_sections_{};
  std::uint64_t damaged_bytes_{};
  std::uint64_t dropped_ms_{};
};

}  // namespace

bool is_ulog(std::string_view beginning) { return beginning.starts_with(kUlogMagic); }

Result<Notes> read_ulog(Bytes bytes, const ImportMap& map, const TakeRow& take) {
  UlogReader reader(std::move(bytes), LogReading(&map, &take));
  return reader.read().map([&] { return reader.notes(); });
}

Result<std::vector<LogColumn>> read_ulog_columns(Bytes bytes) {
  UlogReader reader(std::move(bytes), LogReading());
  return reader.read().map([&] { return reader.reading().published_columns(); });
}

}  // namespace gyrotherm::exchange
