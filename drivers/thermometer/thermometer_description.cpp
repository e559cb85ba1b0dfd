// SPDX-License-Identifier: Apache-2.0
#include "drivers/thermometer/thermometer_description.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <memory>
#include <set>
#include <utility>

#include "core/toml_reader.hpp"

namespace gyrotherm::drivers {
namespace {

constexpr const char *kReadingsItem = "readings", *kStatusItem = "status", *kInputParameter = "input";
constexpr double kDegreesFahrenheitPerKelvin = 1.8, kFahrenheitOfZeroCelsius = 32;

constexpr auto kTemperatureUnits =
    make_vocabulary<TemperatureUnit::celsius, TemperatureUnit::fahrenheit>("°C", "K", "°F");

/// Reads a description.
class DescriptionParser {
 public:
  DescriptionParser(const TomlTable& file, const TextParameters& parameters, ThermometerDescription& target)
      : file_(file),
        target_(target),
        text_(std::make_shared<TextLink>()),
        templates_(file, read_text_encoding(file.table("link")), parameters) {}

  void read() {
    read_text_instrument(file_, templates_, kLongestScanTimeout, *text_, target_);
    read_items();
    read_simulated(file_.table("simulated"));
    target_.unit.text_link = std::move(text_);
  }

 private:
  void read_items() {
    const TomlTable *readings = nullptr, *status = nullptr;
    const auto tables = file_.tables("item");
    for (const auto& table : tables) {
      const auto name = table.choice("name", {kReadingsItem, kStatusItem});
      auto& found = name == kReadingsItem ? readings : status;
      if (found) table.note_error("name", fmt::format("duplicate item \"{}\"", name));
      found = &table;
    }
    if (!readings) return file_.note_error("item", "no item is named \"readings\"");
    read_readings(*readings);
    for (const auto& question : target_.readings) check_answer_ends(*readings, question.answers, target_.unit);
    const bool is_in_answer = has_status(*readings, target_.readings);
    if (status) read_status(*status, *readings, is_in_answer);
    if (is_in_answer && target_.flags.empty())
      readings->note_error("answer", "the field \"status\" needs an item of this name with \"flags\"");
  }

  void read_readings(const TomlTable& table) {
    if (table.has("count") == table.has("inputs")) table.note_error("", "expected one of \"count\" and \"inputs\"");
    if (table.has("count")) target_.inputs = read_count(table);
    names_ = table.texts("inputs");
    if (!names_.empty()) target_.inputs = names_.size();
    if (target_.inputs == 0 || target_.inputs > kMostTextInputs)
      table.note_error("inputs", fmt::format("{} inputs, expected 1 to {}", target_.inputs, kMostTextInputs));
    target_.readings = read_questions(table, true);
    if (table.has("within")) target_.within = table.duration("within");
    if (target_.within.value_or(Duration{}) > kLongestReading) table.note_error("within", "expected at most 10 s");
    target_.temperature_unit = one_of(kTemperatureUnits, table, "unit", "°C");
    if (table.has("invalid_above")) target_.invalid_above = table.number("invalid_above");
    const auto range = table.numbers("range");
    if (range.size() == 2 && range[0] < range[1])
      target_.range = {{range[0]}, {range[1]}};
    else
      table.note_error("range", "expected [lowest, highest], the possible temperatures in °C");
    read_confidence(table);
  }

  /// Reads the number of inputs, or the name of the parameter that contains it.
  std::size_t read_count(const TomlTable& table) const {
    if (!table.is_text("count")) return whole<std::size_t>(table, "count", 1, kMostTextInputs, 1);
    const auto name = table.text("count");
    const auto found = templates_.parameters().find(name);
    if (found == templates_.parameters().end()) {
      table.note_error("count", fmt::format("\"{}\" is neither a number nor a parameter", name));
      return 1;
    }
    std::size_t count = 0;
    const auto& text = found->second;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), count);
    const bool is_whole = error == std::errc{} && end == text.data() + text.size();
    if (!is_whole || count < 1 || count > kMostTextInputs)
      table.note_error("count", fmt::format("the parameter \"{}\" is {}, expected a whole number from 1 to {}", name,
                                            text, kMostTextInputs));
    return std::clamp<std::size_t>(count, 1, kMostTextInputs);
  }

  void read_status(const TomlTable& table, const TomlTable& readings, bool is_in_answer) {
    const auto flags = table.table("flags");
    for (const auto& flag : flags.keys()) target_.flags[flag] = whole<std::uint8_t>(flags, flag.c_str(), 0, 31);
    if (target_.flags.empty()) table.note_error("flags", "missing key \"flags\"");
    read_confidence(table);
    if (!is_in_answer) {
      target_.statuses = read_questions(table, false);
    } else if (table.has("ask")) {
      table.note_error("ask", fmt::format("the status is already in the answer at {}", readings.location("answer")));
    }
  }

  void read_confidence(const TomlTable& table) {
    const auto confidence = one_of(kConfidences, table, "confidence", "unverified");
    target_.confidence = table.text("name") == kReadingsItem ? confidence : std::max(target_.confidence, confidence);
    if (const auto note = table.text("note", ""); !note.empty()) target_.notes.push_back(note);
  }

  /// Reads one question for each of `inputs`, or one for all inputs.
  std::vector<InputQuestion> read_questions(const TomlTable& table, bool may_have_status) {
    if (names_.empty()) return {read_question(table, templates_, 0, target_.inputs, may_have_status)};
    std::vector<InputQuestion> questions;
    for (const auto& name : names_)
      questions.push_back(
          read_question(table, templates_.with(kInputParameter, name), questions.size(), 1, may_have_status));
    return questions;
  }

  static InputQuestion read_question(const TomlTable& table, const TemplateReader& templates, std::size_t first,
                                     std::size_t count, bool may_have_status) {
    InputQuestion question{.before = {}, .ask = {}, .answers = {}, .first = first, .count = count};
    for (const auto& line : texts_at(table, "before"))
      question.before.push_back(templates.read_constant(table, "before", line));
    question.ask = templates.read_constant(table, "ask", table.text("ask"));
    question.answers = templates.read_all(table, "answer");
    if (question.answers.empty()) table.note_error("answer", "missing key \"answer\"");
    for (const auto& answer : question.answers) check_answer(table, answer, count, may_have_status);
    return question;
  }

  /// Notes an error unless the answer has a number for each input, and no other field.
  static void check_answer(const TomlTable& table, const TextTemplate& answer, std::size_t count,
                           bool may_have_status) {
    const auto expected = count == 1 ? 0 : static_cast<int>(count);
    const auto fits = [&](const std::string& field, const FieldForm& form) {
      const bool is_whole = form.kind == FieldForm::Kind::integer;
      return (field == kReadingField && may_have_status ? is_numeric_form(form) : is_whole) &&
             (form.count == expected || (count == 1 && form.count == 1));
    };
    if (!answer.find(kReadingField)) table.note_error("answer", "expected the field \"value\"");
    for (const auto& field : answer.fields()) {
      const bool is_known = field.name == kReadingField || (may_have_status && field.name == kReadingStatusField);
      if (field.name == "_") continue;
      if (!is_known)
        table.note_error("answer", fmt::format("the field \"{}\" has no meaning here", field.name));
      else if (!fits(field.name, field.form))
        table.note_error("answer", fmt::format("the field \"{}\" is not {}", field.name,
                                               count == 1 ? "a number" : fmt::format("a list of {} numbers", count)));
    }
  }

  /// Returns whether the answers have the field "status". It must be in all of them or in none.
  static bool has_status(const TomlTable& table, const std::vector<InputQuestion>& questions) {
    const auto has_field = [](const TextTemplate& answer) { return answer.find(kReadingStatusField) != nullptr; };
    const auto& answers = questions.front().answers;
    const bool is_in_some = std::ranges::any_of(answers, has_field);
    if (is_in_some && !std::ranges::all_of(answers, has_field))
      table.note_error("answer", "the field \"status\" is missing in one form of the answer");
    return is_in_some;
  }

  void read_simulated(const TomlTable& table) {
    auto& simulated = target_.simulated;
    const auto encoded = [&](const char* key) {
      auto line = to_encoding(table.text(key, ""), text_->encoding);
      if (!line) table.note_error(key, line.error().what);
      return line.value_or("");
    };
    simulated.identity = encoded("identity");
    simulated.number = table.text("number", "");
    simulated.invalid = encoded("invalid");
    simulated.invalid_status = whole<std::int64_t>(table, "invalid_status", 0, 0xFFFFFFFF, 0);
    simulated.unknown = encoded("unknown");
    if (!is_number_format(simulated.number))
      table.note_error("number", "expected a format such as \"+.8E\" or \"+08.3f\"");
    if (!fits_expression(target_.unit.identity->pattern, simulated.identity) && table.has("identity"))
      table.note_error("identity", "does not fit the pattern of [identity]");
  }

  /// Returns whether the text is empty, or an optional sign, zero and width, a point, decimals, and "E" or "f".
  static bool is_number_format(std::string_view text) {
    if (text.empty()) return true;
    const auto skip = [&](std::string_view characters, std::size_t most) {
      for (; most > 0 && !text.empty() && characters.find(text.front()) != std::string_view::npos; --most)
        text.remove_prefix(1);
    };
    skip("+", 1);
    skip("0123456789", 2);
    if (!text.starts_with('.') || text.size() != 3) return false;
    return text[1] >= '0' && text[1] <= '9' && (text[2] == 'E' || text[2] == 'f');
  }

  static constexpr Duration kLongestReading = std::chrono::seconds(10);

  const TomlTable& file_;
  ThermometerDescription& target_;
  std::shared_ptr<TextLink> text_;
  TemplateReader templates_;
  /// Names of the inputs, if each has its own question.
  std::vector<std::string> names_;
};

}  // namespace

Result<ThermometerDescription> parse_thermometer_description(std::string_view text, const std::string& file,
                                                             const TextParameters& parameters) {
  const auto parsed = TomlTable::parse(text, file);
  if (!parsed) return failure(parsed.error());
  ThermometerDescription description;
  description.unit.text = text;
  parsed->expect("schema", "gyrotherm-text/1");
  (void)parsed->choice("kind", {"thermometer"});
  DescriptionParser(*parsed, parameters, description).read();
  if (auto verdict = parsed->verdict(); !verdict) return failure(std::move(verdict.error()));
  return description;
}

Result<Celsius> convert_reading(const ThermometerDescription& description, std::size_t input, double number,
                                std::int64_t status) {
  const auto where = fmt::format("input {}", input + 1);
  std::vector<std::string> flags;
  for (const auto& [flag, bit] : description.flags)
    if ((status >> bit & 1) != 0) flags.push_back(flag);
  if (!flags.empty())
    return failure(FaultKind::out_of_range, where,
                   fmt::format("the instrument reports {} (status {})", fmt::join(flags, ", "), status));
  if (description.invalid_above && !(std::abs(number) <= *description.invalid_above))
    return failure(FaultKind::out_of_range, where, fmt::format("overload or open input ({:g})", number));
  Celsius reading{number};
  if (description.temperature_unit == TemperatureUnit::kelvin) reading.value = number - kZeroCelsiusInKelvin;
  if (description.temperature_unit == TemperatureUnit::fahrenheit)
    reading.value = (number - kFahrenheitOfZeroCelsius) / kDegreesFahrenheitPerKelvin;
  return check_range(description.range, reading, where);
}

double to_number(const ThermometerDescription& description, Celsius reading) {
  switch (description.temperature_unit) {
    case TemperatureUnit::kelvin: return reading.value + kZeroCelsiusInKelvin;
    case TemperatureUnit::fahrenheit: return reading.value * kDegreesFahrenheitPerKelvin + kFahrenheitOfZeroCelsius;
    case TemperatureUnit::celsius: break;
  }
  return reading.value;
}

std::string describe_confidence(const ThermometerDescription& description) {
  return fmt::format("{} inputs: {}{}{}", description.inputs, name(description.confidence),
                     description.notes.empty() ? "" : "; ", fmt::join(description.notes, "; "));
}

}  // namespace gyrotherm::drivers
