// SPDX-License-Identifier: Apache-2.0
#include "report/stored_texts.hpp"

#include <algorithm>
#include <cctype>
#include <optional>
#include <span>
#include <string_view>
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

/// Fixed texts of the program with a {} for each variable part. The first one that matches is used.
constexpr StoredPhrase kStates[] = {
    {"held: {}", "gehalten: {}"},
    {"suspended: {}", "angehalten: {}"},
    {"aborting: {}", "Abbruch: {}"},
    {"aborted: {}", "abgebrochen: {}"},
    {"stopped: {}", "beendet: {}"},
    {"execute: the profile continues, after: {}", "das Profil wird fortgesetzt nach: {}"},
    {"execute: the profile goes on, after: {}", "das Profil wird fortgesetzt nach: {}"},
    {"on the way back to the profile after: {}", "auf dem Rückweg zum Profil nach: {}"},
    {"the air is not at the first set point of the profile", "die Luft ist nicht beim ersten Sollwert des Profils"},
    {"paused by {}", "angehalten von {}"},
    {"stopped by a signal", "beendet durch ein Signal"},
    {"stopped by {}", "beendet von {}"},
    {"aborted by {}", "abgebrochen von {}"},
    {"held for {}", "gehalten während {}"},
    {"suspended for {}", "angehalten während {}"},
    {"returning for {}", "auf dem Rückweg während {}"},
    {"resumed after {}; cause of the interruption: {}", "fortgesetzt nach {}; Ursache der Unterbrechung: {}"},
};
constexpr StoredPhrase kNotes[] = {
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

constexpr std::string_view kVariable = "{}";

/// Returns the fixed parts of a phrase around its variable parts.
std::vector<std::string_view> fixed_parts(std::string_view phrase) {
  std::vector<std::string_view> parts;
  for (auto at = phrase.find(kVariable); at != std::string_view::npos; at = phrase.find(kVariable)) {
    parts.push_back(phrase.substr(0, at));
    phrase.remove_prefix(at + kVariable.size());
  }
  parts.push_back(phrase);
  return parts;
}

/// Returns the variable parts of a text that has the form of a phrase; nothing if it has another form.
std::optional<std::vector<std::string>> match_phrase(std::string_view text, std::string_view phrase) {
  const auto parts = fixed_parts(phrase);
  if (parts.size() == 1) return text == phrase ? std::optional(std::vector<std::string>()) : std::nullopt;
  if (!text.starts_with(parts.front())) return std::nullopt;
  text.remove_prefix(parts.front().size());
  if (!text.ends_with(parts.back())) return std::nullopt;
  text.remove_suffix(parts.back().size());
  std::vector<std::string> variables;
  for (std::size_t i = 1; i + 1 < parts.size(); ++i) {
    const auto at = text.find(parts[i]);
    if (at == std::string_view::npos) return std::nullopt;
    variables.emplace_back(text.substr(0, at));
    text.remove_prefix(at + parts[i].size());
  }
  variables.emplace_back(text);
  return variables;
}

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

/// Returns the text in German by the first phrase that matches, with its variable parts translated by `translate_part`;
/// nothing if none matches.
std::optional<std::string> translate_by(std::span<const StoredPhrase> phrases, std::string_view text,
                                        std::string (*translate_part)(std::string)) {
  for (const auto& phrase : phrases) {
    const auto variables = match_phrase(text, phrase.english);
    if (!variables) continue;
    const auto parts = fixed_parts(phrase.german);
    std::string translated(parts.front());
    for (std::size_t i = 0; i < variables->size(); ++i)
      translated += translate_part((*variables)[i]) + std::string(parts[i + 1]);
    return translated;
  }
  return std::nullopt;
}

/// Translates the text of a state, whose cause may be another fixed text.
std::string translate_state(std::string text) {
  auto translated = translate_by(kStates, text, &translate_state);
  return translated ? *translated : localise_number(std::move(text));
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
  if (kind == "dropped") return translate_by(kDropped, stored, &localise_number).value_or(stored);
  if (kind == "returned") return translate_by(kReturned, stored, &localise_number).value_or(stored);
  if (kind == "note") return translate_by(kNotes, stored, &localise_number).value_or(stored);
  if (kind == "stated") return stored;
  return translate_by(kStates, stored, &translate_state).value_or(stored);
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
