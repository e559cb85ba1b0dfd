// SPDX-License-Identifier: Apache-2.0
#include "report/event_phrases.hpp"

namespace gyrotherm::report {
namespace {

/// Notes of an import about its file and its channels.
constexpr StoredPhrase kImportNotePhrases[] = {
    {"warning: {t}", "Warnung: {t}"},
    {"{} of {} values of {} are missing ({} %); rows without a rate are not used",
     "{} von {} Werten von {} fehlen ({} %); Zeilen ohne Drehrate werden nicht verwendet"},
    {"{} of {} values of {} are missing ({} %); clusters with a missing temperature are left out, unless the map does "
     "not name the channel",
     "{} von {} Werten von {} fehlen ({} %); Mittelwerte mit einer fehlenden Temperatur entfallen, außer wenn die "
     "Zuordnung den Kanal nicht nennt"},
    {"{} of {} values of {} are missing ({} %); clusters with a missing temperature are left out, unless the map does "
     "not name the channel; if a slower instrument wrote it, combine rows by \"every\"",
     "{} von {} Werten von {} fehlen ({} %); Mittelwerte mit einer fehlenden Temperatur entfallen, außer wenn die "
     "Zuordnung den Kanal nicht nennt; wenn ein langsameres Gerät ihn schrieb, Zeilen mit \"every\" zusammenfassen"},
    {"{} of {} values of {} are missing ({} %); a combined row uses the values that it has",
     "{} von {} Werten von {} fehlen ({} %); eine zusammengefasste Zeile verwendet die Werte, die sie hat"},
    {"{t}; the increments of the last ones are lost", "{t}; die Inkremente der letzten sind verloren"},
    {"{t}; their increments are added to the rows that follow",
     "{t}; ihre Inkremente werden zu den folgenden Zeilen addiert"},
    {"{n} drop-outs of the log, {n} ms in all", "{n} Aussetzer des Logs, insgesamt {n} ms"},
    {"{n} messages of an unknown kind were skipped", "{n} Nachrichten unbekannter Art wurden übersprungen"},
    {"{n} bytes at {n} positions are not messages and were skipped",
     "{n} Bytes an {n} Stellen sind keine Nachrichten und wurden übersprungen"},
    {"the log ends within a message, {n} bytes of it", "das Log endet innerhalb einer Nachricht, {n} Bytes davon"},
    {"{n} bytes outside messages were skipped", "{n} Bytes außerhalb von Nachrichten wurden übersprungen"},
    {"{n} messages are damaged and were left out", "{n} Nachrichten sind beschädigt und entfielen"},
    {"{n} messages were left out because their sensor was not known yet",
     "{n} Nachrichten entfielen, weil ihr Sensor noch nicht bekannt war"},
    {"{t}: the sensor has probably failed; train with --clusters before or after them",
     "{t}: der Sensor ist wahrscheinlich ausgefallen; mit --clusters davor oder danach trainieren"},
    {"{t}: the sensor has probably failed; train with --clusters before or after them, or remove {} from the map",
     "{t}: der Sensor ist wahrscheinlich ausgefallen; mit --clusters davor oder danach trainieren oder {} aus der "
     "Zuordnung entfernen"},
    {"{t}: the sensor has probably failed; valid = [LOW, HIGH] of its column in the map marks them as missing",
     "{t}: der Sensor ist wahrscheinlich ausgefallen; valid = [LOW, HIGH] seiner Spalte in der Zuordnung kennzeichnet "
     "sie als fehlend"},
    {"{t}: the sensor has probably failed; missing = [\"{}\"] in [file], or valid = [LOW, HIGH] of its column, marks "
     "them "
     "as "
     "missing",
     "{t}: der Sensor ist wahrscheinlich ausgefallen; missing = [\"{}\"] in [file] oder valid = [LOW, HIGH] seiner "
     "Spalte "
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
constexpr StoredPhrase kRunNotePhrases[] = {
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
    {"soak of segment {} incomplete at its deadline: {} of {} inside ±{} K of {} °C on {s}",
     "Durchwärmung des Abschnitts {} bei Fristende unvollständig: {} von {} innerhalb ±{} K um {} °C an {}"},
    {"soak of segment {} ended: {} inside ±{} K of {} °C on {s}, in {}",
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
    // Start or resumption
    {"made safe by the guard at {n} ({t}): {e}", "von der Wache in den sicheren Zustand gebracht am {n} ({t}): {e}"},
    {"made safe by {n} at {n} ({t}): {e}", "in den sicheren Zustand gebracht von {n} am {n} ({t}): {e}"},
    {"NOT yet made safe by the guard at {n} ({t}): {e}",
     "von der Wache noch NICHT in den sicheren Zustand gebracht am {n} ({t}): {e}"},
    {"NOT yet made safe by {n} at {n} ({t}): {e}",
     "noch NICHT in den sicheren Zustand gebracht von {n} am {n} ({t}): {e}"},
    {"GIVEN UP by the guard at {n} ({}): {e}", "von der Wache AUFGEGEBEN am {n} ({}): {e}"},
    {"GIVEN UP by {n} at {n} ({}): {e}", "AUFGEGEBEN von {n} am {n} ({}): {e}"},
    {"the program that drove it hung", "das Programm, das sie führte, hing"},
    {"the program that drove it had ended", "das Programm, das sie führte, war beendet"},
    {"the program that drove it ended before the chamber was safe",
     "das Programm, das sie führte, endete, bevor die Kammer im sicheren Zustand war"},
    {"profile {c}: UNRELEASED: is not in the register", "Profil {c}: NICHT FREIGEGEBEN: nicht im Register"},
    {"rig {c}: UNRELEASED: is not in the register", "Prüfstand {c}: NICHT FREIGEGEBEN: nicht im Register"},
    {"chamber map: UNRELEASED: is not in the register",
     "Registerbeschreibung der Kammer: NICHT FREIGEGEBEN: nicht im Register"},
    {"map of analogue input {n}: UNRELEASED: is not in the register",
     "Registerbeschreibung des Analogeingangs {n}: NICHT FREIGEGEBEN: nicht im Register"},
    {"description of thermometer {n}: UNRELEASED: is not in the register",
     "Beschreibung des Thermometers {n}: NICHT FREIGEGEBEN: nicht im Register"},
    {"description of supply {n}: UNRELEASED: is not in the register",
     "Beschreibung des Netzgeräts {n}: NICHT FREIGEGEBEN: nicht im Register"},
    {"WARNING: the chamber shows air of {n} °C, the nearest thermometer {n} °C, as if the chamber showed °F; check the "
     "chamber's unit of temperature, and that the thermometers are in this chamber",
     "WARNUNG: die Kammer zeigt {n} °C Luft, das nächste Thermometer {n} °C, als zeigte die Kammer °F; die "
     "Temperatureinheit der Kammer prüfen, und ob die Thermometer in dieser Kammer sind"},
    {"WARNING: the chamber shows air of {n} °C, the nearest thermometer {n} °C; check the chamber's unit of "
     "temperature, "
     "and that the thermometers are in this chamber",
     "WARNUNG: die Kammer zeigt {n} °C Luft, das nächste Thermometer {n} °C; die Temperatureinheit der Kammer prüfen, "
     "und ob die Thermometer in dieser Kammer sind"},
    {"the run ends by itself: U {} wanted on {n}, at most {n}, {n} released blocks",
     "der Prüflauf endet von selbst: U {} gewünscht auf {n}, höchstens {n}, {n} freigegebene Blöcke"},
    {"chamber: not monitored, because the unit does not provide it: {n} ({e})",
     "Kammer: nicht überwacht, weil das Gerät es nicht liefert: {n} ({e})"},
    {"chamber: not monitored, because the unit does not provide it: {}",
     "Kammer: nicht überwacht, weil das Gerät es nicht liefert: {}"},
    {"accepted: {t}", "angenommen: {t}"},
    {"{t}; {s}: another instrument, or other settings: {c}; the run began with: {c}",
     "{t}; {s}: ein anderes Gerät oder andere Einstellungen: {c}; der Prüflauf begann mit: {c}"},
    {"{s}: another instrument, or other settings: {c}; the run began with: {c}",
     "{s}: ein anderes Gerät oder andere Einstellungen: {c}; der Prüflauf begann mit: {c}"},
    {"pause is not carried out: {e}", "pause wird nicht ausgeführt: {e}"},
    {"resume is not carried out: {e}", "resume wird nicht ausgeführt: {e}"},
    {"stop is not carried out: {e}", "stop wird nicht ausgeführt: {e}"},
    {"abort is not carried out: {e}", "abort wird nicht ausgeführt: {e}"},
    {"the unit is too cold for the air of the room: {s} reads {n} °C; open the door only at {n} °C or more",
     "der Prüfling ist zu kalt für die Raumluft: {s} zeigt {n} °C; die Tür erst ab {n} °C öffnen"},
};

}  // namespace

std::span<const StoredPhrase> list_run_note_phrases() { return kRunNotePhrases; }
std::span<const StoredPhrase> list_import_note_phrases() { return kImportNotePhrases; }

}  // namespace gyrotherm::report
