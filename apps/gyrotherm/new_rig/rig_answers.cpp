// SPDX-License-Identifier: Apache-2.0
#include "apps/gyrotherm/new_rig/rig_answers.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <sstream>
#include <utility>

#include "acquisition/record/schema.hpp"
#include "apps/gyrotherm/new_rig/line_answers.hpp"
#include "core/count_text.hpp"
#include "core/file.hpp"
#include "core/number_hint.hpp"
#include "core/serial_number.hpp"
#include "core/shipped.hpp"
#include "core/text.hpp"
#include "drivers/thermometer/thermometer_description.hpp"
#include "drivers/thermometer/thermometer_kinds.hpp"

namespace gyrotherm::app {
namespace {

constexpr std::array<std::string_view, 3> kCelsiusUnits{"", "°C", "C"};
constexpr std::array<std::string_view, 4> kRateUnits{"", "°C/min", "K/min", "C/min"};
constexpr std::array<std::string_view, 4> kDegreeUnits{"", "°", "deg", "degrees"};
constexpr std::array<std::string_view, 2> kArcsecUnits{"", "arcsec"};

tl::unexpected<Fault> refused(std::string reason) { return failure(FaultKind::usage, "", std::move(reason)); }

std::vector<std::string> split_words(const std::string& text) {
  std::istringstream words(text);
  std::vector<std::string> split;
  for (std::string word; words >> word;) split.push_back(word);
  return split;
}

/// Parses a number with one of `units`. `what` describes the expected value.
Result<double> read_number(const std::string& text, std::span<const std::string_view> units, const char* what) {
  if (const auto value = parse_quantity(text, units)) return *value;
  const auto hint = hint_at_number(text);
  return refused(fmt::format("\"{}\" is not {}{}", text, what, hint.empty() ? "" : "; " + hint));
}

Result<Celsius> read_celsius(const std::string& text) {
  constexpr double kColdest = -273.15, kHottest = 1000;
  const auto value = read_number(text, kCelsiusUnits, "a temperature in °C, such as -40");
  if (!value) return failure(value.error());
  if (*value < kColdest || *value > kHottest)
    return refused(
        fmt::format("{:g} °C is not a chamber temperature, expected {} to {} °C", *value, kColdest, kHottest));
  return Celsius{*value};
}

/// Parses an angle in degrees of at most `most` on either side.
Result<double> read_angle(const std::string& text, double most) {
  const auto value = read_number(text, kDegreeUnits, "an angle in degrees, such as 47.3769");
  if (value && std::abs(*value) > most) return refused(fmt::format("{:g}° is outside ±{:g}°", *value, most));
  return value;
}

/// Reads a description and parses it with `parse`.
template <class Parse>
auto load(const std::string& given, const ShippedKind& kind, const Parse& parse)
    -> decltype(parse(std::string(), std::string())) {
  const auto path = resolve_path(given, kind);
  if (!path) return failure(path.error());
  const auto text = read_text_file(*path);
  if (!text) return failure(text.error());
  return parse(*text, *path);
}

const drivers::ThermometerKindRow* find_driver(const std::string& kind) {
  const auto row = std::ranges::find_if(drivers::kThermometerKinds, [&](const auto& one) { return one.name == kind; });
  return row == drivers::kThermometerKinds.end() ? nullptr : &*row;
}

Result<drivers::ThermometerDescription> load_scanner(const std::string& kind) {
  return load(kind, kShippedThermometer, [](const std::string& text, const std::string& path) {
    return drivers::parse_thermometer_description(text, path);
  });
}

bool is_dcon(const ScannerAnswer& scanner) { return scanner.kind == "dcon"; }

}  // namespace

std::string chamber_file_path(const RigAnswers& answers) {
  if (answers.map) return {};
  const std::filesystem::path file(answers.file);
  return (file.parent_path() / (file.stem().string() + "-chamber.toml")).string();
}

Result<void> accept_chamber(RigAnswers& answers, const std::string& text) {
  answers.chamber = text;
  answers.map.reset();
  if (text == kOtherModbus || text == kOtherText) {
    const auto own_file = chamber_file_path(answers);
    if (!read_file_state(own_file).is_there()) return {};
    return refused(
        fmt::format("{}, which would describe the chamber, exists already: choose another name for the rig "
                    "file",
                    own_file));
  }
  auto map = load(text, kShippedChamberMap, [](const std::string& content, const std::string& path) {
    return drivers::parse_register_map(content, path);
  });
  if (!map) {
    auto fault = map.error();
    fault.what += fmt::format("; {} and {} stand for a chamber that is not listed", kOtherModbus, kOtherText);
    return failure(std::move(fault));
  }
  answers.map = std::move(*map);
  return {};
}

Result<void> accept_chamber_line(RigAnswers& answers, const std::string& text) {
  const auto line = read_byte_line(text);
  if (!line) return failure(line.error());
  if (answers.map)
    if (const auto linked = select_link_for(*answers.map, *drivers::parse_line(*line)); !linked)
      return refused(linked.error().what);
  answers.chamber_line = *line;
  return {};
}

Result<void> accept_chamber_unit(RigAnswers& answers, const std::string& text) {
  constexpr int kLargestUnit = 247;
  int unit = -1;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), unit);
  if (error != std::errc{} || end != text.data() + text.size() || unit < 0 || unit > kLargestUnit)
    return refused(fmt::format("\"{}\" is not a unit number from 0 to {}", text, kLargestUnit));
  answers.chamber_unit = static_cast<std::uint8_t>(unit);
  return {};
}

Result<void> accept_lowest(RigAnswers& answers, const std::string& text) {
  return read_celsius(text).map([&](Celsius value) { answers.lowest = value; });
}

Result<void> accept_highest(RigAnswers& answers, const std::string& text) {
  const auto value = read_celsius(text);
  if (!value) return failure(value.error());
  if (*value <= answers.lowest)
    return refused(fmt::format("{:g} °C is not above the lowest, {:g} °C", value->value, answers.lowest.value));
  answers.highest = *value;
  return {};
}

Result<void> accept_fastest(RigAnswers& answers, const std::string& text) {
  const auto value = read_number(text, kRateUnits, "a rate in °C/min, such as 5");
  if (!value) return failure(value.error());
  if (*value <= 0) return refused("the rate must be above zero");
  answers.fastest = CelsiusPerMinute{*value};
  return {};
}

Result<void> accept_safe(RigAnswers& answers, const std::string& text) {
  const auto value = read_celsius(text);
  if (!value) return failure(value.error());
  if (*value < answers.lowest || *value > answers.highest)
    return refused(fmt::format("{:g} °C is outside the limits, {:g} to {:g} °C", value->value, answers.lowest.value,
                               answers.highest.value));
  answers.safe = *value;
  return {};
}

Result<void> accept_air(RigAnswers& answers, const std::string& text) {
  const auto words = split_words(text);
  if (words.size() != 2) return refused("expected two temperatures, the lowest and the highest, such as \"-50 70\"");
  const auto low = read_celsius(words[0]), high = read_celsius(words[1]);
  if (!low) return failure(low.error());
  if (!high) return failure(high.error());
  if (*low > answers.lowest || *high < answers.highest)
    return refused(fmt::format("the limits of the air must include those of the set points, {:g} to {:g} °C",
                               answers.lowest.value, answers.highest.value));
  if (answers.limiter && ((answers.limiter->lowest && *low <= *answers.limiter->lowest) ||
                          (answers.limiter->highest && *high >= *answers.limiter->highest)))
    return refused(fmt::format("the limiter would trip first ({}); the limits of the air must lie inside its settings",
                               describe(*answers.limiter)));
  answers.air_lowest = *low;
  answers.air_highest = *high;
  return {};
}

Result<void> accept_limiter(RigAnswers& answers, const std::string& text) {
  answers.limiter.reset();
  if (text == kUnknown) return {};
  const auto words = split_words(text);
  rig::Limiter limiter;
  if (!words.empty()) limiter.protection_class = words[0];
  const bool has_both =
      limiter.protection_class == "1" || limiter.protection_class == "2" || limiter.protection_class == "3.3";
  const bool is_high = limiter.protection_class == "3.1", is_low = limiter.protection_class == "3.2";
  if (!has_both && !is_high && !is_low)
    return refused("expected the class (1, 2, 3.1, 3.2 or 3.3) and its settings, such as \"3.3 -50 75\", or unknown");
  if (words.size() < 2 || words.size() > 3 || ((is_high || is_low) && words.size() != 2))
    return refused(has_both ? "expected its lowest and highest setting after the class, or only the highest"
                            : "this class has one setting");
  const auto last = read_celsius(words.back());
  if (!last) return failure(last.error());
  (is_low ? limiter.lowest : limiter.highest) = *last;
  if (words.size() == 3) {
    const auto low = read_celsius(words[1]);
    if (!low) return failure(low.error());
    limiter.lowest = *low;
  }
  if (limiter.lowest && limiter.highest && *limiter.lowest >= *limiter.highest)
    return refused(
        fmt::format("the lowest setting, {:g} °C, is not below the highest, {:g} °C; expected the class, the "
                    "lowest and the highest setting",
                    limiter.lowest->value, limiter.highest->value));
  if ((limiter.lowest && *limiter.lowest >= answers.lowest) || (limiter.highest && *limiter.highest <= answers.highest))
    return refused(fmt::format("the limiter would trip at a permitted set point, {:g} to {:g} °C", answers.lowest.value,
                               answers.highest.value));
  answers.limiter = limiter;
  return {};
}

std::size_t count_scanner_inputs(const ScannerAnswer& scanner) {
  if (const auto* row = find_driver(scanner.kind))
    return row->inputs * std::max<std::size_t>(1, scanner.addresses.size());
  const auto description =
      scanner.kind == kOther ? Result<drivers::ThermometerDescription>(refused("")) : load_scanner(scanner.kind);
  return description ? description->inputs : drivers::kMostTextInputs;
}

/// Returns the built-in driver or shipped description with the nearest name; empty if none is near.
std::string find_nearest_driver(const std::string& kind) {
  auto names = shipped_names(kShippedThermometer);
  for (const auto& row : drivers::kThermometerKinds)
    if (row.kind != drivers::ThermometerKind::text && row.kind != drivers::ThermometerKind::process)
      names.emplace_back(row.name);
  return find_nearest(kind, names);
}

Result<void> accept_scanner_kind(RigAnswers& answers, const std::string& text) {
  auto& scanner = answers.scanners.back();
  scanner = {};
  scanner.kind = text;
  if (text == kOther) return {};
  if (const auto* row = find_driver(text);
      row && row->kind != drivers::ThermometerKind::text && row->kind != drivers::ThermometerKind::process)
    return {};
  const auto loaded = load_scanner(text);
  if (loaded) return {};
  const auto near = is_path(text) ? "" : find_nearest_driver(text);
  if (near.empty() || near == text) return failure(loaded.error());
  return refused(fmt::format("\"{}\" is neither a driver nor a shipped description; did you mean \"{}\"?", text, near));
}

Result<void> accept_scanner_line(RigAnswers& answers, const std::string& text) {
  auto& scanner = answers.scanners.back();
  const auto line = scanner.kind == "mcc_usb_temp" ? read_hid_line(text) : read_byte_line(text);
  if (!line) return failure(line.error());
  std::vector<std::string> others{answers.chamber_line};
  for (const auto& one : answers.scanners)
    if (&one != &scanner) others.push_back(one.line);
  if (auto separate = check_separate_line(*line, others); !separate) return separate;
  scanner.line = *line;
  return {};
}

Result<void> accept_scanner_addresses(RigAnswers& answers, const std::string& text) {
  auto& addresses = answers.scanners.back().addresses;
  addresses.clear();
  auto list = text;
  std::ranges::replace(list, ',', ' ');
  for (const auto& word : split_words(list)) {
    int address = -1;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), address);
    if (error != std::errc{} || end != word.data() + word.size() || address < 0 || address > 255)
      return refused(fmt::format("\"{}\" is not an address from 0 to 255", word));
    addresses.push_back(static_cast<std::uint8_t>(address));
  }
  if (addresses.empty()) return refused("expected at least one address");
  return {};
}

Result<void> accept_scanner_type(RigAnswers& answers, const std::string& text) {
  answers.scanners.back().type.clear();
  if (text == kNone) return {};
  if (text != "J" && text != "K" && text != "T" && text != "E")
    return refused("expected the thermocouple, J, K, T or E, or none");
  answers.scanners.back().type = text;
  return {};
}

std::vector<std::string> list_channel_names(const RigAnswers& answers) {
  std::vector<std::string> names;
  for (const auto& scanner : answers.scanners)
    names.insert(names.end(), scanner.channels.begin(), scanner.channels.end());
  return names;
}

std::vector<std::string> list_free_channels(const RigAnswers& answers, std::size_t most) {
  const auto used = list_channel_names(answers);
  std::vector<std::string> free;
  for (char letter = 'A'; letter <= 'H' && free.size() < most; ++letter)
    if (std::string name(1, letter); std::ranges::find(used, name) == used.end()) free.push_back(std::move(name));
  if (free.empty() && std::ranges::find(used, "shell") == used.end()) free.emplace_back("shell");
  return free;
}

Result<void> accept_scanner_channels(RigAnswers& answers, const std::string& text) {
  auto& scanner = answers.scanners.back();
  scanner.channels.clear();
  auto names = split_words(text);
  const auto inputs = count_scanner_inputs(scanner);
  std::size_t count = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), count);
  if (error == std::errc{} && end == text.data() + text.size()) {
    if (count > inputs) return refused(fmt::format("it has {} inputs, expected 1 to {} channels", inputs, inputs));
    names = list_free_channels(answers, count);
    if (count == 0 || names.size() != count)
      return refused(fmt::format("unused positions of A to H: {}; give the names of {}",
                                 list_free_channels(answers, drivers::kMostTextInputs).size(),
                                 format_count(count, "channel")));
  }
  if (names.empty() || names.size() > inputs) return refused(fmt::format("expected 1 to {} channels", inputs));
  const auto used = list_channel_names(answers);
  for (std::size_t i = 0; i < names.size(); ++i)
    if (std::ranges::count(used, names[i]) + std::count(names.begin(), names.end(), names[i]) > 1)
      return refused(fmt::format("\"{}\" is the name of another channel", names[i]));
  record::RunInfo info;
  for (const auto& name : names) info.thermometers.emplace_back().name = name;
  if (const auto troubles = record::new_name_troubles(info); !troubles.empty())
    return refused(fmt::format("{}: {}", troubles.front().what, troubles.front().why));
  scanner.channels = std::move(names);
  return {};
}

Result<void> accept_scanner(RigAnswers& answers, const std::string& text) {
  const auto words = split_words(text);
  if (words.size() < 3)
    return refused(fmt::format(
        "\"{}\" is not complete, expected kind, line and channels, such as \"lakeshore_218 tcp://10.0.0.6:4001 A B\"",
        text));
  answers.scanners.emplace_back();
  if (auto kind = accept_scanner_kind(answers, words[0]); !kind) return kind;
  if (auto line = accept_scanner_line(answers, words[1]); !line) return line;
  constexpr std::string_view kAddresses = "addresses=", kType = "type=";
  std::string channels;
  for (std::size_t i = 2; i < words.size(); ++i) {
    Result<void> set;
    const bool is_dcon_setting = is_dcon(answers.scanners.back());
    if (is_dcon_setting && words[i].starts_with(kAddresses))
      set = accept_scanner_addresses(answers, words[i].substr(kAddresses.size()));
    else if (is_dcon_setting && words[i].starts_with(kType))
      set = accept_scanner_type(answers, words[i].substr(kType.size()));
    else
      channels += (channels.empty() ? "" : " ") + words[i];
    if (!set) return set;
  }
  if (is_dcon(answers.scanners.back()) && answers.scanners.back().addresses.empty())
    return refused("expected the addresses of the dcon modules, such as addresses=1,2");
  return accept_scanner_channels(answers, channels);
}

Result<void> accept_gyro(RigAnswers& answers, const std::string& text) {
  answers.gyro = text;
  answers.stream.reset();
  if (text == kOther) return {};
  auto stream = load(text, kShippedGyroStream, [](const std::string& content, const std::string& path) {
    return drivers::parse_gyro_stream(content, path);
  });
  if (!stream) return failure(stream.error());
  answers.stream = std::move(*stream);
  return {};
}

Result<void> accept_gyro_line(RigAnswers& answers, const std::string& text) {
  const auto line = read_byte_line(text);
  if (!line) return failure(line.error());
  std::vector<std::string> others{answers.chamber_line};
  for (const auto& scanner : answers.scanners) others.push_back(scanner.line);
  if (auto separate = check_separate_line(*line, others); !separate) return separate;
  answers.gyro_line = *line;
  return {};
}

Result<void> accept_axis(RigAnswers& answers, const std::string& text) {
  const auto& axes = answers.stream->frame.all_axes;
  if (std::ranges::find(axes, text) == axes.end())
    return refused(fmt::format("\"{}\" is not one of {}", text, fmt::join(axes, ", ")));
  answers.axis = text;
  return {};
}

Result<void> accept_arcsec_per_pulse(RigAnswers& answers, const std::string& text) {
  const auto value = read_number(text, kArcsecUnits, "an angle in seconds of arc, such as 0.1");
  if (!value) return failure(value.error());
  if (*value == 0) return refused("it must not be zero");
  answers.arcsec_per_pulse = *value;
  return {};
}

Result<void> accept_latitude(RigAnswers& answers, const std::string& text) {
  answers.latitude.reset();
  if (text == kUnknown) return {};
  return read_angle(text, 90).map([&](double value) { answers.latitude = value; });
}

Result<void> accept_azimuth(RigAnswers& answers, const std::string& text) {
  return read_angle(text, 360).map([&](double value) { answers.azimuth = value; });
}

Result<void> accept_elevation(RigAnswers& answers, const std::string& text) {
  return read_angle(text, 90).map([&](double value) { answers.elevation = value; });
}

Result<void> accept_serial_number(RigAnswers& answers, const std::string& text) {
  answers.serial_number.clear();
  if (text == kNone) return {};
  return parse_serial_number(text).map([&](const std::string& number) { answers.serial_number = number; });
}

Result<void> accept_title(RigAnswers& answers, const std::string& text) {
  if (plain(text) != text) return refused("the title contains a control character");
  answers.title = text;
  return {};
}

}  // namespace gyrotherm::app
