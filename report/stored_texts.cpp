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

namespace gyrotherm::report {
namespace {

struct StoredPhrase {
  std::string_view english, german;
};

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

// Fixed texts of the program. A {} is a variable part that stays as it is, such as a name or a number. A {c} is one
// without ": " and "; ", an {n} also without ", ", and a {p} consists of the words of a person. A {t} must itself be a
// text of the same table, and an {l} a list of such texts, separated by "; "; otherwise the phrase does not match. A
// text is therefore translated wholly or not at all. The first phrase that matches is used. The German text has the
// variable parts in the same order.

/// States of a run, their causes, and the evidence for the safe state of the chamber.
constexpr StoredPhrase kStates[] = {
    {"{t}; supply {n} off", "{t}; Netzgerät {n} aus"},
    {"{t}; the chamber was sent to {} °C and switched off ({l})",
     "{t}; die Kammer wurde auf {} °C gestellt und ausgeschaltet ({l})"},
    {"{t}; the chamber was sent to {} °C ({l})", "{t}; die Kammer wurde auf {} °C gestellt ({l})"},
    {"{t}; the chamber was sent to {} °C and switched off, and is NOT confirmed safe yet ({l})",
     "{t}; die Kammer wurde auf {} °C gestellt und ausgeschaltet, ist aber noch NICHT als sicher bestätigt ({l})"},
    {"{t}; the chamber was sent to {} °C, and is NOT confirmed safe yet ({l})",
     "{t}; die Kammer wurde auf {} °C gestellt, ist aber noch NICHT als sicher bestätigt ({l})"},
    {"{t}; the chamber was sent to {} °C, but its air does NOT follow ({l})",
     "{t}; die Kammer wurde auf {} °C gestellt, doch ihre Luft folgt NICHT ({l})"},
    {"held: {t}", "gehalten: {t}"},
    {"suspended: {t}", "angehalten: {t}"},
    {"aborting: {t}", "Abbruch: {t}"},
    {"aborted: {t}", "abgebrochen: {t}"},
    {"stopped: {t}", "beendet: {t}"},
    {"execute: the profile continues, after: {t}", "das Profil wird fortgesetzt nach: {t}"},
    {"execute: the profile goes on, after: {t}", "das Profil wird fortgesetzt nach: {t}"},
    {"on the way back to the profile after: {t}", "auf dem Rückweg zum Profil nach: {t}"},
    {"the air is not at the first set point of the profile", "die Luft ist nicht beim ersten Sollwert des Profils"},
    {"resumed after an unknown time; cause of the interruption: {t}",
     "fortgesetzt nach unbekannter Zeit; Ursache der Unterbrechung: {t}"},
    {"resumed after {}; cause of the interruption: {t}", "fortgesetzt nach {}; Ursache der Unterbrechung: {t}"},
    {"the program ended without stating a reason; it was {t}",
     "das Programm endete ohne Angabe eines Grundes; es war {t}"},
    {"the program ended without stating a reason", "das Programm endete ohne Angabe eines Grundes"},
    {"held for {}: {t}", "gehalten während {}: {t}"},
    {"suspended for {}: {t}", "angehalten während {}: {t}"},
    {"returning for {}: {t}", "auf dem Rückweg während {}: {t}"},
    {"paused by {p}", "angehalten von {p}"},
    {"stopped by a signal", "beendet durch ein Signal"},
    {"stopped by {p}", "beendet von {p}"},
    {"aborted by {p}", "abgebrochen von {p}"},
    // Set point, mode and air of a chamber in its safe state
    {"{t} (read {} ago)", "{t} (vor {} gelesen)"},
    {"air {} °C, {} °C {} before: near {} °C", "Luft {} °C, {} °C {} zuvor: nahe {} °C"},
    {"air {} °C, {} °C {} before: moves towards {} °C", "Luft {} °C, {} °C {} zuvor: bewegt sich zu {} °C hin"},
    {"air {} °C, {} °C {} before: moves AWAY from {} °C", "Luft {} °C, {} °C {} zuvor: bewegt sich WEG von {} °C"},
    {"air {} °C, {} °C {} before: does NOT move towards {} °C",
     "Luft {} °C, {} °C {} zuvor: bewegt sich NICHT zu {} °C hin"},
    {"air {} °C, {} °C {} before: being watched", "Luft {} °C, {} °C {} zuvor: wird beobachtet"},
    {"air {} °C, {} °C {} before: drifts as in a switched-off chamber",
     "Luft {} °C, {} °C {} zuvor: driftet wie in einer ausgeschalteten Kammer"},
    {"air {} °C: near {} °C", "Luft {} °C: nahe {} °C"},
    {"air {} °C: being watched", "Luft {} °C: wird beobachtet"},
    {"air {} °C, not watched", "Luft {} °C, nicht beobachtet"},
    {"the air has not been read", "die Luft wurde nicht gelesen"},
    {"set point read back", "Sollwert zurückgelesen"},
    {"set point acknowledged", "Sollwert quittiert"},
    {"set point NOT acknowledged", "Sollwert NICHT quittiert"},
    {"set point NOT shown: reads {} °C", "Sollwert NICHT angezeigt: {} °C gelesen"},
    {"the set point has not been read", "der Sollwert wurde nicht gelesen"},
    {"mode NOT shown", "Betriebsart NICHT angezeigt"},
    {"mode not in its map", "Betriebsart nicht in der Registerbeschreibung"},
    {"switched off, as acknowledged", "ausgeschaltet, wie quittiert"},
    {"mode NOT shown: {t}", "Betriebsart NICHT angezeigt: {t}"},
    {"mode {t}", "Betriebsart {t}"},
    {"off", "aus"},
    {"running", "in Betrieb"},
    {"not following its set point", "folgt ihrem Sollwert nicht"},
    {"program", "Programm"},
    {"ramping", "Rampe"},
    {"soaking", "Durchwärmung"},
    {"waiting", "wartet"},
    {"holding", "hält"},
    {"done", "fertig"},
    {"door open", "Tür offen"},
    {"emergency stop", "Not-Halt"},
    {"power failure", "Netzausfall"},
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
constexpr StoredPhrase kFaults[] = {
    {"{t} ({} ×)", "{t} ({} ×)"},
    {"{} s without a tick: the program was late", "{} s ohne Takt: das Programm war verspätet"},
    {"{} s without a tick: the program waited for the chamber", "{} s ohne Takt: das Programm wartete auf die Kammer"},
    {"the frame counter restarted; the counts before it are lost",
     "der Rahmenzähler begann neu; die Zählungen davor sind verloren"},
    {"{}: the frame counter restarted; the counts before it are lost",
     "{}: der Rahmenzähler begann neu; die Zählungen davor sind verloren"},
};
/// Notes of an import about its file and its channels.
constexpr StoredPhrase kImportNotes[] = {
    {"warning: {t}", "Warnung: {t}"},
    {"{} of {} values of {} are missing ({} %); rows without a rate are not used",
     "{} von {} Werten von {} fehlen ({} %); Zeilen ohne Drehrate werden nicht verwendet"},
    {"{} of {} values of {} are missing ({} %); clusters with a missing temperature are left out, unless the map does "
     "not name the channel",
     "{} von {} Werten von {} fehlen ({} %); Mittelwerte mit einer fehlenden Temperatur entfallen, außer wenn die "
     "Zuordnung den Kanal nicht nennt"},
    {"{t}: the sensor has probably failed; train with --clusters before or after them",
     "{t}: der Sensor ist wahrscheinlich ausgefallen; mit --clusters davor oder danach trainieren"},
    {"{t}: the sensor has probably failed; train with --clusters before or after them, or remove {} from the map",
     "{t}: der Sensor ist wahrscheinlich ausgefallen; mit --clusters davor oder danach trainieren oder {} aus der "
     "Zuordnung entfernen"},
    {"{t}: the sensor has probably failed; valid = [LOW, HIGH] of its column in the map marks them as missing",
     "{t}: der Sensor ist wahrscheinlich ausgefallen; valid = [LOW, HIGH] seiner Spalte in der Zuordnung kennzeichnet "
     "sie als fehlend"},
    {"{t}: the sensor has probably failed; missing = [{}] in [file], or valid = [LOW, HIGH] of its column, marks them "
     "as "
     "missing",
     "{t}: der Sensor ist wahrscheinlich ausgefallen; missing = [{}] in [file] oder valid = [LOW, HIGH] seiner Spalte "
     "kennzeichnet sie als fehlend"},
    {"{} repeats {} {} in {} consecutive values, from row {} ({}) to row {} ({})",
     "{} wiederholt {} {} in {} aufeinanderfolgenden Werten, von Zeile {} ({}) bis Zeile {} ({})"},
    {"{t}, while {} moves from {} to {} °C", "{t}, während sich {} von {} auf {} °C ändert"},
    {"{t}, after a jump from {} {}", "{t}, nach einem Sprung von {} {}"},
    {"{t}, until a jump to {} {}", "{t}, bis zu einem Sprung auf {} {}"},
    {"{t}, although its other values vary by about {} {} from row to row",
     "{t}, obwohl seine übrigen Werte von Zeile zu Zeile um etwa {} {} schwanken"},
    {"{} jumps from {} to {} {} at row {} ({}) and stays there: check the sensor; valid = [LOW, HIGH] of its column in "
     "the map excludes values",
     "{} springt von {} auf {} {} in Zeile {} ({}) und bleibt dort: den Sensor prüfen; valid = [LOW, HIGH] seiner "
     "Spalte in der Zuordnung schließt Werte aus"},
    {"values of the file: {l}", "Werte der Datei: {l}"},
    {"1 gap longer than {} s, {} s in all; the first, of {} s, after row {}",
     "1 Lücke länger als {} s, insgesamt {} s; die erste, von {} s, nach Zeile {}"},
    {"{} gaps longer than {} s, {} s in all; the first, of {} s, after row {}",
     "{} Lücken länger als {} s, insgesamt {} s; die erste, von {} s, nach Zeile {}"},
    {"all {} values of {} are {} {}", "alle {} Werte von {} sind {} {}"},
    {"{} of the {} values of column {} differ by {} {} or more from all others, the furthest at {}",
     "{} der {} Werte der Spalte {} unterscheiden sich um {} {} oder mehr von allen anderen, der entfernteste bei {}"},
    {"column {} has no value for {}", "Spalte {} hat keinen Wert für {}"},
    {"1 row was left out because its time was not after the previous row's",
     "1 Zeile entfiel, weil ihre Zeit nicht nach der der vorigen lag"},
    {"{} rows were left out because their time was not after the previous row's",
     "{} Zeilen entfielen, weil ihre Zeit nicht nach der der vorigen lag"},
    {"the clock was set back {} time, at first by {} s: rows continue after the row before",
     "die Uhr wurde {}-mal zurückgestellt, zuerst um {} s: die Zeilen folgen auf die vorige"},
    {"the clock was set back {} times, at first by {} s: rows continue after the row before",
     "die Uhr wurde {}-mal zurückgestellt, zuerst um {} s: die Zeilen folgen auf die vorige"},
    {"the rows are {} s apart: is the unit in [time] right?",
     "die Zeilen haben {} s Abstand: stimmt die Einheit in [time]?"},
    {"{} rows per second: is the unit in [time] right?", "{} Zeilen pro Sekunde: stimmt die Einheit in [time]?"},
    {"the first row is dated {}, in the future", "die erste Zeile ist auf {} datiert, in der Zukunft"},
    {"the last line, {}, has no line end: its last value may be cut off",
     "die letzte Zeile, {}, hat kein Zeilenende: ihr letzter Wert kann abgeschnitten sein"},
    {"the last line, {}, was left out: it has no line end, and its last number has fewer decimals than all before",
     "die letzte Zeile, {}, entfiel: sie hat kein Zeilenende, und ihre letzte Zahl hat weniger Dezimalstellen als alle "
     "davor"},
    // Values of one channel
    {"and {} more channels", "und {} weitere Kanäle"},
    {"{t}, {n} of them outside the valid range", "{t}, davon {n} außerhalb des gültigen Bereichs"},
    {"{t}, {n} missing ({})", "{t}, {n} fehlen ({})"},
    {"{t}, {n} missing", "{t}, {n} fehlen"},
    {"{c}: {n} values, {n} to {n} {n}", "{c}: {n} Werte, {n} bis {n} {n}"},
    {"{c}: 1 value, {n} to {n} {n}", "{c}: 1 Wert, {n} bis {n} {n}"},
    {"{c}: {n} values", "{c}: {n} Werte"},
};
constexpr StoredPhrase kNotes[] = {
    {"takes the chamber over from {}", "übernimmt die Kammer von {}"},
    {"the profile asks: {}; done by the virtual rig",
     "Aufforderung des Profils: {}; vom virtuellen Prüfstand erledigt"},
    {"the profile asks: {}", "Aufforderung des Profils: {}"},
    {"calibration of {} (certificate {}) was due {}", "Kalibrierung von {} (Kalibrierschein {}) war am {} fällig"},
    {"calibration of {} was due {}", "Kalibrierung von {} war am {} fällig"},
    {"position {} is empty", "Platz {} ist leer"},
    {"supply {} is on: output {} {} V, {} A", "Netzgerät {} ist ein: Ausgang {} {} V, {} A"},
    {"supply {} is off: output {} {} V, {} A", "Netzgerät {} ist aus: Ausgang {} {} V, {} A"},
    {"the set point ramps from the air temperature, {} °C, to the profile",
     "der Sollwert fährt von der Lufttemperatur, {} °C, zum Profil"},
    {"soak of segment {} incomplete at its deadline: {} of {} inside ±{} K of {} °C on {}",
     "Durchwärmung des Abschnitts {} bei Fristende unvollständig: {} von {} innerhalb ±{} K um {} °C an {}"},
    {"soak of segment {} ended: {} inside ±{} K of {} °C on {}, in {}",
     "Durchwärmung des Abschnitts {} beendet: {} innerhalb ±{} K um {} °C an {}, nach {}"},
    {"the profile's last second continues until the air has been observed for {}",
     "die letzte Sekunde des Profils dauert an, bis die Luft {} lang beobachtet ist"},
    {"the hold continues until the next block has been chosen",
     "die Haltephase dauert an, bis der nächste Block gewählt ist"},
    {"the controller carries out the profile: {}", "der Regler führt das Profil aus: {}"},
    {"the terminal was closed; the run and its guard continue",
     "das Terminal wurde geschlossen; der Prüflauf und seine Wache laufen weiter"},
    {"decision {}: continue with \"{}\"; U {} now, {} expected, {} °/h wanted; {} h used, {} h left{}",
     "Entscheidung {}: weiter mit \"{}\"; U jetzt {}, {} erwartet, {} °/h gewünscht; {} h verbraucht, {} h übrig{}"},
    {"decision {}: end, U is met; U {} now, {} °/h wanted; {} h used, {} h left{}",
     "Entscheidung {}: Ende, U ist erreicht; U jetzt {}, {} °/h gewünscht; {} h verbraucht, {} h übrig{}"},
    {"decision {}: end, U cannot be met; U {} now, {} °/h wanted; {} h used, {} h left{}",
     "Entscheidung {}: Ende, U ist nicht erreichbar; U jetzt {}, {} °/h gewünscht; {} h verbraucht, {} h übrig{}"},
    {"decision {}: end, the time is up; U {} now, {} °/h wanted; {} h used, {} h left{}",
     "Entscheidung {}: Ende, die Zeit ist abgelaufen; U jetzt {}, {} °/h gewünscht; {} h verbraucht, {} h übrig{}"},
};
constexpr StoredPhrase kDropped[] = {{"{} dropped by {}", "{} herausgenommen von {}"}};
constexpr StoredPhrase kReturned[] = {{"{} returned by {}", "{} wieder aufgenommen von {}"}};

/// Writes the decimal point of a number, alone or before " °/h", as a comma.
std::string localise_number(std::string text) {
  constexpr std::string_view kRate = " °/h";
  std::string_view number = text;
  if (number.ends_with(kRate)) number.remove_suffix(kRate.size());
  const auto is_part = [](char c) { return std::isdigit(static_cast<unsigned char>(c)) != 0 || c == '.' || c == '-'; };
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

/// Translates texts by the phrases of a table.
class Translator {
 public:
  explicit Translator(std::span<const StoredPhrase> phrases) : phrases_(phrases) {}

  /// Returns the text in German by the first phrase that matches; nothing if none matches.
  [[nodiscard]] std::optional<std::string> translate(std::string_view text) const {
    for (const StoredPhrase& phrase : phrases_) {
      const ParsedPhrase english = parse_phrase(phrase.english);
      if (!text.starts_with(english.fixed.front())) continue;
      const auto variables = match(text.substr(english.fixed.front().size()), english, 0);
      if (!variables) continue;
      const auto german = parse_phrase(phrase.german).fixed;
      std::string translated(german.front());
      for (std::size_t i = 0; i < variables->size(); ++i) translated += (*variables)[i] + std::string(german[i + 1]);
      return translated;
    }
    return std::nullopt;
  }

 private:
  using Variables = std::vector<std::string>;

  /// Returns the translated variable parts from the number `index` on, which fill the text with the fixed parts that
  /// follow them; nothing if the text has another form. A part that must be a text of the table is as long as possible,
  /// other parts are as short as possible.
  [[nodiscard]] std::optional<Variables> match(std::string_view text, const ParsedPhrase& phrase,
                                               std::size_t index) const {
    if (index == phrase.kinds.size()) return text.empty() ? std::optional(Variables()) : std::nullopt;
    const std::string_view next = phrase.fixed[index + 1];
    const bool is_last = index + 1 == phrase.kinds.size(), is_long = phrase.kinds[index] == 't';
    if (is_last) return text.ends_with(next) ? end_with(text, phrase, index, text.size() - next.size()) : std::nullopt;
    const auto find = [&](std::size_t from) { return is_long ? text.rfind(next, from) : text.find(next, from); };
    for (auto at = find(is_long ? std::string_view::npos : 0); at != std::string_view::npos;
         at = is_long && at == 0 ? std::string_view::npos : find(is_long ? at - 1 : at + 1))
      if (auto found = end_with(text, phrase, index, at)) return found;
    return std::nullopt;
  }

  /// Returns the variable parts if the one of the number `index` is the first `length` bytes of the text.
  [[nodiscard]] std::optional<Variables> end_with(std::string_view text, const ParsedPhrase& phrase, std::size_t index,
                                                  std::size_t length) const {
    auto rest = match(text.substr(length + phrase.fixed[index + 1].size()), phrase, index + 1);
    auto own = rest ? translate_variable(text.substr(0, length), phrase.kinds[index]) : std::nullopt;
    if (!own) return std::nullopt;
    rest->insert(rest->begin(), std::move(*own));
    return rest;
  }

  [[nodiscard]] std::optional<std::string> translate_variable(std::string_view part, char kind) const {
    if (kind == 't') return translate(part);
    if (kind == 'l') return translate_list(part);
    const auto has = [&](std::string_view separator) { return part.find(separator) != std::string_view::npos; };
    if ((kind == 'c' || kind == 'n') && (has(": ") || has("; "))) return std::nullopt;
    if ((kind == 'n' && has(", ")) || (kind == 'p' && has("; the chamber "))) return std::nullopt;
    return localise_number(std::string(part));
  }

  [[nodiscard]] std::optional<std::string> translate_list(std::string_view list) const {
    constexpr std::string_view kSeparator = "; ";
    std::string translated;
    while (true) {
      const auto end = std::min(list.find(kSeparator), list.size());
      const auto one = translate(list.substr(0, end));
      if (!one) return std::nullopt;
      translated += *one;
      if (end == list.size()) return translated;
      translated += kSeparator;
      list.remove_prefix(end + kSeparator.size());
    }
  }

  std::span<const StoredPhrase> phrases_;
};

/// Returns the table of the texts of a kind of deviation.
std::span<const StoredPhrase> find_table(std::string_view kind) {
  if (kind == "dropped") return kDropped;
  if (kind == "returned") return kReturned;
  if (kind == "gap") return kGaps;
  if (kind == "fault") return kFaults;
  if (kind == "stated") return {};
  return kStates;
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
  if (kind != "note") return Translator(find_table(kind)).translate(stored).value_or(stored);
  const auto translated = Translator(kNotes).translate(stored);
  return translated ? *translated : Translator(kImportNotes).translate(stored).value_or(stored);
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
