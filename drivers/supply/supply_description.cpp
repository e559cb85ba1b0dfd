// SPDX-License-Identifier: Apache-2.0
#include "drivers/supply/supply_description.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <memory>
#include <set>
#include <utility>

#include "core/toml_reader.hpp"

namespace gyrotherm::drivers {
namespace {

bool is_trip(const std::string& name) { return name.ends_with("trip") && name != kClearTrip; }

bool has_codes(const std::string& name) { return name == kOutputState || name == kOverCurrent || is_trip(name); }

const std::vector<std::string>& item_names() {
  static const std::vector<std::string> names{kSetVoltage,
                                              kSetCurrent,
                                              kOverVoltage,
                                              kOverCurrent,
                                              kOutputState,
                                              kMeasuredVoltage,
                                              kMeasuredCurrent,
                                              kClearTrip,
                                              "measurement",
                                              "trip",
                                              "over_voltage_trip",
                                              "over_current_trip",
                                              "over_temperature_trip"};
  return names;
}

/// Reads a description.
class SupplyParser {
 public:
  SupplyParser(const TomlTable& file, const TextParameters& parameters, SupplyDescription& target)
      : file_(file),
        target_(target),
        text_(std::make_shared<TextLink>()),
        templates_(file, read_text_encoding(file.table("link")), parameters) {}

  void read() {
    read_text_instrument(file_, templates_, kLongestTextTimeout, *text_, target_);
    const auto outputs = whole<std::size_t>(file_, "outputs", 1, kMostSupplyOutputs);
    read_simulated(file_.table("simulated"));
    read_output(1);
    read_confidences();
    target_.unit.text_link = text_;
    // The other outputs have the same errors.
    if (!file_.verdict()) return;
    for (std::size_t number = 2; number <= outputs; ++number) read_output(number);
  }

 private:
  void read_output(std::size_t number) {
    const auto templates = templates_.with(kOutputParameter, std::to_string(number));
    SupplyOutput output;
    std::set<std::string> seen;
    const auto tables = file_.tables("item");
    for (const auto& table : tables) {
      const auto name = table.choice("name", item_names());
      if (!seen.insert(name).second) table.note_error("name", fmt::format("duplicate item \"{}\"", name));
      if (table.has("ask")) read_question(table, name, templates, output);
    }
    for (const auto& table : tables) read_item(table, templates, output);
    check_output(output);
    target_.outputs.push_back(std::move(output));
  }

  static void read_question(const TomlTable& table, const std::string& name, const TemplateReader& templates,
                            SupplyOutput& output) {
    SupplyQuestion question{.ask = templates.read_constant(table, "ask", table.text("ask")),
                            .answers = templates.read_all(table, "answer"),
                            .is_asked_twice = table.boolean("twice", false)};
    if (question.answers.empty()) table.note_error("answer", "missing key \"answer\"");
    for (const auto& answer : question.answers)
      for (const auto& field : answer.fields()) {
        if (field.name == "_") continue;
        const auto target = field.name == kTextValueField ? name : field.name;
        if (std::ranges::count(item_names(), target) == 0)
          table.note_error("answer", fmt::format("the field \"{}\" is not the name of an item", field.name));
        if (field.form.count != 0) table.note_error("answer", "a list has no meaning here");
        output.items[target].question = output.questions.size();
        output.items[target].field = field.name;
      }
    output.questions.push_back(std::move(question));
  }

  static void read_item(const TomlTable& table, const TemplateReader& templates, SupplyOutput& output) {
    auto& item = output.items[table.text("name")];
    const auto name = table.text("name");
    (void)one_of(kConfidences, table, "confidence", "unverified");
    (void)table.text("note", "");
    if (table.has("tolerance")) item.tolerance = table.number("tolerance");
    if (!(item.tolerance >= 0)) table.note_error("tolerance", "expected zero or more");
    if (table.has("tell")) item.command = read_command(table, name, templates);
    if (!table.has("tell") && !table.has("ask") && !item.question)
      table.note_error("", "expected \"ask\", \"tell\", or a field of this name in another answer");
    if (table.has("codes")) read_codes(table.table("codes"), name, item);
    if (!table.has("flags")) return;
    const auto flags = table.table("flags");
    for (const auto& flag : flags.keys()) item.flags[flag] = whole<std::uint8_t>(flags, flag.c_str(), 0, 31);
    if (!is_trip(name)) table.note_error("flags", "only a trip has flags");
  }

  static SupplyCommand read_command(const TomlTable& table, const std::string& name, const TemplateReader& templates) {
    SupplyCommand command{.tell = templates.read(table, "tell", table.text("tell")),
                          .acknowledged = templates.read_all(table, "acknowledged"),
                          .then = {}};
    for (const auto& line : texts_at(table, "then"))
      command.then.push_back(templates.read_constant(table, "then", line));
    for (const auto& field : command.tell.fields())
      if (field.name != kTextValueField && field.name != "_")
        table.note_error("tell", fmt::format("the field \"{}\" has no meaning here", field.name));
    const bool has_value = command.tell.find(kTextValueField) != nullptr;
    if (has_value == (name == kClearTrip))
      table.note_error("tell", name == kClearTrip ? "this command sends no value; remove the field \"value\""
                                                  : "the field \"value\" is missing");
    return command;
  }

  static void read_codes(const TomlTable& table, const std::string& name, SupplyItem& item) {
    if (!has_codes(name)) table.note_error("", "this item is a number and has no codes");
    const std::array<const char*, 2> expected =
        is_trip(name) ? std::array{kClearCode, kTrippedCode} : std::array{kOffCode, kOnCode};
    for (const auto* code : expected) {
      item.codes[code] = texts_at(table, code);
      if (item.codes[code].empty()) table.note_error(code, fmt::format("missing code \"{}\"", code));
    }
  }

  void check_output(const SupplyOutput& output) const {
    const auto need = [&](const char* name, bool is_written, bool is_read) {
      const auto* item = output.find(name);
      if (!item) return file_.note_error("item", fmt::format("no item is named \"{}\"", name));
      if (is_written && !item->command) file_.note_error("item", fmt::format("\"{}\" has no \"tell\"", name));
      if (is_read && !item->question) file_.note_error("item", fmt::format("\"{}\" has no \"ask\"", name));
    };
    need(kSetVoltage, true, false);
    need(kSetCurrent, true, false);
    need(kOutputState, true, false);
    need(kMeasuredVoltage, false, true);
    need(kMeasuredCurrent, false, true);
    for (const auto& [name, item] : output.items) check_item(name, item, output);
  }

  void check_item(const std::string& name, const SupplyItem& item, const SupplyOutput& output) const {
    const auto note = [&](const char* what) { file_.note_error("item", fmt::format("\"{}\" {}", name, what)); };
    const bool is_measured = name == kMeasuredVoltage || name == kMeasuredCurrent;
    if (is_measured && item.command) note("cannot be written");
    if (is_trip(name) && (!item.question || item.command)) note("is only read");
    if (is_trip(name) && item.codes.empty() == item.flags.empty()) note("needs either \"codes\" or \"flags\"");
    if (name == kOutputState && item.codes.empty()) note("needs \"codes\"");
    if (!item.question) return;
    for (const auto& answer : output.questions[*item.question].answers) {
      const auto* field = answer.find(item.field);
      if (!field) {
        note("is missing in one form of the answer");
      } else if (const bool is_text = field->form.kind == FieldForm::Kind::text; is_text != !item.codes.empty()) {
        note(is_text ? "is a text, expected a number" : "is a number, expected a text for its codes");
      } else if (!item.flags.empty() && field->form.kind != FieldForm::Kind::integer) {
        note("has flags, expected a whole number");
      }
    }
  }

  void read_confidences() {
    for (const auto& table : file_.tables("item")) {
      ++target_.confidences[one_of(kConfidences, table, "confidence", "unverified")];
      if (const auto note = table.text("note", ""); !note.empty()) target_.notes.push_back(note);
    }
  }

  void read_simulated(const TomlTable& table) {
    const auto encoded = [&](const char* key) {
      auto line = to_encoding(table.text(key, ""), text_->encoding);
      if (!line) table.note_error(key, line.error().what);
      return line.value_or("");
    };
    target_.simulated = {.identity = encoded("identity"), .unknown = encoded("unknown")};
    if (table.has("identity") && !fits_expression(target_.unit.identity->pattern, target_.simulated.identity))
      table.note_error("identity", "does not fit the pattern of [identity]");
  }

  const TomlTable& file_;
  SupplyDescription& target_;
  std::shared_ptr<TextLink> text_;
  TemplateReader templates_;
};

}  // namespace

const SupplyItem* SupplyOutput::find(const std::string& name) const {
  const auto found = items.find(name);
  return found == items.end() ? nullptr : &found->second;
}

bool SupplyDescription::trips_at_current_limit() const {
  const auto* item = outputs.front().find(kOverCurrent);
  return item && !item->codes.empty();
}

Result<SupplyDescription> parse_supply_description(std::string_view text, const std::string& file,
                                                   const TextParameters& parameters) {
  const auto parsed = TomlTable::parse(text, file);
  if (!parsed) return failure(parsed.error());
  SupplyDescription description;
  description.unit.text = text;
  parsed->expect("schema", "gyrotherm-text/1");
  (void)parsed->choice("kind", {"supply"});
  SupplyParser(*parsed, parameters, description).read();
  if (auto verdict = parsed->verdict(); !verdict) return failure(std::move(verdict.error()));
  return description;
}

std::string describe_confidence(const SupplyDescription& description) {
  std::vector<std::string> counts;
  for (const auto& [confidence, count] : description.confidences)
    counts.push_back(fmt::format("{} {}", count, name(confidence)));
  return fmt::format("{} {}; items: {}{}{}", description.outputs.size(),
                     description.outputs.size() == 1 ? "output" : "outputs", fmt::join(counts, ", "),
                     description.notes.empty() ? "" : "; ", fmt::join(description.notes, "; "));
}

std::string settings_refusal_reason(const SupplyDescription& description, const OutputSettings& settings) {
  if (settings.output >= description.outputs.size())
    return fmt::format("the supply has {} outputs", description.outputs.size());
  const auto& output = description.outputs[settings.output];
  if (settings.over_voltage_v && !output.find(kOverVoltage)) return "the supply has no over-voltage protection";
  if (settings.over_current_a && !output.find(kOverCurrent)) return "the supply has no over-current protection";
  if (settings.over_voltage_v && !(*settings.over_voltage_v > settings.voltage_v))
    return "the over-voltage level is not above the voltage";
  if (settings.over_current_a && description.trips_at_current_limit() && *settings.over_current_a != settings.current_a)
    return "the supply trips at its current limit, expected over_current_a equal to current_a";
  return {};
}

}  // namespace gyrotherm::drivers
