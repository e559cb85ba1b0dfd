// SPDX-License-Identifier: Apache-2.0
#include "acquisition/exchange/column_names.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <initializer_list>

#include "acquisition/record/csv.hpp"
#include "core/text.hpp"

namespace gyrotherm::exchange {

std::string in_lower_case(std::string_view text) {
  std::string lower(text);
  std::ranges::transform(lower, lower.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return lower;
}

namespace {

bool contains_any(std::string_view text, std::initializer_list<std::string_view> parts) {
  return std::ranges::any_of(parts, [&](std::string_view part) { return text.find(part) != std::string_view::npos; });
}

bool is_one_of(std::string_view text, std::initializer_list<std::string_view> spellings) {
  return std::ranges::find(spellings, text) != spellings.end();
}

/// Returns the position of the brackets at the end of a name that contain a unit; npos if there are none or they
/// contain an array index.
std::size_t bracket_of_unit(std::string_view name) {
  const std::size_t bracket = name.find_last_of("[(");
  const bool has_unit = bracket != std::string_view::npos && bracket > 0 &&
                        name.find_last_of("])") == name.size() - 1 &&
                        !std::ranges::all_of(name.substr(bracket + 1, name.size() - bracket - 2),
                                             [](unsigned char c) { return std::isdigit(c) != 0; });
  return has_unit ? bracket : std::string_view::npos;
}

/// Returns the name without a unit in brackets.
std::string_view strip_unit(std::string_view name) { return trimmed(name.substr(0, bracket_of_unit(name))); }

/// Returns the unit in brackets unchanged; empty if there is none.
std::string_view unit_in_brackets(std::string_view name) {
  const std::size_t bracket = bracket_of_unit(name);
  if (bracket == std::string_view::npos) return {};
  return trimmed(name.substr(bracket + 1, name.size() - bracket - 2));
}

bool is_all_digits(std::string_view spelling) {
  return !spelling.empty() && std::ranges::all_of(spelling, [](unsigned char c) { return std::isdigit(c) != 0; });
}

/// Returns whether the complete unit in a name is one of the spellings. The unit is the content of the brackets or,
/// without brackets, the end of the name after a "_", "." or blank. A part of the unit does not match: "mdps" and
/// "x_100_dps" do not match "dps", and "0.01 deg/s" does not match "deg/s".
bool has_unit(std::string_view name, std::initializer_list<std::string_view> spellings) {
  constexpr std::string_view kUnitSeparators = "_. ";
  auto unit = in_lower_case(unit_in_brackets(name));
  std::erase(unit, ' ');
  if (!unit.empty()) return is_one_of(unit, spellings);
  const auto lower = in_lower_case(name.ends_with(']') ? name.substr(0, name.rfind('[')) : name);
  return std::ranges::any_of(spellings, [&](std::string_view spelling) {
    if (!lower.ends_with(spelling)) return false;
    const std::string_view before = std::string_view(lower).substr(0, lower.size() - spelling.size());
    if (before.empty()) return true;
    if (kUnitSeparators.find(before.back()) == std::string_view::npos) return false;
    const std::string_view rest = before.substr(0, before.size() - 1);
    return !is_all_digits(rest.substr(rest.find_last_of(kUnitSeparators) + 1));
  });
}

/// Returns the field of "message.field". Returns any other name unchanged.
std::string_view field_name(std::string_view name) { return name.substr(name.rfind('.') + 1); }

bool is_letter_with_number(std::string_view name, char letter) {
  return !name.empty() && name.front() == letter &&
         std::ranges::all_of(name.substr(1), [](unsigned char c) { return std::isdigit(c) != 0; });
}

}  // namespace

bool is_temperature_name(std::string_view name) {
  const auto lower = in_lower_case(name);
  const auto bare = in_lower_case(field_name(strip_unit(name)));
  const bool is_letter = bare.size() == 1 && name.size() == 1 && name.front() >= 'A' && name.front() <= 'H';
  const bool is_small_t = strip_unit(name) == "t";  // it means time
  return contains_any(lower, {"temp", "therm", "°c", "degc", "deg c", "[c]", "(c)", "°f", "degf", "[f]", "(f)", "[k]",
                              "(k)", "[kelvin]", "(kelvin)", "kelvin)"}) ||
         is_letter || (is_letter_with_number(bare, 't') && !is_small_t);
}

namespace {
bool has_rate_unit(std::string_view name);
}

bool is_gyro_name(std::string_view name) {
  const auto lower = in_lower_case(name);
  const auto bare = in_lower_case(field_name(strip_unit(name)));
  if (contains_any(lower, {"temp",     "time",   "device",    "error",    "clip",     "samples", "_id",
                           "count_",   "_count", "estimator", "ekf",      "xkf",      "nkf",     "_dt",
                           "integral", "_bias",  "bias_",     "setpoint", "variance", "offset",  "filter"}))
    return false;
  if (is_one_of(bare, {"gx", "gy", "gz", "wx", "wy", "wz", "w", "omega", "rate", "pulses", "bias"})) return true;
  if (contains_any(bare, {"gyr", "omega", "angular", "dtheta", "delta_angle", "pulses", "kreisel", "drehrate"}))
    return true;
  if (has_rate_unit(name)) return true;
  return contains_any(lower, {"gyro"}) && is_one_of(bare, {"x", "y", "z"});
}

bool is_time_name(std::string_view name) {
  const auto bare = in_lower_case(strip_unit(name));
  return contains_any(bare, {"time", "date", "stamp", "zeit", "elapsed"}) ||
         is_one_of(bare,
                   {"t",     "s",       "ms",    "us",      "ns",   "sec", "seconds", "second",  "micros",  "millis",
                    "ticks", "x_value", "hours", "minutes", "h",    "min", "datum",   "uhr",     "uhrzeit", "elapsed",
                    "utc",   "fecha",   "hora",  "heure",   "data", "ora", "tow",     "datenum", "epoch",   "days"});
}

namespace {

/// A prefix or factor, and the unit: 0.001 and "dps" for "mdps", 0.01 and "deg/s" for "0.01 deg/s".
struct PrefixedUnit {
  double factor = 1;
  std::string unit{};
};

/// Returns every division of a text into a prefix and a unit. The first one is the whole text as a unit.
std::vector<PrefixedUnit> split_prefix(std::string_view text) {
  std::string unit(trimmed(text));
  std::vector<PrefixedUnit> ways{{1, unit}};
  const std::size_t number = unit.find_first_not_of("0123456789.eE-+");
  if (number > 0 && number != std::string::npos) {
    auto rest = trimmed(std::string_view(unit).substr(number));
    if (rest.starts_with('*') || rest.starts_with('x')) rest = trimmed(rest.substr(1));
    if (const auto factor = record::number_in(unit.substr(0, number)); factor && *factor > 0)
      ways.push_back({*factor, std::string(rest)});
    return ways;
  }
  for (const auto& [prefix, factor] : std::initializer_list<std::pair<std::string_view, double>>{
           {"m", 1e-3}, {"c", 1e-2}, {"d", 1e-1}, {"µ", 1e-6}, {"μ", 1e-6}, {"u", 1e-6}})
    if (unit.size() > prefix.size() && unit.starts_with(prefix)) ways.push_back({factor, unit.substr(prefix.size())});
  return ways;
}

/// Returns the candidates for a unit in a name: the text in brackets, or the text after each "_", longest first.
std::vector<std::string> units_in(std::string_view name) {
  if (const auto unit = unit_in_brackets(name); !unit.empty()) return {std::string(unit)};
  std::vector<std::string> units;
  const auto lower = std::string(name.ends_with(']') ? name.substr(0, name.rfind('[')) : name);
  for (std::size_t at = lower.find_first_of("_. "); at != std::string::npos; at = lower.find_first_of("_. ", at + 1)) {
    const auto before = std::string_view(lower).substr(0, at);
    if (!is_all_digits(before.substr(before.find_last_of("_. ") + 1))) units.push_back(lower.substr(at + 1));
  }
  units.push_back(lower);
  return units;
}

std::optional<double> rate_unit(std::string_view text) {
  constexpr double kRadian = 206264.80624709636, kDegree = 3600;
  auto unit = in_lower_case(text);
  std::erase(unit, ' ');
  if (is_one_of(unit, {"°/h", "deg/h", "°/hr", "deg/hr", "deg_per_h", "deg_h", "dph", "deg/hour", "°/hour", "arcsec/s",
                       "arcsec/sec", "as/s", "degh-1", "degreeh-1", "degreesh-1"}))
    return 1;
  if (is_one_of(unit, {"rad/s", "rad/sec", "rad_per_s", "rad_s", "radps", "gyro_rad", "rads", "rads-1", "rads^-1",
                       "rad.s-1", "rad·s⁻¹"}))
    return kRadian;
  if (is_one_of(unit, {"°/s", "deg/s", "°/sec", "deg/sec", "deg_per_s", "deg_s", "dps", "degree/s", "degrees/s",
                       "degs-1", "deg.s-1", "degree_s", "degrees/second", "degrees-1", "degreess-1"}))
    return kDegree;
  if (is_one_of(unit, {"°/min", "deg/min", "dpm"})) return 60;
  if (is_one_of(unit, {"rad/h", "rad/hr"})) return kRadian / kDegree;
  if (is_one_of(unit, {"rpm", "r/min", "1/min"})) return 21600;
  return std::nullopt;
}

}  // namespace

namespace {

/// Returns whether the unit of a name can only be that of a gyro. Revolutions per minute may be those of a fan.
bool has_rate_unit(std::string_view name) {
  constexpr double kRevolutionPerMinute = 21600;
  const auto rate = degrees_per_hour_in(name);
  return rate && *rate != kRevolutionPerMinute;
}

/// Returns the name without a unit of temperature after a blank: "Ofen" for "Ofen °C".
std::string_view strip_trailing_unit(std::string_view name) {
  for (const std::string_view unit : {" °C", " ℃", " °F", " ℉", " degC"})
    if (name.size() > unit.size() && name.ends_with(unit)) return trimmed(name.substr(0, name.size() - unit.size()));
  return name;
}

/// A letter with an accent in UTF-8, and its letters in ASCII.
struct PlainLetter {
  std::string_view letter{}, ascii{};
};

/// Replaces Latin letters with accents, because names of channels are ASCII.
std::string in_ascii_letters(std::string_view name) {
  static constexpr std::array<PlainLetter, 76> kLetters{{
      {"à", "a"}, {"á", "a"},  {"â", "a"},  {"ã", "a"},  {"ä", "ae"}, {"å", "a"},  {"æ", "ae"}, {"ç", "c"},
      {"è", "e"}, {"é", "e"},  {"ê", "e"},  {"ë", "e"},  {"ì", "i"},  {"í", "i"},  {"î", "i"},  {"ï", "i"},
      {"ñ", "n"}, {"ò", "o"},  {"ó", "o"},  {"ô", "o"},  {"õ", "o"},  {"ö", "oe"}, {"ø", "o"},  {"ù", "u"},
      {"ú", "u"}, {"û", "u"},  {"ü", "ue"}, {"ý", "y"},  {"ÿ", "y"},  {"ß", "ss"}, {"œ", "oe"}, {"À", "A"},
      {"Á", "A"}, {"Â", "A"},  {"Ã", "A"},  {"Ä", "Ae"}, {"Å", "A"},  {"Æ", "Ae"}, {"Ç", "C"},  {"È", "E"},
      {"É", "E"}, {"Ê", "E"},  {"Ë", "E"},  {"Ì", "I"},  {"Í", "I"},  {"Î", "I"},  {"Ï", "I"},  {"Ñ", "N"},
      {"Ò", "O"}, {"Ó", "O"},  {"Ô", "O"},  {"Õ", "O"},  {"Ö", "Oe"}, {"Ø", "O"},  {"Ù", "U"},  {"Ú", "U"},
      {"Û", "U"}, {"Ü", "Ue"}, {"Ý", "Y"},  {"Œ", "Oe"}, {"ą", "a"},  {"ć", "c"},  {"č", "c"},  {"ď", "d"},
      {"ę", "e"}, {"ě", "e"},  {"ğ", "g"},  {"ı", "i"},  {"ł", "l"},  {"ń", "n"},  {"ň", "n"},  {"ř", "r"},
      {"ś", "s"}, {"š", "s"},  {"ż", "z"},  {"ž", "z"},
  }};
  std::string text;
  while (!name.empty()) {
    const auto known =
        std::ranges::find_if(kLetters, [&](const PlainLetter& one) { return name.starts_with(one.letter); });
    if (known == kLetters.end()) {
      text += name.front();
      name.remove_prefix(1);
      continue;
    }
    text += known->ascii;
    name.remove_prefix(known->letter.size());
  }
  return text;
}

}  // namespace

std::optional<double> degrees_per_hour_in(std::string_view name) {
  for (const auto& unit : units_in(name))
    for (const auto& [factor, bare] : split_prefix(unit))
      if (const auto scale = rate_unit(bare)) return factor * *scale;
  return std::nullopt;
}

std::string temperature_unit_in(std::string_view name) {
  if (has_unit(name, {"°c", "℃", "degc", "deg_c", "c", "celsius", "degreec", "degreescelsius", "degree_celsius",
                      "degree_c", "degrees_c", "degrees_celsius", "grad", "gradc"}))
    return "°C";
  if (has_unit(name, {"k", "kelvin", "degk"})) return "K";
  if (has_unit(name, {"°f", "℉", "degf", "deg_f", "f", "fahrenheit", "degreef", "degree_f", "degrees_f"})) return "°F";
  return std::string(unit_in_brackets(name));
}

std::optional<CelsiusScale> celsius_scale(std::string_view unit) {
  constexpr double kZero_k = -273.15, kFahrenheit = 5.0 / 9, kZero_f = -32 * kFahrenheit;
  for (const auto& [factor, bare] : split_prefix(unit)) {
    const auto known = temperature_unit_in("T [" + bare + "]");
    if (known == "°C") return CelsiusScale{factor, 0};
    if (known == "K") return CelsiusScale{factor, kZero_k};
    if (known == "°F") return CelsiusScale{factor * kFahrenheit, kZero_f};
  }
  return std::nullopt;
}

bool is_increment_name(std::string_view name) {
  return contains_any(in_lower_case(name), {"pulse", "dtheta", "delta_angle", "count", "increment"}) &&
         !degrees_per_hour_in(name);
}

std::string time_unit_in(std::string_view name) {
  if (has_unit(name, {"ns", "nsec", "nanosec", "nanosecond", "nanoseconds"})) return "ns";
  // µ is the micro sign, μ the Greek letter.
  if (has_unit(name, {"us", "µs", "μs", "usec", "microsec", "microsecond", "microseconds"})) return "us";
  if (has_unit(name, {"ms", "msec", "millisec", "millisecond", "milliseconds"})) return "ms";
  if (has_unit(name, {"s", "sec", "secs", "second", "seconds", "sek", "sekunden"})) return "s";
  if (has_unit(name, {"min", "mins", "minute", "minutes", "minuten"})) return "min";
  if (has_unit(name, {"h", "hr", "hrs", "hour", "hours", "std", "stunden"})) return "h";
  if (has_unit(name, {"d", "day", "days", "tage"})) return "d";
  if (const auto unit = unit_in_brackets(name); !unit.empty()) return std::string(unit);
  const auto lower = in_lower_case(name);
  const auto ends = [&](std::initializer_list<std::string_view> endings) {
    return std::ranges::any_of(endings, [&](std::string_view ending) { return lower.ends_with(ending); });
  };
  if (ends({"timens", "nanos", "nsec", "nanoseconds"})) return "ns";
  if (ends({"timeus", "micros", "usec", "microseconds"})) return "us";
  if (ends({"timems", "millis", "msec", "milliseconds"})) return "ms";
  if (ends({"sec", "seconds"})) return "s";
  if (ends({"minutes"})) return "min";
  if (ends({"hours"})) return "h";
  return "";
}

std::string axis_in(std::string_view name) {
  const auto bare = in_lower_case(strip_unit(name));
  if (bare.ends_with("[0]")) return "x";
  if (bare.ends_with("[1]")) return "y";
  if (bare.ends_with("[2]")) return "z";
  const char last = bare.empty() ? ' ' : bare.back();
  return last == 'x' || last == 'y' || last == 'z' ? std::string(1, last) : "";
}

std::string channel_name_for(std::string_view column) {
  constexpr std::size_t kMaxNameLength = 64;
  std::string name;
  for (const char c : in_ascii_letters(strip_trailing_unit(strip_unit(column)))) {
    const bool is_allowed = std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '.' || c == '-';
    if (is_allowed && static_cast<unsigned char>(c) < 0x80)
      name += c;
    else if (!name.empty() && name.back() != ' ')
      name += ' ';
  }
  return std::string(trimmed(std::string_view(name).substr(0, kMaxNameLength)));
}

std::vector<std::size_t> gyro_columns(const std::vector<std::string>& names) {
  const auto message_name = [](std::string_view name) { return name.substr(0, name.rfind('.')); };
  const auto contains_gyro = [](const std::string& name) { return contains_any(in_lower_case(name), {"gyr"}); };
  const bool any_contains_gyro =
      std::ranges::any_of(names, [&](const std::string& name) { return is_gyro_name(name) && contains_gyro(name); });
  std::vector<std::size_t> found;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (!is_gyro_name(names[i]) || (any_contains_gyro && !contains_gyro(names[i]))) continue;
    const bool is_of_a_message = names[i].find('.') != std::string::npos;
    if (is_of_a_message && !found.empty() && message_name(names[i]) != message_name(names[found.front()])) continue;
    found.push_back(i);
  }
  return found;
}

}  // namespace gyrotherm::exchange
