// SPDX-License-Identifier: Apache-2.0
#include "report/standard/check_words.hpp"

#include <algorithm>
#include <cassert>
#include <iterator>

namespace gyrotherm::standard {
namespace {

struct CheckTranslation {
  std::string_view key, en, de;
};

// clang-format off
constexpr CheckTranslation kCheckTranslations[] = {
  {"mark", "SIMULATED", "SIMULIERT"},
  {"title", "Check standard", "Prüfnormal"},
  {"charts_of", "Control charts of the check standard {}", "Regelkarten des Prüfnormals {}"},
  {"page_of", "page {} of {}", "Seite {} von {}"},
  {"end", "End of the control charts", "Ende der Regelkarten"},
  {"compared.open", "A record was made while the check standard of the rig was out of control, and no cause is "
                    "recorded. A change of the unit may be a change of the rig.",
   "Eine Aufzeichnung entstand, während das Prüfnormal des Prüfstands nicht beherrscht war, und keine Ursache ist "
   "festgehalten. Eine Änderung des Gegenstands kann eine Änderung des Prüfstands sein."},
  {"compared.table", "Check standard at the time of each record", "Prüfnormal zur Zeit jeder Aufzeichnung"},
  {"compared.state", "Check standard", "Prüfnormal"},
  {"compared.before", "Last check run before", "Letzter Prüflauf davor"},
  {"compared.after", "First check run after", "Erster Prüflauf danach"},
  {"state.unknown", "not judged", "nicht beurteilt"},
  {"state.in_control", "in control", "beherrscht"},
  {"state.explained", "out of control, explained", "nicht beherrscht, erklärt"},
  {"state.out_of_control", "out of control, not explained", "nicht beherrscht, nicht erklärt"},
  {"heading.standing", "Present state", "Stand"},
  {"heading.charts", "Control charts", "Regelkarten"},
  {"heading.cause", "Probable cause", "Wahrscheinliche Ursache"},
  {"heading.runs", "Check runs", "Prüfläufe"},
  {"heading.explanations", "Explanations", "Erklärungen"},
  {"simulated", "The check runs are of a virtual rig. They say nothing about a real instrument.",
   "Die Prüfläufe stammen von einem virtuellen Prüfstand. Sie sagen nichts über ein wirkliches Gerät aus."},
  {"in_control", "In control: the last check run is within all limits, and no run is unexplained.",
   "Beherrscht: der letzte Prüflauf liegt in allen Grenzen, und kein Lauf ist unerklärt."},
  {"learning", "Too few runs: limits exist from the fifth run on.",
   "Zu wenige Läufe: Grenzen gibt es ab dem fünften Lauf."},
  {"open", "Out of control and not explained: {} of {} runs. Reports of later runs remain drafts.",
   "Nicht beherrscht und nicht erklärt: {} von {} Läufen. Berichte späterer Läufe bleiben Entwürfe."},
  {"rate", "False alarms in control: at most {} per check run, over all {} results together. Limits in standard "
           "deviations: ±{} (individual values) and ±{} (EWMA, λ = {}); thermometers ±{} and ±{}.",
   "Fehlalarme im beherrschten Zustand: höchstens {} je Prüflauf, über alle {} Ergebnisse zusammen. Grenzen in "
   "Standardabweichungen: ±{} (Einzelwerte) und ±{} (EWMA, λ = {}); Thermometer ±{} und ±{}."},
  {"rig", "Rig", "Prüfstand"},
  {"serials", "Golden gyro", "Prüfnormal"},
  {"profile", "Profile", "Profil"},
  {"runs", "Check runs", "Prüfläufe"},
  {"last", "Last run", "Letzter Lauf"},
  {"rate_label", "False-alarm rate", "Fehlalarmrate"},
  {"run", "run", "Lauf"},
  {"day", "Day", "Tag"},
  {"record", "Record", "Aufzeichnung"},
  {"verdict", "Verdict", "Urteil"},
  {"out_in", "Out of control in", "Nicht beherrscht in"},
  {"verdict.in", "in control", "beherrscht"},
  {"verdict.learning", "not judged", "nicht beurteilt"},
  {"verdict.out", "out of control", "nicht beherrscht"},
  {"verdict.explained", "explained", "erklärt"},
  {"cause", "Reason", "Ursache"},
  {"by", "By", "Von"},
  {"note", "Note", "Anmerkung"},
  {"new_level", "later runs have a new level", "spätere Läufe haben ein neues Niveau"},
  {"runs_table", "All check runs", "Alle Prüfläufe"},
  {"explanations_table", "Explanations of runs out of control", "Erklärungen nicht beherrschter Läufe"},
  {"hypotheses_table", "Possible causes of the change", "Mögliche Ursachen der Änderung"},
  {"probability", "Probability", "Wahrscheinlichkeit"},
  {"amount", "Amount ± u (k\u00a0=\u00a01)", "Betrag ± u (k\u00a0=\u00a01)"},
  {"fit", "P(χ²)", "P(χ²)"},
  {"named", "Probable cause: {}. The change began with run {} ({}); {} runs before it and {} since are compared.",
   "Wahrscheinliche Ursache: {}. Die Änderung begann mit Lauf {} ({}); verglichen sind {} Läufe davor und {} seither."},
  {"not_named", "The cause cannot be told: {}. The change began with run {} ({}); {} runs before it and {} since are "
                "compared. Repeat the check run.",
   "Die Ursache ist nicht zu erkennen: {}. Die Änderung begann mit Lauf {} ({}); verglichen sind {} Läufe davor und "
   "{} seither. Wiederholen Sie den Prüflauf."},
  {"equal", "One axis in one position: a tilt of the mount and a constant drift of the gyro change the results in the "
            "same way. Only their plausible sizes tell them apart. A check run in two positions "
            "(check-standard-turned) separates them.",
   "Eine Achse in einer Lage: eine Neigung der Aufnahme und eine konstante Drift des Kreisels ändern die Ergebnisse "
   "gleich. Nur ihre plausiblen Größen unterscheiden sie. Ein Prüflauf in zwei Lagen (check-standard-turned) trennt "
   "sie."},
  {"cause.thermometer", "thermometer", "Thermometer"},
  {"cause.mount", "mount", "Aufnahme"},
  {"cause.gyro", "golden gyro", "Prüfnormal (Kreisel)"},
  {"cause.false_alarm", "false alarm", "Fehlalarm"},
  {"cause.other", "other", "andere"},
  {"part.constant", "constant", "konstant"},
  {"part.with temperature", "with temperature", "mit der Temperatur"},
  {"part.scatter", "scatter", "Streuung"},
  {"kind.bias", "bias", "Nullpunktabweichung"},
  {"kind.temperature_coefficient", "temperature coefficient", "Temperaturkoeffizient"},
  {"kind.scatter", "scatter", "Streuung"},
  {"kind.earth_rate", "Earth rate", "Erddrehrate"},
  {"kind.thermometer", "difference from the other thermometers", "Abweichung von den anderen Thermometern"},
  {"short.temperature_coefficient", "temp. coefficient", "Temp.-Koeffizient"},
  {"short.scatter", "scatter", "Streuung"},
  {"short.earth_rate", "Earth rate", "Erddrehrate"},
  {"thermometers_at", "{}: thermometers, {}", "{}: Thermometer, {}"},
  {"ewma", "{}: EWMA", "{}: EWMA"},
  {"ewma_thermometers", "{}: EWMA, thermometers", "{}: EWMA, Thermometer"},
  {"of_limit", "EWMA / limit", "EWMA / Grenze"},
  {"standardised", "deviation / σ", "Abweichung / σ"},
  {"value", "value", "Wert"},
  {"mean", "mean of the previous runs", "Mittel der vorigen Läufe"},
  {"limit", "limit", "Grenze"},
  {"out", "out of control", "nicht beherrscht"},
  {"caption",
   "Control charts. Each value is compared with the previous runs. The limits allow for their estimation from few "
   "runs, so they usually narrow with further runs.",
   "Regelkarten. Jeder Wert wird mit den vorigen Läufen verglichen. Die Grenzen enthalten den Fehler von Grenzen aus "
   "wenigen Läufen und werden daher mit weiteren Läufen meist enger."},
  {"caption_more", "Control charts, continued ({} of {}).", "Regelkarten, Fortsetzung ({} von {})."},
};
// clang-format on

}  // namespace

std::string_view check_word(plot::Language language, std::string_view key) {
  const auto* const found = std::ranges::find(kCheckTranslations, key, &CheckTranslation::key);
  assert(found != std::end(kCheckTranslations));
  return language == plot::Language::german ? found->de : found->en;
}

}  // namespace gyrotherm::standard
