// SPDX-License-Identifier: Apache-2.0
#include "report/stored_texts.hpp"

#include <algorithm>
#include <cctype>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "report/event_phrases.hpp"

namespace gyrotherm::report {
namespace {

constexpr StoredPhrase kMissingItems[] = {
    {"records: certificate of a thermometer", "Aufzeichnungen: Kalibrierschein eines Thermometers"},
    {"; without one in the rig file, equipment with role ",
     "; ohne Kalibrierschein in der Prüfstandsdatei: Messeinrichtung mit der Rolle "},
    {": received, on or before ", ": received, spätestens am "},
    {": issued, on or after ", ": issued, frühestens am "},
    {" (UTC) when the calibration began", " (UTC), als die Kalibrierung begann"},
    {" (UTC) when the calibration ended", " (UTC), als die Kalibrierung endete"},
    {" when the unit was received", ", als der Prüfling einging"},
    {": person with role ", ": Person mit der Rolle "},
    {": person ", ": Person "},
    {" with role ", " mit der Rolle "},
    {", whom order.toml names", ", die order.toml nennt"},
    {", which is the example text ", ", das ist noch der Beispieltext "},
    {"laboratory.toml or order.toml", "laboratory.toml oder order.toml"},
    {"records: start times; an imported record has them only if its map states the start of its time",
     "Aufzeichnungen: Anfangszeiten; eine importierte Aufzeichnung hat sie nur, wenn ihre Zuordnung den Beginn der "
     "Zeit nennt"},
    {"records: verified hash chain of ", "Aufzeichnungen: geprüfte Prüfsummenkette von "},
    {"records: start time of ", "Aufzeichnungen: Anfangszeit von "},
    {"; an imported record has one only if its map states the start of its time",
     "; eine importierte Aufzeichnung hat sie nur, wenn ihre Zuordnung den Beginn der Zeit nennt"},
    {"records: a record that the model was not trained on",
     "Aufzeichnungen: eine Aufzeichnung, mit der das Modell nicht trainiert wurde"},
    {"models: one trained on this unit", "Modelle: eines, das mit diesem Prüfling trainiert wurde"},
};

constexpr StoredPhrase kGaps[] = {
    {"the program was not running, or its rows did not reach the disk; {t}",
     "das Programm lief nicht, oder seine Zeilen erreichten den Datenträger nicht; {t}"},
    {"the program was not running, or its rows did not reach the disk",
     "das Programm lief nicht, oder seine Zeilen erreichten den Datenträger nicht"},
    // Texts of earlier versions.
    {"the program was not running; {t}", "das Programm lief nicht; {t}"},
    {"the program was not running", "das Programm lief nicht"},
    {"the program was late", "das Programm war verspätet"},
    {"the program waited for the chamber", "das Programm wartete auf die Kammer"},
    {"by the wall clock it was down for {}, but the machine was started {} ago",
     "nach der Uhr stand es {} still, doch der Rechner wurde erst vor {} gestartet"},
    {"the machine was restarted meanwhile: it was down for {} according to the wall clock only",
     "der Rechner wurde inzwischen neu gestartet: es stand {} still, allein nach der Uhr"},
    {"there is no status file of this run: it was down for {} according to the wall clock only",
     "zu diesem Prüflauf gibt es keine Statusdatei: es stand {} still, allein nach der Uhr"},
};
/// Alarms: the tag and the reaction of the interlock, and its cause.
constexpr StoredPhrase kAlarms[] = {
    {"{t} ({} ×)", "{t} ({} ×)"},
    {"{t} [consequence of line_lost {s}]", "{t} [Folge von line_lost {s}]"},
    {"{t} [consequence of {}]", "{t} [Folge von {}]"},
    {"{n} (warn): {e}", "{n} (warnen): {e}"},
    {"{n} (suspend): {e}", "{n} (anhalten): {e}"},
    {"{n} (hold): {e}", "{n} (halten): {e}"},
    {"{n} (abort): {e}", "{n} (abbrechen): {e}"},
    {"{e}", "{e}"},
};
constexpr StoredPhrase kDropped[] = {{"{} dropped by {}", "{} herausgenommen von {}"}};
constexpr StoredPhrase kReturned[] = {{"{} returned by {}", "{} wieder aufgenommen von {}"}};

/// Writes the decimal point of a number, alone or before " °/h", as a comma.
std::string localise_number(std::string text) {
  constexpr std::string_view kRate = " °/h";
  std::string_view number = text;
  if (number.ends_with(kRate)) number.remove_suffix(kRate.size());
  const auto is_part = [](char c) {
    return std::isdigit(static_cast<unsigned char>(c)) != 0 || c == '.' || c == '-' || c == '+';
  };
  if (std::ranges::all_of(number, is_part) && std::ranges::count(number, '.') == 1)
    text.replace(text.find('.'), 1, ",");
  return text;
}

/// Phrase in its fixed parts and the kinds of the variable parts between them: "{}" is ' ', "{t}" is 't'.
struct ParsedPhrase {
  std::vector<std::string_view> fixed;
  std::string kinds;
};

ParsedPhrase parse_phrase(std::string_view phrase) {
  ParsedPhrase parsed;
  for (auto at = phrase.find('{'); at != std::string_view::npos; at = phrase.find('{')) {
    const auto end = phrase.find('}', at);
    parsed.fixed.push_back(phrase.substr(0, at));
    parsed.kinds += end > at + 1 ? phrase[at + 1] : ' ';
    phrase.remove_prefix(end + 1);
  }
  parsed.fixed.push_back(phrase);
  return parsed;
}

/// Returns whether a text, which begins with the first fixed part of a phrase, contains the others in their order.
/// Every text that matches the phrase does.
bool contains_fixed_parts(std::string_view text, std::string_view phrase) {
  const auto first = phrase.find('{');
  if (first == std::string_view::npos) return text == phrase;
  text.remove_prefix(std::min(first, text.size()));
  phrase.remove_prefix(first);
  while (!phrase.empty()) {
    phrase.remove_prefix(phrase.find('}') + 1);
    const auto part = phrase.substr(0, phrase.find('{'));
    const auto at = text.find(part);
    if (at == std::string_view::npos) return false;
    text.remove_prefix(at + part.size());
    phrase.remove_prefix(part.size());
  }
  return true;
}

using Tables = std::vector<std::span<const StoredPhrase>>;

/// Returns the tables of causes: the texts that a state, an alarm or a fault may have.
const Tables& cause_tables() {
  static const Tables kTables{list_state_phrases(), list_interlock_phrases(), list_fault_phrases()};
  return kTables;
}

/// The bytes that may still be compared with phrases for one event. A text that needs more stays as it is. A text of
/// the program needs far less, but a foreign one might need more than any time.
struct Effort {
  std::size_t left = 20'000'000;
  [[nodiscard]] bool take(std::size_t bytes) {
    left = bytes < left ? left - bytes - 1 : 0;
    return left > 0;
  }
};

/// Translates texts by the phrases of some tables.
class Translator {
 public:
  /// `effort` must outlive this object.
  Translator(Tables tables, Effort& effort) : tables_(std::move(tables)), effort_(effort) {}

  /// Returns the text in German by the first phrase that matches; nothing if none matches.
  [[nodiscard]] std::optional<std::string> translate(std::string_view text) const {
    for (const auto& table : tables_)
      for (const StoredPhrase& phrase : table)
        if (auto translated = translate_by(phrase, text)) return translated;
    return std::nullopt;
  }

 private:
  using Variables = std::vector<std::string>;

  [[nodiscard]] std::optional<std::string> translate_by(const StoredPhrase& phrase, std::string_view text) const {
    if (!text.starts_with(phrase.english.substr(0, phrase.english.find('{'))) || !effort_.take(text.size()) ||
        !contains_fixed_parts(text, phrase.english))
      return std::nullopt;
    const ParsedPhrase english = parse_phrase(phrase.english);
    const auto variables = match(text.substr(english.fixed.front().size()), english, 0);
    if (!variables) return std::nullopt;
    const auto german = parse_phrase(phrase.german).fixed;
    std::string translated(german.front());
    for (std::size_t i = 0; i < variables->size(); ++i) translated += (*variables)[i] + std::string(german[i + 1]);
    return translated;
  }

  /// Returns the translated variable parts from the number `index` on, which fill the text with the fixed parts that
  /// follow them; nothing if the text has another form. A part that must be a text of the table is as long as possible,
  /// other parts are as short as possible.
  [[nodiscard]] std::optional<Variables> match(std::string_view text, const ParsedPhrase& phrase,
                                               std::size_t index) const {
    if (!effort_.take(text.size())) return std::nullopt;
    if (index == phrase.kinds.size()) return text.empty() ? std::optional(Variables()) : std::nullopt;
    const std::string_view next = phrase.fixed[index + 1];
    const bool is_last = index + 1 == phrase.kinds.size(), is_long = is_text(phrase.kinds[index]);
    if (is_last) return text.ends_with(next) ? end_with(text, phrase, index, text.size() - next.size()) : std::nullopt;
    const auto find = [&](std::size_t from) { return is_long ? text.rfind(next, from) : text.find(next, from); };
    for (auto at = find(is_long ? std::string_view::npos : 0); at != std::string_view::npos;
         at = is_long && at == 0 ? std::string_view::npos : find(is_long ? at - 1 : at + 1))
      if (auto found = end_with(text, phrase, index, at)) return found;
    return std::nullopt;
  }

  /// Returns the variable parts if the one of the number `index` is the first `length` bytes of the text. Translates a
  /// part that must be a text of a table last, because that takes longest.
  [[nodiscard]] std::optional<Variables> end_with(std::string_view text, const ParsedPhrase& phrase, std::size_t index,
                                                  std::size_t length) const {
    const char kind = phrase.kinds[index];
    const auto part = text.substr(0, length);
    auto own = is_translated(kind) ? std::nullopt : translate_variable(part, kind);
    if (!own && !is_translated(kind)) return std::nullopt;
    auto rest = match(text.substr(length + phrase.fixed[index + 1].size()), phrase, index + 1);
    if (rest && !own) own = translate_variable(part, kind);
    if (!rest || !own) return std::nullopt;
    rest->insert(rest->begin(), std::move(*own));
    return rest;
  }

  [[nodiscard]] static bool is_text(char kind) { return kind == 't' || kind == 'e'; }
  [[nodiscard]] static bool is_translated(char kind) { return is_text(kind) || kind == 'l'; }

  [[nodiscard]] std::optional<std::string> translate_variable(std::string_view part, char kind) const {
    if (kind == 't') return translate(part);
    if (kind == 'e') return Translator(cause_tables(), effort_).translate(part);
    if (kind == 'l') return translate_list(part);
    if (kind == 's') return translate_subject(part);
    const auto has = [&](std::string_view separator) { return part.find(separator) != std::string_view::npos; };
    if ((kind == 'c' || kind == 'n') && (has(": ") || has("; "))) return std::nullopt;
    if ((kind == 'n' && has(", ")) || (kind == 'p' && has("; the chamber "))) return std::nullopt;
    return localise_number(std::string(part));
  }

  /// Returns a name in German. A name that is in no phrase stays as it is, if it can be a name.
  [[nodiscard]] std::optional<std::string> translate_subject(std::string_view name) const {
    if (auto translated = Translator({list_subject_phrases()}, effort_).translate(name)) return translated;
    const bool is_name = !name.empty() && name.find(": ") == std::string_view::npos &&
                         name.find("; ") == std::string_view::npos && name.find('(') == std::string_view::npos;
    return is_name ? std::optional<std::string>(name) : std::nullopt;
  }

  /// Returns a list in German. An item may contain the separator itself, so an item is as short as possible.
  [[nodiscard]] std::optional<std::string> translate_list(std::string_view list) const {
    constexpr std::string_view kSeparator = "; ";
    for (auto end = list.find(kSeparator); end != std::string_view::npos; end = list.find(kSeparator, end + 1)) {
      const auto one = translate(list.substr(0, end));
      if (!one) continue;
      if (const auto rest = translate_list(list.substr(end + kSeparator.size()))) return *one + "; " + *rest;
    }
    return translate(list);
  }

  Tables tables_;
  Effort& effort_;
};

/// Returns the tables of the texts of a kind of deviation.
Tables find_tables(std::string_view kind) {
  if (kind == "dropped") return {kDropped};
  if (kind == "returned") return {kReturned};
  if (kind == "gap") return {kGaps};
  if (kind == "fault" || kind == "alarm" || kind == "interlock") return {kAlarms};
  if (kind == "note") return {list_run_note_phrases(), list_import_note_phrases()};
  if (kind == "stated") return {};
  return cause_tables();
}

/// Returns the text with the phrase in German; unchanged if it does not contain the phrase.
std::string replace_phrase(std::string text, const StoredPhrase& phrase) {
  if (const auto at = text.rfind(phrase.english); at != std::string::npos)
    text.replace(at, phrase.english.size(), phrase.german);
  return text;
}

bool is_input_number(std::string_view text) {
  return !text.empty() && std::ranges::all_of(text, [](char c) { return c >= '0' && c <= '9'; });
}

/// Returns whether a text is the address of a line: "virtual", "tcp://10.0.0.5:502" or "serial:/dev/ttyUSB0".
bool is_address(std::string_view text) {
  return text == "virtual" || (text.find(':') != std::string_view::npos && text.find(' ') == std::string_view::npos);
}

/// Removes ", input 3" from the end of a description and returns the number; nothing if it does not end so.
std::optional<std::string> take_number(std::string& text, std::string_view label) {
  const auto at = text.rfind(label);
  if (at == std::string::npos || text.size() == at + label.size()) return std::nullopt;
  auto number = text.substr(at + label.size());
  text.erase(at);
  return number;
}

}  // namespace

std::string translate_instrument(plot::Language language, const std::string& stored) {
  if (language != plot::Language::german) return stored;
  constexpr std::string_view kImported = "imported from ";
  if (stored.starts_with(kImported)) return "importiert aus " + stored.substr(kImported.size());
  std::string text = stored, end;
  const auto input = take_number(text, ", input ");
  if (input && !is_input_number(*input)) return stored;
  if (const auto module = input ? take_number(text, ", module ") : std::nullopt) end = ", Modul " + *module;
  if (input) end += ", Eingang " + *input;
  const auto line = text.rfind(" at ");
  if (line == std::string::npos) return text + end;
  auto address = text.substr(line + 4);
  if (!input && !is_address(address)) return stored;
  if (address == "virtual") address = "virtueller Leitung";
  auto name = text.substr(0, line);
  if (name == "virtual chamber") name = "virtuelle Kammer";
  if (const auto number = take_number(name, ", thermometer ")) name += ", Thermometer " + *number;
  return name + " an " + address + end;
}

std::string translate_thermometer(plot::Language language, const std::string& stored) {
  return language == plot::Language::german && stored == "self" ? "eigene" : stored;
}

std::string translate_event(plot::Language language, const std::string& kind, const std::string& stored) {
  if (language != plot::Language::german) return stored;
  constexpr std::size_t kLongestText = 20'000;
  if (stored.size() > kLongestText) return stored;
  Effort effort;
  return Translator(find_tables(kind), effort).translate(stored).value_or(stored);
}

std::string translate_missing(plot::Language language, const std::vector<std::string>& stored) {
  std::string list;
  for (const auto& item : stored) {
    auto text = item;
    if (language == plot::Language::german)
      for (const auto& phrase : kMissingItems) text = replace_phrase(std::move(text), phrase);
    list += (list.empty() ? "" : "; ") + text;
  }
  return list;
}

}  // namespace gyrotherm::report
