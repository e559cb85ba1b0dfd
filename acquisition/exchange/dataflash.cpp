// SPDX-License-Identifier: Apache-2.0
#include "acquisition/exchange/dataflash.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <optional>
#include <set>

namespace gyrotherm::exchange {

namespace {

constexpr std::string_view kDataflashMark("\xA3\x95", 2);
constexpr unsigned char kFormatKind = 128;
constexpr std::size_t kHeadSize = 3, kFormatSize = 89;

/// The meaning of a character in a format: its size in bytes, and its number type if it is numeric.
struct FormatCharacter {
  char character{};
  std::size_t bytes{};
  std::optional<NumberType> type{};
  double scale = 1;
};
constexpr double kHundredth = 0.01, kLocationUnit_deg = 1e-7;
constexpr std::array<FormatCharacter, 21> kFormatCharacters{{{'a', 64},
                                                             {'b', 1, NumberType::int8},
                                                             {'B', 1, NumberType::uint8},
                                                             {'h', 2, NumberType::int16},
                                                             {'H', 2, NumberType::uint16},
                                                             {'i', 4, NumberType::int32},
                                                             {'I', 4, NumberType::uint32},
                                                             {'f', 4, NumberType::float32},
                                                             {'d', 8, NumberType::float64},
                                                             {'g', 2, NumberType::float16},
                                                             {'n', 4},
                                                             {'N', 16},
                                                             {'Z', 64},
                                                             {'c', 2, NumberType::int16, kHundredth},
                                                             {'C', 2, NumberType::uint16, kHundredth},
                                                             {'e', 4, NumberType::int32, kHundredth},
                                                             {'E', 4, NumberType::uint32, kHundredth},
                                                             {'L', 4, NumberType::int32, kLocationUnit_deg},
                                                             {'M', 1, NumberType::uint8},
                                                             {'q', 8, NumberType::int64},
                                                             {'Q', 8, NumberType::uint64}}};

/// Returns a text of fixed size, up to its first NUL.
std::string_view text_at(std::string_view message, std::size_t offset, std::size_t bytes) {
  const auto text = message.substr(offset, bytes);
  return text.substr(0, text.find('\0'));
}

/// A kind of message, as defined by its FMT.
struct Kind {
  std::string name;
  /// The size in bytes, including the header.
  std::size_t size{};
  /// All fields in order, and whether each is a number. Fields that are not numbers have a size of 0.
  std::vector<LogField> all{};
  std::vector<bool> is_number{};
  /// The FMTU of the kind has been read.
  bool has_units = false;
  /// The field with the sensor number.
  std::optional<std::size_t> sensor{};
  /// The index of the series for each sensor number.
  std::map<std::uint64_t, std::size_t> series{};
};

std::optional<Kind> parse_kind(std::string_view message) {
  constexpr std::size_t kLengthOffset = 4, kNameOffset = 5, kFormatOffset = 9, kLabelsOffset = 25;
  Kind kind{.name = std::string(text_at(message, kNameOffset, 4)),
            .size = static_cast<unsigned char>(message[kLengthOffset])};
  std::string_view labels = text_at(message, kLabelsOffset, 64);
  std::size_t offset = kHeadSize;
  for (const char character : text_at(message, kFormatOffset, 16)) {
    const auto found = std::ranges::find(kFormatCharacters, character, &FormatCharacter::character);
    if (found == kFormatCharacters.end() || labels.empty()) return std::nullopt;
    const std::size_t end = std::min(labels.find(','), labels.size());
    kind.all.push_back({.name = std::string(labels.substr(0, end)),
                        .offset = offset,
                        .type = found->type.value_or(NumberType::uint8),
                        .scale = found->scale});
    kind.is_number.push_back(found->type.has_value());
    offset += found->bytes;
    labels.remove_prefix(std::min(end + 1, labels.size()));
  }
  return offset == kind.size && labels.empty() && !kind.name.empty() ? std::optional(kind) : std::nullopt;
}

/// Returns the time field of a kind, scaled to microseconds.
std::optional<LogField> time_field(const Kind& kind) {
  constexpr double kMillisecond = 1000;
  for (std::size_t i = 0; i < kind.all.size(); ++i) {
    if (!kind.is_number[i]) continue;
    if (kind.all[i].name == "TimeUS") return kind.all[i];
    if (kind.all[i].name != "TimeMS") continue;
    LogField time = kind.all[i];
    time.scale = kMillisecond;
    return time;
  }
  return std::nullopt;
}

/// Reads a log sequentially.
class DataflashReader {
 public:
  DataflashReader(Bytes bytes, LogReading reading) : bytes_(std::move(bytes)), reading_(std::move(reading)) {}

  Result<void> read() {
    if (auto ahead = bytes_.peek(kHeadSize); !ahead || !is_dataflash(*ahead))
      return failure(ahead ? Fault{FaultKind::bad_file, bytes_.name(),
                                   "not a DataFlash log, expected one (format = \"dataflash\" in the map)"}
                           : ahead.error());
    while (true) {
      const auto message = next_message();
      if (!message) return failure(message.error());
      if (message->empty()) return reading_.finish(bytes_.name());
      if (!looked_ahead_ && has_unknown_sensor(*message)) {
        if (auto looked = look_ahead(); !looked) return looked;
        continue;
      }
      const std::size_t size = message->size();
      if (auto read = read_message(*message); !read) return read;
      bytes_.skip(size);
    }
  }

  Notes notes() const {
    Notes notes;
    if (strays_ > 0) notes.push_back(fmt::format("{} bytes outside messages were skipped", strays_));
    if (reading_.damaged_messages() > 0)
      notes.push_back(fmt::format("{} messages are damaged and were left out", reading_.damaged_messages()));
    if (unassigned_ > 0)
      notes.push_back(fmt::format("{} messages were left out because their sensor was not known yet", unassigned_));
    return notes;
  }
  const LogReading& reading() const { return reading_; }

 private:
  static constexpr std::size_t kLargestKind = 256;
  static constexpr std::uint64_t kMaxSensors = 64;

  /// Returns the next message without advancing; empty at the end of the log.
  Result<std::string_view> next_message() {
    while (true) {
      const auto ahead = bytes_.peek(kLargestKind);
      if (!ahead || ahead->empty()) return ahead;
      if (const std::size_t size = size_of_message(*ahead); size > 0) return ahead->substr(0, size);
      ++strays_;
      bytes_.skip(1);
    }
  }

  /// Returns the size of the message at the present position; 0 if there is none.
  std::size_t size_of_message(std::string_view ahead) const {
    if (ahead.size() < kHeadSize || !ahead.starts_with(kDataflashMark)) return 0;
    const auto number = static_cast<unsigned char>(ahead[2]);
    const std::size_t size = number == kFormatKind ? kFormatSize : kinds_[number] ? kinds_[number]->size : 0;
    return ahead.size() >= size ? size : 0;
  }

  Result<void> read_message(std::string_view message) {
    const auto number = static_cast<unsigned char>(message[2]);
    if (number == kFormatKind) {
      read_format(message);
      return {};
    }
    Kind& kind = *kinds_[number];
    if (kind.name == "FMTU") (void)read_units(kind, message);
    if (!numbered_later_.empty() && has_unknown_sensor(message) && numbered_later_.contains(definitions_[number])) {
      ++unassigned_;
      return {};
    }
    const auto series = find_series(kind, message);
    if (!series) return failure(series.error());
    return *series ? reading_.take(**series, message, bytes_.name(), bytes_.position()) : Result<void>{};
  }

  /// Returns whether the map has a column of this kind of message and the units of the kind are still unknown. The
  /// units may mark a field as the sensor number.
  bool has_unknown_sensor(std::string_view message) const {
    const auto& kind = kinds_[static_cast<unsigned char>(message[2])];
    return kind && !kind->has_units && reading_.selects_message(kind->name);
  }

  /// Searches the remaining log for kinds whose units define a sensor number, and returns to the present position.
  /// Messages of such a kind that precede its units cannot be assigned to a sensor. In most logs all units precede the
  /// first such message, and this search is not necessary.
  Result<void> look_ahead() {
    looked_ahead_ = true;
    const auto here = bytes_.position();
    const auto strays = strays_;
    const auto kinds = kinds_;
    const auto definitions = definitions_;
    while (true) {
      const auto message = next_message();
      if (!message) return failure(message.error());
      if (message->empty()) break;
      const auto number = static_cast<unsigned char>((*message)[2]);
      if (number == kFormatKind) read_format(*message);
      if (number != kFormatKind && kinds_[number]->name == "FMTU")
        if (const auto of = read_units(*kinds_[number], *message); of && kinds_[*of]->sensor)
          numbered_later_.insert(definitions_[*of]);
      bytes_.skip(message->size());
    }
    strays_ = strays;
    kinds_ = kinds;
    definitions_ = definitions;
    return bytes_.go_back(here);
  }

  /// Reads the definition of a kind. Ignores an identical repetition.
  void read_format(std::string_view message) {
    auto& known = kinds_[static_cast<unsigned char>(message[3])];
    auto& definition = definitions_[static_cast<unsigned char>(message[3])];
    if (message == definition) return;
    definition = message;
    known = parse_kind(message);
  }

  /// Reads the units of a kind. Returns the number of the kind, or nothing if the units are not valid.
  std::optional<unsigned char> read_units(const Kind& units, std::string_view message) {
    const auto offset = [&](const char* name) -> std::optional<std::size_t> {
      const auto field = std::ranges::find(units.all, name, &LogField::name);
      return field == units.all.end() ? std::nullopt : std::optional(field->offset);
    };
    const auto of = offset("FmtType"), ids = offset("UnitIds");
    constexpr std::size_t kUnitIdsBytes = 16;
    if (!of || !ids || *ids + kUnitIdsBytes > message.size()) return std::nullopt;
    const auto number = static_cast<unsigned char>(message[*of]);
    auto& kind = kinds_[number];
    if (!kind) return std::nullopt;
    kind->has_units = true;
    const std::size_t sensor = text_at(message, *ids, kUnitIdsBytes).find('#');
    if (sensor < kind->all.size() && kind->is_number[sensor]) kind->sensor = sensor;
    return number;
  }

  /// Returns the series of a message, or nothing if it has no time.
  Result<std::optional<std::size_t>> find_series(Kind& kind, std::string_view message) {
    std::uint64_t sensor = 0;
    if (kind.sensor) {
      const LogField& field = kind.all[*kind.sensor];
      sensor = whole_number_at(message, field.offset, number_size(field.type));
    }
    if (const auto known = kind.series.find(sensor); known != kind.series.end()) return known->second;
    const auto time = time_field(kind);
    if (!time || sensor >= kMaxSensors) return std::nullopt;
    LogSeries series{.message = kind.name, .instance = static_cast<unsigned>(sensor), .time = *time, .size = kind.size};
    for (std::size_t i = 0; i < kind.all.size(); ++i)
      if (kind.is_number[i]) series.fields.push_back(kind.all[i]);
    const auto added = reading_.add(series, bytes_.name());
    if (!added) return failure(added.error());
    return kind.series[sensor] = *added;
  }

  Bytes bytes_;
  LogReading reading_;
  std::array<std::optional<Kind>, 256> kinds_{};
  std::array<std::string, 256> definitions_{};
  std::size_t strays_{}, unassigned_{};
  bool looked_ahead_ = false;
  /// The FMT messages of the kinds for which look_ahead() found a sensor number.
  std::set<std::string> numbered_later_{};
};

}  // namespace

bool is_dataflash(std::string_view beginning) {
  return beginning.size() >= kHeadSize && beginning.starts_with(kDataflashMark) &&
         static_cast<unsigned char>(beginning[2]) == kFormatKind;
}

Result<Notes> read_dataflash(Bytes bytes, const ImportMap& map, const TakeRow& take) {
  DataflashReader reader(std::move(bytes), LogReading(&map, &take));
  return reader.read().map([&] { return reader.notes(); });
}

Result<std::vector<LogColumn>> read_dataflash_columns(Bytes bytes) {
  DataflashReader reader(std::move(bytes), LogReading());
  return reader.read().map([&] { return reader.reading().published_columns(); });
}

}  // namespace gyrotherm::exchange
