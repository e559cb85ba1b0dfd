// SPDX-License-Identifier: Apache-2.0
// Reads the file of a text chamber: its items and their questions and commands.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <map>
#include <memory>
#include <set>
#include <span>
#include <utility>

#include "core/text.hpp"
#include "drivers/chamber/register_map.hpp"
#include "drivers/chamber/text_file_reader.hpp"
#include "drivers/chamber/text_forms.hpp"
#include "drivers/chamber/text_link.hpp"

namespace gyrotherm::drivers {
namespace {

/// Distance between the first registers of two questions. A read of up to kTextReadAtMost registers reaches only one.
constexpr std::uint16_t kQuestionStride = 1024;
constexpr std::size_t kMostQuestions = 48;
constexpr std::uint16_t kCharactersOfText = 64;
constexpr const char* kInputField = "{input:";
constexpr double kUsualResolution = 0.001;

/// Adds the codes of one table.
void read_codes(const TomlTable& table, WrittenCodes& codes) {
  for (const auto& name : table.keys()) {
    if (table.is_table(name)) continue;
    if (table.is_text(name)) {
      codes.texts[name] = texts_at(table, name.c_str());
      continue;
    }
    auto& all = codes.numbers[name];
    if (table.is_list(name))
      all = read_integers(table, name.c_str(), -kLargestCode, kLargestCode);
    else
      all.push_back(table.integer(name));
  }
}

/// Adds the names of `others` to a map. Returns whether each name that both have is the same in both.
template <class Names>
bool add_names(Names& names, const Names& others) {
  bool agree = true;
  for (const auto& [name, value] : others) {
    const auto [known, is_new] = names.emplace(name, value);
    agree = agree && (is_new || known->second == value);
  }
  return agree;
}

/// Adds the bits of one table.
void read_flags(const TomlTable& table, RegisterItem& item) {
  for (const auto& flag : table.keys())
    if (!table.is_table(flag)) item.flags[flag] = whole<std::uint8_t>(table, flag.c_str(), 0, 31);
}

/// Returns the names of the fields in the text of a template that could not be parsed.
std::vector<std::string> find_field_names(const std::string& text) {
  std::vector<std::string> names;
  for (auto begin = text.find('{'); begin != std::string::npos; begin = text.find('{', begin + 1)) {
    const auto end = text.find_first_of(":{}", begin + 1);
    const bool is_name = end != std::string::npos && text[end] != '{' && end > begin + 1;
    if (is_name) names.push_back(text.substr(begin + 1, end - begin - 1));
  }
  return names;
}

/// Returns whether a unit is a spelling of one of a temperature: "degF", "° C", "Kelvin".
bool is_like_temperature(std::string_view unit) {
  std::string letters;
  for (const char c : unit)
    if (std::isalpha(static_cast<unsigned char>(c)) != 0)
      letters += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  for (const std::string_view prefix : {"degrees", "degree", "deg", "grad"})
    if (letters.starts_with(prefix)) letters.erase(0, prefix.size());
  static const std::set<std::string_view> kNames{"c", "f", "k", "celsius", "fahrenheit", "kelvin", "centigrade"};
  const bool has_other = unit.find_first_of("/%*^0123456789") != std::string_view::npos;
  return !has_other && kNames.contains(letters);
}

/// Reads the items of a file: first all questions with the fields of their answers, then the commands.
class ItemReader {
 public:
  /// `any_kind` is set for a file whose kind is not that of a chamber: an item may have no question of its own, its
  /// values are those on the line, and one question may be asked for each of several inputs.
  ItemReader(const TomlTable& file, const TemplateReader& templates, bool any_kind, RegisterMap& map, TextLink& text)
      : templates_(templates), any_kind_(any_kind), map_(map), text_(text) {
    std::set<std::string> names;
    for (const auto& table : file.tables("item")) {
      const auto name = table.text("name");
      if (names.insert(name).second) {
        tables_.push_back(table);
        continue;
      }
      table.note_error("name", fmt::format("duplicate item \"{}\"", name));
      for (const auto& key : table.keys()) table.ignore(key);
    }
    for (const auto& table : tables_) own_.emplace(table.text("name"), &table);
  }

  void read() {
    for (const auto& table : tables_) {
      if (table.has("ask")) read_questions(table);
      if (!any_kind_ && !table.has("ask") && !table.has("tell")) table.note_error("", "expected \"ask\" or \"tell\"");
    }
    add_late_mirrors();
    for (const auto& table : tables_)
      if (table.has("tell")) read_command(table);
    for (const auto& command : text_.commands) check_fields(command);
  }

  void read_identity_question(const TomlTable& table) {
    TextQuery query;
    query.answers = templates_.read_all(table, "answer");
    if (query.answers.empty()) query.answers.push_back(templates_.read(table, "answer", "{value:s}"));
    RegisterItem item;
    item.name = "identity";
    item.type = RegisterType::text;
    item.text.characters = kCharactersOfText;
    item.confidence = one_of(kConfidences, table, "confidence", "unverified");
    begin_question(table, templates_, query);
    text_.identity_question = query.ask;
    text_.identity_answers = query.answers;
    add_cell("value", std::move(item), {}, query);
    text_.queries.push_back(std::move(query));
  }

 private:
  /// Reads the question; further spellings follow it in a list.
  void begin_question(const TomlTable& table, const TemplateReader& templates, TextQuery& query) {
    for (const auto& line : texts_at(table, "ask"))
      query.also_asked.push_back(templates.read_constant(table, "ask", line));
    if (query.also_asked.empty()) return table.note_error("ask", "missing key \"ask\"");
    query.ask = query.also_asked.front();
    query.also_asked.erase(query.also_asked.begin());
    check_line_end(table, "ask", query.ask);
    if (text_.queries.size() == kMostQuestions)
      table.note_error("ask", fmt::format("more than {} questions", kMostQuestions));
    query.first = static_cast<std::uint16_t>(std::min(text_.queries.size(), kMostQuestions) * kQuestionStride);
  }

  void add_cell(const std::string& field, RegisterItem item, CodeTexts codes, TextQuery& query,
                std::optional<std::size_t> position = {}) {
    item.line = query.ask;
    item.address = static_cast<std::uint16_t>(query.first + query.count);
    query.count = static_cast<std::uint16_t>(query.count + word_count(item));
    query.cells.push_back({.field = field, .item = map_.items.size(), .codes = std::move(codes), .position = position});
    map_.items.push_back(std::move(item));
  }

  /// Adds the values of a field that is a list: NAME_1, NAME_2, …
  void add_list(const std::string& field, const FieldForm& form, const RegisterItem& item, const CodeTexts& codes,
                TextQuery& query) {
    for (std::size_t i = 0; i < static_cast<std::size_t>(form.count); ++i) {
      auto one = item;
      one.name += fmt::format("_{}", i + 1);
      add_cell(field, std::move(one), codes, query, i);
    }
  }

  /// Returns the inputs of an item, or those of another item if its question has the field "input".
  [[nodiscard]] std::vector<std::string> find_inputs(const TomlTable& table) const {
    if (!any_kind_) return {};
    if (table.has("inputs")) return table.texts("inputs");
    const auto lines = texts_at(table, "ask");
    const bool has_input =
        std::ranges::any_of(lines, [](const auto& line) { return line.find(kInputField) != std::string::npos; });
    const auto other = std::ranges::find_if(tables_, [](const auto& one) { return one.has("inputs"); });
    return has_input && other != tables_.end() ? other->texts("inputs") : std::vector<std::string>{};
  }

  /// Reads the question of an item, or one question for each of its inputs.
  void read_questions(const TomlTable& table) {
    const auto name = table.text("name");
    const auto inputs = find_inputs(table);
    if (inputs.empty()) read_question(table, templates_, name);
    for (const auto& input : inputs) read_question(table, templates_.with("input", input), name + "_" + input);
  }

  /// Adds the fields of items with their own questions, which may follow in the file.
  void add_late_mirrors() {
    for (const auto& late : late_mirrors_)
      if (const auto* item = find_item(late.item))
        text_.queries[late.query].mirrors.push_back({.field = late.field,
                                                     .item = static_cast<std::size_t>(item - map_.items.data()),
                                                     .codes = find_codes(item)});
  }

  void read_question(const TomlTable& table, const TemplateReader& templates, const std::string& name) {
    TextQuery query;
    for (const auto& line : texts_at(table, "before")) {
      query.before.push_back(templates.read_constant(table, "before", line));
      check_line_end(table, "before", query.before.back());
    }
    query.answers = templates.read_all(table, "answer");
    if (query.answers.empty()) table.note_error("answer", "missing key \"answer\"");
    if (any_kind_ && table.has("within")) query.within = table.duration("within");
    check_answer_ends(table, query.answers, map_);
    begin_question(table, templates, query);
    check_asked_once(table, query);
    for (const auto& answer : query.answers)
      for (const auto& field : answer.fields()) {
        const bool is_known =
            std::ranges::any_of(query.cells, [&](const TextCell& cell) { return cell.field == field.name; });
        if (field.name == "_" || is_known) continue;
        const auto& item_name = field.name == "value" ? name : field.name;
        const auto own = own_.find(item_name);
        const bool has_own_question = own != own_.end() && own->second->has("ask") && own->second != &table;
        if (has_own_question) {
          late_mirrors_.push_back({text_.queries.size(), field.name, item_name});
          continue;
        }
        if (const auto* known = find_item(item_name)) {
          query.mirrors.push_back({.field = field.name,
                                   .item = static_cast<std::size_t>(known - map_.items.data()),
                                   .codes = find_codes(known)});
          continue;
        }
        auto [item, codes] = make_item(item_name, field.form, own == own_.end() ? table : *own->second, &table);
        if (field.form.count > 0)
          add_list(field.name, field.form, item, codes, query);
        else
          add_cell(field.name, std::move(item), std::move(codes), query);
      }
    add_rejected_items(table, name, query);
    for (const auto* key : {"codes", "flags"}) check_named_fields(table, key, name, query);
    if (!any_kind_ && query.count > kTextReadAtMost)
      table.note_error("answer", "the fields of one answer are too many");
    text_.queries.push_back(std::move(query));
  }

  /// Notes an error for codes or flags of a field that no answer to the question has.
  static void check_named_fields(const TomlTable& table, const char* key, const std::string& name,
                                 const TextQuery& query) {
    const auto is_rejected = [](const TextTemplate& answer) { return answer.fields().empty(); };
    if (!table.has(key) || std::ranges::any_of(query.answers, is_rejected)) return;
    const auto all = table.table(key);
    for (const auto& field : all.keys()) {
      const auto has_field = [&](const TextTemplate& answer) {
        return answer.find(field) != nullptr || (field == name && answer.find("value") != nullptr);
      };
      if (all.is_table(field) && std::ranges::none_of(query.answers, has_field))
        all.note_error(field, fmt::format("the answer has no field \"{}\" to which these {} belong", field, key));
    }
  }

  /// Notes an error for a line that contains the characters that are sent after each line.
  void check_line_end(const TomlTable& table, const char* key, const std::string& line) const {
    const auto contains_end = [&](const MapLink& link) {
      const auto& end = link.text.question_end;
      return !link.text.frame && !end.empty() && line.find(end) != std::string::npos;
    };
    if (std::ranges::any_of(map_.links, contains_end))
      table.note_error(
          key, fmt::format("\"{}\" contains \"question_end\", which is sent after each line; remove it", plain(line)));
  }

  /// Notes an error for a question that another item asks with another answer. A virtual unit has one answer to it.
  void check_asked_once(const TomlTable& table, const TextQuery& query) {
    if (any_kind_ || query.ask.empty()) return;
    const auto answers = texts_at(table, "answer");
    const auto [other, is_new] = asked_.emplace(query.ask, std::pair(table.text("name"), answers));
    if (!is_new && other->second.second != answers)
      table.note_error("ask",
                       fmt::format("the item \"{}\" asks the same question and has another answer; write one item "
                                   "whose answer has the fields of both, as in {{air_temperature:f.1}}",
                                   other->second.first));
  }

  /// Adds the items of answers that could not be parsed, so that the rules about them cause no further errors.
  void add_rejected_items(const TomlTable& table, const std::string& name, TextQuery& query) {
    const auto lines = texts_at(table, "answer");
    for (std::size_t i = 0; i < lines.size() && i < query.answers.size(); ++i) {
      if (!query.answers[i].fields().empty()) continue;
      for (const auto& field : find_field_names(lines[i])) {
        const auto item_name = field == "value" ? name : field;
        const auto own = own_.find(item_name);
        const bool has_own_question = own != own_.end() && own->second->has("ask") && own->second != &table;
        if (field == "_" || has_own_question || find_item(item_name)) continue;
        auto [item, codes] = make_item(item_name, std::nullopt, own == own_.end() ? table : *own->second, &table);
        add_cell(field, std::move(item), std::move(codes), query);
      }
    }
  }

  /// Makes an item from its own table, or from that of the question that contains it. An item without a field of its
  /// own has no form.
  std::pair<RegisterItem, CodeTexts> make_item(const std::string& name, const std::optional<FieldForm>& known,
                                               const TomlTable& table, const TomlTable* question) {
    static const std::set<std::string> kSigned{"air_temperature", "set_point", "dew_point"};
    const auto has = [&](const char* key) { return table.has(key); };
    if (kSigned.contains(name) || std::ranges::any_of(std::array{"unit", "scale", "difference", "lowest"}, has))
      text_.quantities.insert(name);
    RegisterItem item;
    item.name = name;
    const auto written = read_all_codes(name, table, question);
    const auto form =
        known.value_or(FieldForm{.kind = written.texts.empty() ? FieldForm::Kind::integer : FieldForm::Kind::text});
    auto texts = assign_codes(table, form, written, item);
    item.type = known && is_text_form(form) && texts.empty() ? RegisterType::text : RegisterType::f64;
    item.text.characters =
        form.kind == FieldForm::Kind::bits ? static_cast<std::uint16_t>(form.width) : kCharactersOfText;
    read_number(table, form, item);
    read_all_flags(table, question, item);
    if (known) check_flags_and_sentinels(table, form, item);
    if (!item.codes.empty() || !item.flags.empty()) make_unscaled(table, item);
    if (auto shared = describe_shared_code(item, texts); !shared.empty()) table.note_error("codes", std::move(shared));
    if (auto shared = describe_shared_bit(item); !shared.empty()) table.note_error("flags", std::move(shared));
    if (!texts.empty()) remove_bounds(table, item);
    if (!texts.empty()) item.unknown_texts = std::make_shared<UnknownTexts>();
    item.otherwise = table.text("otherwise", "");
    if (auto never = describe_unreachable_name(item); known && !never.empty())
      table.note_error(item.flags.empty() ? "codes" : "flags", std::move(never));
    item.confidence = one_of(kConfidences, table, "confidence", "unverified");
    item.note = table.text("note", "");
    return {std::move(item), std::move(texts)};
  }

  /// Reads the codes of an item from its own table, and from that of the question that contains it.
  static WrittenCodes read_all_codes(const std::string& name, const TomlTable& table, const TomlTable* question) {
    WrittenCodes written, own;
    const auto all = question ? question->table("codes") : table.table("codes");
    if (question && all.is_table(name)) read_codes(all.table(name), written);
    if (question == &table) read_codes(all, written);
    if (question == &table || !table.has("codes")) return written;
    read_codes(table.table("codes"), own);
    const bool agree = add_names(own.numbers, written.numbers) && add_names(own.texts, written.texts);
    if (!agree) note_given_twice(table, "codes", name, *question);
    return own;
  }

  static void note_given_twice(const TomlTable& table, const char* key, const std::string& name,
                               const TomlTable& question) {
    table.note_error(key,
                     fmt::format("one of the {1} of \"{0}\" is given twice and differs: here, and as {1}.{0} of the "
                                 "question \"{2}\"",
                                 name, key, question.text("name")));
  }

  /// Reads the flags of an item from its own table, and from that of the question that contains it.
  static void read_all_flags(const TomlTable& table, const TomlTable* question, RegisterItem& item) {
    if (question && question->has("flags")) {
      const auto all = question->table("flags");
      if (all.is_table(item.name)) read_flags(all.table(item.name), item);
    }
    const auto of_question = std::exchange(item.flags, {});
    read_flags(table.table("flags"), item);
    if (!add_names(item.flags, of_question)) note_given_twice(table, "flags", item.name, *question);
  }

  /// Removes the scale and unit that a question states for its numbers from an item with codes or flags. Notes an error
  /// if they belong to the item itself.
  static void make_unscaled(const TomlTable& table, RegisterItem& item) {
    const bool is_scaled = item.scale != 1 || item.fahrenheit || item.step;
    if (is_scaled && table.text("name") == item.name)
      table.note_error(table.has("scale") ? "scale" : "unit",
                       fmt::format("\"{}\" has codes or flags, which have no scale and unit", item.name));
    item.scale = item.resolution = 1;
    item.fahrenheit = item.step = false;
  }

  /// Removes the sentinels and bounds that a question states for its numbers from an item whose codes are texts. Notes
  /// an error if they belong to the item itself.
  static void remove_bounds(const TomlTable& table, RegisterItem& item) {
    const bool is_bounded = !item.sentinels.empty() || item.lowest || item.highest;
    if (is_bounded && table.text("name") == item.name)
      table.note_error(item.sentinels.empty() ? "codes" : "sentinels",
                       fmt::format("the codes of \"{}\" are texts, which have no sentinels and bounds", item.name));
    item.sentinels.clear();
    item.lowest.reset();
    item.highest.reset();
  }

  void read_number(const TomlTable& table, const FieldForm& form, RegisterItem& item) const {
    const auto unit = table.text("unit", "");
    check_unit(table, item.name, unit);
    item.fahrenheit = !any_kind_ && unit == "°F";
    item.step = table.boolean("difference", false);
    item.scale = table.number("scale", 1);
    if (!(item.scale > 0)) table.note_error("scale", "expected a positive number");
    const double finest = form.kind == FieldForm::Kind::number
                              ? (form.decimals < 0 ? kUsualResolution : std::pow(10.0, -form.decimals))
                              : 1.0;
    item.resolution = table.number("resolution", finest * item.scale);
    if (table.has("lowest")) item.lowest = table.number("lowest");
    if (table.has("highest")) item.highest = table.number("highest");
    if (table.has("highest") && table.has("invalid_above"))
      table.note_error("invalid_above", "\"invalid_above\" is another name of \"highest\", expected one of them");
    if (table.has("invalid_above")) item.highest = table.number("invalid_above");
    if (item.lowest && item.highest && *item.lowest > *item.highest)
      table.note_error("lowest", "\"lowest\" is above the highest value, so that no value is possible");
    const auto sentinels = table.table("sentinels");
    for (const auto& why : sentinels.keys()) item.sentinels[why] = sentinels.number(why);
    if (table.has("tolerance")) item.tolerance = table.number("tolerance");
    item.seen_within = table.duration("lags", Duration{});
    // A run cannot wait for a set point that is read back seconds later; the next readings verify it.
    const bool is_set_point = item.name == "set_point";
    item.seen_later = table.boolean("seen_later", is_set_point && item.seen_within > Duration{});
    if (item.seen_later && !is_set_point && table.has("tell"))
      table.note_error("seen_later", "allowed only for the item \"set_point\"");
  }

  /// Notes an error for a temperature in another unit than °C and °F, which would be read as °C. A difference may be in
  /// K.
  void check_unit(const TomlTable& table, const std::string& item, const std::string& unit) const {
    static constexpr std::array kTemperatures{"air_temperature", "set_point", "dew_point"};
    const bool is_temperature = std::ranges::count(kTemperatures, item) > 0;
    if (any_kind_ || unit.empty() || unit == "°C" || unit == "°F") return;
    if (unit == "K" && table.boolean("difference", false) && !is_temperature) return;
    if (is_temperature || is_like_temperature(unit))
      table.note_error(
          "unit", fmt::format("\"{}\" is not a unit of a temperature, expected one of: \"°C\", \"°F\"", plain(unit)));
  }

  void read_command(const TomlTable& table) {
    const auto name = table.text("name");
    TextCommand command;
    command.tell = templates_.read(table, "tell", table.text("tell"));
    command.acknowledged = templates_.read_all(table, "acknowledged");
    auto* item = find_item(name);
    const auto* value = command.tell.find("value");
    if (!item) {
      auto made = make_item(name, value ? std::optional(value->form) : std::nullopt, table, nullptr);
      made.first.readable = false;
      made.first.self_clearing = true;
      made.first.address = static_cast<std::uint16_t>(kMostQuestions * kQuestionStride + next_command_);
      made.first.line = table.text("tell");
      next_command_ = static_cast<std::uint16_t>(next_command_ + word_count(made.first));
      command.codes = std::move(made.second);
      map_.items.push_back(std::move(made.first));
      item = &map_.items.back();
    } else {
      check_carries_value(table, command.tell, name);
      command.codes = find_codes(item);
      if (value && value->form.decimals >= 0)
        item->resolution = std::max(item->resolution, std::pow(10.0, -value->form.decimals) * item->scale);
    }
    item->writable = true;
    check_line_end(table, "tell", command.tell.format({}));
    for (const auto& line : texts_at(table, "then")) {
      command.then.push_back(templates_.read_constant(table, "then", line));
      check_line_end(table, "then", command.then.back());
    }
    if (table.has("then_when") && command.then.empty())
      table.note_error("then_when", "expected the lines of \"then\" to which this condition belongs");
    if (table.has("then_when"))
      command.then_when = std::make_shared<const Condition>(read_readable_condition(table.table("then_when"), map_));
    const bool has_effect = table.has("effect");
    // Notes an error if no readable item has this name.
    if (has_effect) (void)is_readable(table, "effect", table.text("effect"));
    // The readers of other kinds have rules of their own for commands without an answer.
    if (!any_kind_ && command.acknowledged.empty() && !item->readable && item->seen_in.empty() && !has_effect)
      table.note_error("tell", "this command is neither acknowledged nor read back");
    command.item = static_cast<std::size_t>(item - map_.items.data());
    tables_of_commands_.push_back(&table);
    text_.commands.push_back(std::move(command));
  }

  /// Notes an error for a command of an item that sends neither the value nor a field of the item's name.
  static void check_carries_value(const TomlTable& table, const TextTemplate& tell, const std::string& item) {
    if (!tell.find("value") && !tell.find(item))
      table.note_error("tell",
                       fmt::format("the command does not send the value of \"{}\", expected {{value}} in it", item));
  }

  /// Returns whether an item can be read, and notes an error if it cannot.
  [[nodiscard]] bool is_readable(const TomlTable& table, const char* key, const std::string& name) const {
    const auto* item = find_named_item(map_, table, key, name);
    if (item && !item->readable) table.note_error(key, fmt::format("the item \"{}\" cannot be read", name));
    return item && item->readable;
  }

  void check_fields(const TextCommand& command) const {
    const auto& table = *tables_of_commands_[static_cast<std::size_t>(&command - text_.commands.data())];
    for (const auto& field : command.tell.fields()) {
      if (field.name == "_" || field.name == "value") continue;
      const auto* other = map_.find(field.name);
      if (!other || !other->readable)
        table.note_error("tell", fmt::format("the field \"{}\" is not an item that can be read", field.name));
    }
  }

  [[nodiscard]] CodeTexts find_codes(const RegisterItem* item) const {
    for (const auto& query : text_.queries)
      for (const auto& cell : query.cells)
        if (&map_.items[cell.item] == item) return cell.codes;
    return {};
  }

  [[nodiscard]] RegisterItem* find_item(const std::string& name) const {
    const auto found = std::ranges::find(map_.items, name, &RegisterItem::name);
    return found == map_.items.end() ? nullptr : &*found;
  }

  const TemplateReader& templates_;
  bool any_kind_;
  RegisterMap& map_;
  TextLink& text_;
  /// A field of a question whose item has its own question.
  struct LateMirror {
    std::size_t query{};
    std::string field, item;
  };
  std::vector<LateMirror> late_mirrors_;
  /// Question → the first item that asks it, and its answers.
  std::map<std::string, std::pair<std::string, std::vector<std::string>>> asked_;
  std::vector<TomlTable> tables_;
  std::map<std::string, const TomlTable*> own_;
  std::vector<const TomlTable*> tables_of_commands_;
  std::uint16_t next_command_ = 0;
};

}  // namespace

namespace {

void read_any_text_unit(const TomlTable& file, const TextParameters& parameters, const TextParameters& own_parameters,
                        bool any_kind, RegisterMap& map) {
  map.name = file.text("name");
  map.vendor = file.text("vendor");
  for (const auto* documentation : {"model", "firmware"}) (void)file.text(documentation, "");
  (void)file.text("source");
  auto text = std::make_shared<TextLink>();
  map.text_link = text;
  const auto link = file.table("link");
  text->encoding = read_text_encoding(link);
  TemplateReader templates(file, text->encoding, parameters);
  for (const auto& [name, value] : own_parameters) templates = templates.with(name, value);
  map.parameters = templates.parameters();
  read_text_links(link, templates, any_kind ? kLongestScanTimeout : kLongestTextTimeout, map);
  read_text_refusals(link, templates, *text);
  ItemReader items(file, templates, any_kind, map, *text);
  const auto identity = file.table("identity");
  const bool has_identity = file.has("identity");
  if (has_identity && identity.has("ask")) items.read_identity_question(identity);
  items.read();
  if (has_identity) {
    Fingerprint print{.item = identity.has("ask") ? "identity" : identity.text("item"),
                      .pattern = read_identity_pattern(identity, templates),
                      .is_expression = true};
    (void)find_named_item(map, identity, "item", print.item);
    map.identity = std::move(print);
    if (!any_kind) read_verification(identity, map);
  }
  if (!any_kind && file.has("profile_memory"))
    text->memory = read_text_memory(file.table("profile_memory"), templates, map);
}

}  // namespace

void read_text_unit(const TomlTable& file, const TextParameters& parameters, RegisterMap& map) {
  (void)file.choice("kind", {"chamber"});
  read_any_text_unit(file, parameters, {}, false, map);
}

void read_text_lines(const TomlTable& file, const TextParameters& parameters, const TextParameters& own_parameters,
                     RegisterMap& map) {
  read_any_text_unit(file, parameters, own_parameters, true, map);
}

const TextQuery* TextLink::find_query(std::uint16_t address) const {
  const auto found = std::ranges::find_if(
      queries, [&](const TextQuery& query) { return address >= query.first && address < query.first + query.count; });
  return found == queries.end() ? nullptr : &*found;
}

const TextMemoryLine* TextLink::find_memory_line(std::uint16_t address) const {
  const auto found = std::ranges::find_if(memory, [&](const TextMemoryLine& line) { return line.contains(address); });
  return found == memory.end() ? nullptr : &*found;
}

const TextCommand* TextLink::find_command(const RegisterMap& map, std::uint16_t address) const {
  const auto found = std::ranges::find_if(
      commands, [&](const TextCommand& command) { return map.items[command.item].address == address; });
  return found == commands.end() ? nullptr : &*found;
}

std::optional<std::vector<std::uint16_t>> to_words(const TextCell& cell, const RegisterItem& item,
                                                   const FieldValue& value) {
  if (item.type == RegisterType::text) {
    const auto* text = std::get_if<std::string>(&value);
    return text ? std::optional(encode_text(item.text, *text)) : std::nullopt;
  }
  auto raw = item;
  raw.scale = 1;
  raw.offset = 0;
  raw.fahrenheit = false;
  if (const auto* text = std::get_if<std::string>(&value)) {
    const auto found = std::ranges::find(cell.codes, *text);
    if (found != cell.codes.end()) return encode_as_read(raw, static_cast<double>(found - cell.codes.begin()));
    return encode_as_read(raw, item.unknown_texts ? item.unknown_texts->assign_number(*text) : -1.0);
  }
  const auto* list = std::get_if<std::vector<double>>(&value);
  const auto position = cell.position.value_or(0);
  const auto* number =
      list && cell.position && position < list->size() ? &(*list)[position] : std::get_if<double>(&value);
  return number ? std::optional(encode_as_read(raw, *number)) : std::nullopt;
}

FieldValue to_field(const RegisterItem& item, const CodeTexts& codes, std::span<const std::uint16_t> words) {
  if (item.type == RegisterType::text) return decode_text(item.text, words);
  const double raw = raw_value(item, words);
  if (codes.empty()) return raw;
  if (!(raw >= 0)) return item.unknown_texts ? item.unknown_texts->find_text(raw).value_or("") : std::string();
  return raw < static_cast<double>(codes.size()) ? codes[static_cast<std::size_t>(raw)] : std::string();
}

}  // namespace gyrotherm::drivers
