// SPDX-License-Identifier: Apache-2.0
#include "acquisition/exchange/dataflash.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <optional>

#include "acquisition/exchange/log_reading.hpp"

namespace gyrotherm::exchange {

namespace {

constexpr std::string_view kDataflashMark("\xA3\x95", 2);
constexpr unsigned char kFormatKind = 128;
constexpr std::size_t kHeadSize = 3, kFormatSize = 89;

/// What a character of a format stands for: its bytes, and the number that they are, if they are one.
struct FormatCharacter {
  char character{};
  std::size_t bytes{};
  std::optional<NumberType> type{};
  double scale = 1;
};
constexpr double kHundredth = 0.01, kDegreeOfPlace = 1e-7;
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
                                                             {'L', 4, NumberType::int32, kDegreeOfPlace},
                                                             {'M', 1, NumberType::uint8},
                                                             {'q', 8, NumberType::int64},
                                                             {'Q', 8, NumberType::uint64}}};

/// A text of fixed size, which ends before its first NUL.
std::string_view text_at(std::string_view message, std::size_t place, std::size_t bytes) {
  const auto text = message.substr(place, bytes);
  return text.substr(0, text.find('\0'));
}

/// A kind of message, as its FMT tells it.
struct Kind {
  std::string name;
  std::size_t size{};                             ///< with its head
  std::vector<LogField> all{};                    ///< all fields in order; those that are no numbers have no bytes
  std::vector<bool> is_number{};                  ///< … of each
  std::optional<std::size_t> sensor{};            ///< the field that numbers the sensors
  std::map<std::uint64_t, std::size_t> series{};  ///< by the number of the sensor
};

std::optional<Kind> parse_kind(std::string_view message) {
  constexpr std::size_t kLength = 4, kName = 5, kFormat = 9, kLabels = 25;
  Kind kind{.name = std::string(text_at(message, kName, 4)), .size = static_cast<unsigned char>(message[kLength])};
  std::string_view labels = text_at(message, kLabels, 64);
  std::size_t place = kHeadSize;
  for (const char character : text_at(message, kFormat, 16)) {
    const auto found = std::ranges::find(kFormatCharacters, character, &FormatCharacter::character);
    if (found == kFormatCharacters.end() || labels.empty()) return std::nullopt;
    const std::size_t end = std::min(labels.find(','), labels.size());
    kind.all.push_back({.name = std::string(labels.substr(0, end)),
                        .place = place,
                        .type = found->type.value_or(NumberType::uint8),
                        .scale = found->scale});
    kind.is_number.push_back(found->type.has_value());
    place += found->bytes;
    labels.remove_prefix(std::min(end + 1, labels.size()));
  }
  return place == kind.size && labels.empty() && !kind.name.empty() ? std::optional(kind) : std::nullopt;
}

/// The time of a kind, in microseconds.
std::optional<LogField> time_of(const Kind& kind) {
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

/// One pass over a log.
class DataflashReader {
 public:
  DataflashReader(Bytes bytes, LogReading reading) : bytes_(std::move(bytes)), reading_(std::move(reading)) {}

  Result<void> read() {
    if (auto ahead = bytes_.ahead(kHeadSize); !ahead || !is_dataflash(*ahead))
      return failure(ahead ? Fault{FaultKind::bad_file, bytes_.name(),
                                   "not a DataFlash log, expected one (format = \"dataflash\" in the map)"}
                           : ahead.error());
    while (true) {
      const auto ahead = bytes_.ahead(kLargestKind);
      if (!ahead) return failure(ahead.error());
      if (ahead->empty()) return reading_.finish(bytes_.name());
      const std::size_t size = size_of_message(*ahead);
      if (size == 0) {
        ++strays_;
        bytes_.pass(1);
        continue;
      }
      if (auto read = read_message(ahead->substr(0, size)); !read) return read;
      bytes_.pass(size);
    }
  }

  Notes notes() const {
    Notes notes;
    if (strays_ > 0) notes.push_back(fmt::format("{} bytes that belong to no message were passed over", strays_));
    if (reading_.damaged() > 0)
      notes.push_back(fmt::format("{} messages are damaged and were left out", reading_.damaged()));
    return notes;
  }
  const LogReading& reading() const { return reading_; }

 private:
  static constexpr std::size_t kLargestKind = 256;
  static constexpr std::uint64_t kMostSensors = 64;

  /// Of the message that is ahead; 0: there is none.
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
    if (kind.name == "FMTU") read_units(kind, message);
    const auto series = series_of(kind, message);
    if (!series) return failure(series.error());
    return *series ? reading_.take(**series, message, bytes_.name(), bytes_.passed()) : Result<void>{};
  }

  /// A kind that is told again as it was stays as it is.
  void read_format(std::string_view message) {
    auto& known = kinds_[static_cast<unsigned char>(message[3])];
    auto& told = told_[static_cast<unsigned char>(message[3])];
    if (message == told) return;
    told = message;
    known = parse_kind(message);
  }

  void read_units(const Kind& units, std::string_view message) {
    const auto place = [&](const char* name) -> std::optional<std::size_t> {
      const auto field = std::ranges::find(units.all, name, &LogField::name);
      return field == units.all.end() ? std::nullopt : std::optional(field->place);
    };
    const auto of = place("FmtType"), ids = place("UnitIds");
    constexpr std::size_t kIds = 16;
    if (!of || !ids || *ids + kIds > message.size()) return;
    auto& kind = kinds_[static_cast<unsigned char>(message[*of])];
    const std::size_t sensor = text_at(message, *ids, kIds).find('#');
    if (!kind || sensor >= kind->all.size() || !kind->is_number[sensor]) return;
    kind->sensor = sensor;
  }

  /// The series that a message is one of; nothing if it has no time.
  Result<std::optional<std::size_t>> series_of(Kind& kind, std::string_view message) {
    std::uint64_t sensor = 0;
    if (kind.sensor) {
      const LogField& field = kind.all[*kind.sensor];
      sensor = whole_number_at(message, field.place, size_of(field.type));
    }
    if (const auto known = kind.series.find(sensor); known != kind.series.end()) return known->second;
    const auto time = time_of(kind);
    if (!time || sensor >= kMostSensors) return std::nullopt;
    LogSeries series{.message = kind.name, .instance = static_cast<unsigned>(sensor), .time = *time, .size = kind.size};
    for (std::size_t i = 0; i < kind.all.size(); ++i)
      if (kind.is_number[i]) series.fields.push_back(kind.all[i]);
    const auto added = reading_.add(std::move(series), bytes_.name());
    if (!added) return failure(added.error());
    return kind.series[sensor] = *added;
  }

  Bytes bytes_;
  LogReading reading_;
  std::array<std::optional<Kind>, 256> kinds_{};
  std::array<std::string, 256> told_{};
  std::size_t strays_{};
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

Result<std::vector<LogColumn>> columns_of_dataflash(Bytes bytes) {
  DataflashReader reader(std::move(bytes), LogReading());
  return reader.read().map([&] { return reader.reading().there(); });
}

}  // namespace gyrotherm::exchange
