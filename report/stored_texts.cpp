// SPDX-License-Identifier: Apache-2.0
#include "report/stored_texts.hpp"

#include <algorithm>
#include <optional>
#include <string_view>

namespace gyrotherm::report {
namespace {

struct StoredPhrase {
  std::string_view english, german;
};

constexpr StoredPhrase kMissingItems[] = {
    {"records: certificate of a thermometer", "Aufzeichnungen: Kalibrierschein eines Thermometers"},
    {"; without one in the rig file, equipment with role ",
     "; ohne Kalibrierschein in der Messplatzdatei: Messeinrichtung mit der Rolle "},
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
    {"records: a record that the model was not trained on",
     "Aufzeichnungen: eine Aufzeichnung, mit der das Modell nicht trainiert wurde"},
    {"models: one trained on this unit", "Modelle: eines, das mit diesem Prüfling trainiert wurde"},
};

/// Returns the text with the phrase in German; unchanged if it does not contain the phrase.
std::string replace_phrase(std::string text, const StoredPhrase& phrase) {
  if (const auto at = text.rfind(phrase.english); at != std::string::npos)
    text.replace(at, phrase.english.size(), phrase.german);
  return text;
}

bool is_input_number(std::string_view text) {
  return !text.empty() && std::ranges::all_of(text, [](char c) { return c >= '0' && c <= '9'; });
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
  if (!input || !is_input_number(*input)) return stored;
  if (const auto module = take_number(text, ", module ")) end = ", Modul " + *module;
  end += ", Eingang " + *input;
  const auto line = text.rfind(" at ");
  if (line == std::string::npos) return text + end;
  auto address = text.substr(line + 4);
  if (address == "virtual") address = "virtueller Leitung";
  auto name = text.substr(0, line);
  if (const auto number = take_number(name, ", thermometer ")) name += ", Thermometer " + *number;
  return name + " an " + address + end;
}

std::string translate_thermometer(plot::Language language, const std::string& stored) {
  return language == plot::Language::german && stored == "self" ? "eigene" : stored;
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
