// SPDX-License-Identifier: Apache-2.0
#include "apps/gyrotherm/german_evidence.hpp"

#include <string_view>

namespace gyrotherm::app {
namespace {

struct Phrase {
  std::string_view english, german;
};

/// A phrase precedes those that it contains.
constexpr Phrase kPhrases[] = {
    // installation
    {"shipped files: ", "mitgelieferte Dateien: "},
    {"none found in ", "keine gefunden in "},
    {" cannot be started: ", " kann nicht gestartet werden: "},
    {"if a run dies, the chamber is not made safe; runs on a real rig therefore do not start",
     "stirbt ein Lauf, wird die Kammer nicht gesichert; Läufe an einem echten Prüfstand beginnen deshalb nicht"},
    {"reports have no PDF", "Berichte haben kein PDF"},
    // disk
    {"folder: ", "Ordner: "},
    {" is not a folder", " ist kein Ordner"},
    {" is on a disk that is mounted read-only", " liegt auf einem nur lesbaren Datenträger"},
    {" is not writable by ", " ist nicht beschreibbar für "},
    {" is writable", " ist beschreibbar"},
    {"file system: ", "Dateisystem: "},
    {"file system ", "Dateisystem "},
    {", blocks of ", ", Blöcke zu "},
    {": it is in memory, and a power cut erases its records",
     ": es liegt im Arbeitsspeicher, ein Stromausfall löscht seine Aufzeichnungen"},
    {": it may be on another machine, and this machine cannot guarantee its locks and syncs",
     ": es liegt vielleicht auf einem anderen Rechner, der Sperren und Sichern nicht gewährleistet"},
    {": it has no journal, and a power cut may destroy all files on it",
     ": es hat kein Journal, ein Stromausfall kann alle seine Dateien zerstören"},
    {" GB free", " GB frei"},
    {" inodes", " Inodes"},
    {"disk: ", "Datenträger: "},
    // clock
    {"synchronised with UTC to within ", "mit UTC synchronisiert bis auf "},
    {"the clock is not synchronised: UTC times in records may be wrong, but durations are correct",
     "die Uhr ist nicht synchronisiert: UTC-Zeiten der Aufzeichnungen können falsch sein, Zeitdauern stimmen"},
    {"is not synchronised: UTC times in records may be wrong, but durations are correct",
     "nicht synchronisiert: UTC-Zeiten der Aufzeichnungen können falsch sein, Zeitdauern stimmen"},
    // limits
    {"open files: ", "offene Dateien: "},
    {"file size: ", "Dateigröße: "},
    {"processor time: ", "Rechenzeit: "},
    {"locked memory: ", "gesperrter Speicher: "},
    {"memory: ", "Speicher: "},
    {"priority: ", "Priorität: "},
    {"a record would end at this size", "eine Aufzeichnung würde bei dieser Größe enden"},
    {"a run would be killed after this time", "ein Lauf würde nach dieser Zeit beendet"},
    {"rows are buffered in memory while a disk hangs",
     "während ein Datenträger hängt, werden Zeilen im Speicher gehalten"},
    {"at most ", "höchstens "},
    {"no limit", "keine Grenze"},
    {", of which none is needed", ", nichts davon wird gebraucht"},
    {", no real-time priority is needed", ", keine Echtzeitpriorität nötig"},
    {", idle class", ", Klasse idle"},
    {", as a batch job", ", als Stapelauftrag"},
    {": on a busy machine a second may be delayed",
     ": auf einem ausgelasteten Rechner kann sich eine Sekunde verzögern"},
    {" files", " Dateien"},
    {" bytes", " Byte"},
    // proof tests of the limiter
    {"setting of the limiter", "Einstellung des Begrenzers"},
    {"safe set point and mode after the program was killed",
     "sicherer Sollwert und Betriebsart nach dem Abbruch des Programms"},
    {"safe set point and mode after the line returned",
     "sicherer Sollwert und Betriebsart nach der Rückkehr der Leitung"},
    {"safe set point read back", "sicherer Sollwert zurückgelesen"},
    {"set point sent", "Sollwert gesendet"},
    {"trip, seen by the alarm", "Auslösung, erkannt am Alarm"},
    {"trip, seen by air that falls below the set point", "Auslösung, erkannt an Luft, die unter den Sollwert fällt"},
    {"still tripped; lowest air", "noch ausgelöst; tiefste Luft"},
    {"limiter reset; air", "Begrenzer zurückgesetzt; Luft"},
    {"reset without a person", "Rücksetzung ohne Person"},
    {"heating ends at", "Heizen endet bei"},
    {"stays tripped for", "bleibt ausgelöst während"},
    {"the limiter did not trip: it was set to ", "der Begrenzer löste nicht aus: er war eingestellt auf "},
    {" and the air reached ", " und die Luft erreichte "},
    {"the limiter tripped late: at ", "der Begrenzer löste spät aus: bei "},
    {"the limiter tripped early: at ", "der Begrenzer löste früh aus: bei "},
    {" above its setting", " über seiner Einstellung"},
    {" below its setting", " unter seiner Einstellung"},
    {"the air did not reach the limiter's setting of ", "die Luft erreichte nicht die Einstellung des Begrenzers von "},
    {"the air did not exceed the limiter's setting of ",
     "die Luft überschritt nicht die Einstellung des Begrenzers von "},
    {" °C by ", " °C um "},
    {"the chamber did not take the set point: ", "die Kammer nahm den Sollwert nicht an: "},
    {"the chamber did not answer while it heated", "die Kammer antwortete während des Heizens nicht"},
    {"the chamber did not answer after the trip", "die Kammer antwortete nach der Auslösung nicht"},
    {"the chamber did not answer after the reset", "die Kammer antwortete nach der Rücksetzung nicht"},
    {"the limiter reset itself ", "der Begrenzer setzte sich selbst zurück, "},
    {" after the trip: ", " nach der Auslösung: "},
    {"the air rises again", "die Luft steigt wieder"},
    {"the alarm has gone", "der Alarm ist verschwunden"},
    {"the operator stopped the test", "die prüfende Person beendete die Prüfung"},
    {"the operator did not confirm that the limiter was set back and reset",
     "die prüfende Person bestätigte nicht, dass der Begrenzer zurückgestellt und zurückgesetzt ist"},
    {"the operator did not set the limiter", "die prüfende Person stellte den Begrenzer nicht ein"},
    {"the chamber does not show its safe set point", "die Kammer zeigt ihren sicheren Sollwert nicht"},
    {"the alarm remains after the operator reset the limiter", "der Alarm bleibt nach der Rücksetzung des Begrenzers"},
    // proof tests of the safe state, the line and the relay
    {"relay open after the guard began to act", "Relais offen nach Beginn des Eingriffs der Wache"},
    {"relay opened by the guard after", "Relais von der Wache geöffnet nach"},
    {"each position is read back within", "jede Stellung wird zurückgelesen innerhalb von"},
    {"air observed by the guard", "Luft, von der Wache beobachtet"},
    {"confirmed by the guard after", "von der Wache bestätigt nach"},
    {"program drives the chamber to", "Programm fährt die Kammer auf"},
    {"guard reports", "Meldung der Wache"},
    {"NOT yet made safe", "noch NICHT gesichert"},
    {"safe after the line returned", "sicher nach der Rückkehr der Leitung"},
    {"safe after", "sicher nach"},
    {"line and program", "Leitung und Programm"},
    {"line cut, program killed", "Leitung getrennt, Programm abgebrochen"},
    {"opened, reads open", "geöffnet, meldet offen"},
    {"closed, reads closed", "geschlossen, meldet geschlossen"},
    {"closed again", "wieder geschlossen"},
    {"it left no trace", "sie hinterließ keine Spur"},
    {"the guard left no trace: it did not act", "die Wache hinterließ keine Spur: sie griff nicht ein"},
    {"the guard did not confirm that the chamber is safe: ",
     "die Wache bestätigte nicht, dass die Kammer sicher ist: "},
    {"the guard did not open the relay: ", "die Wache öffnete das Relais nicht: "},
    {"it reads closed", "es meldet geschlossen"},
    {"the guard confirmed a chamber that it could not reach",
     "die Wache bestätigte eine Kammer, die sie nicht erreichte"},
    {"the relay could not be closed again: ", "das Relais ließ sich nicht wieder schließen: "},
    {"the chamber was not safe after the relay closed: ",
     "die Kammer war nach dem Schließen des Relais nicht sicher: "},
    {"the chamber was not safe ", "die Kammer war nicht sicher "},
    {" after the line returned", " nach der Rückkehr der Leitung"},
    {"the relay is open already", "das Relais ist schon offen"},
    {"the relay cannot be read: ", "das Relais lässt sich nicht lesen: "},
    {"the chamber does not show its set point and its mode: ", "die Kammer zeigt Sollwert und Betriebsart nicht: "},
    {"the chamber does not show its set point: ", "die Kammer zeigt ihren Sollwert nicht: "},
    {"it is left at the safe set point of ", "sie bleibt auf dem sicheren Sollwert von "},
    {"the chamber's limits of ", "die Grenzen der Kammer von "},
    {" leave no set point that differs visibly from the safe one of ",
     " lassen keinen Sollwert mit sichtbarem Abstand zu vom sicheren Sollwert "},
    {" K is needed", " K sind nötig"},
    {" before it drove the chamber", ", bevor es die Kammer fuhr"},
    {"did not drive the chamber in ", "fuhr die Kammer nicht in "},
    {"ended with exit code ", "endete mit Exitcode "},
    {"was ended by signal ", "wurde beendet durch Signal "},
    // state of a chamber: "set point 20 °C, air 19.99 °C, running"
    {" °C, air ", " °C, Luft "},
    {"set point unreadable, air ", "Sollwert nicht lesbar, Luft "},
    {" °C, running", " °C, läuft"},
    {" °C, off", " °C, aus"},
    {" °C, not following its set point", " °C, folgt ihrem Sollwert nicht"},
    {" °C, program", " °C, Programm"},
    {" °C, ramping", " °C, in der Rampe"},
    {" °C, soaking", " °C, beim Durchwärmen"},
    {" °C, waiting", " °C, wartet"},
    {" °C, holding", " °C, hält"},
    {" °C, done", " °C, fertig"},
    {" °C, alarm", " °C, Alarm"},
    {" °C, door open", " °C, Tür offen"},
    {" °C, emergency stop", " °C, Not-Halt"},
    {" °C, power failure", " °C, Netzausfall"},
    {" °C, unknown", " °C, unbekannt"},
    {"set point ", "Sollwert "},
    // proof tests of clock and disk
    {"synchronised with UTC, as the kernel reports", "mit UTC synchronisiert, nach Auskunft des Systemkerns"},
    {"free space and file system", "freier Platz und Dateisystem"},
    {"suitable for records", "geeignet für Aufzeichnungen"},
    {"longest of 20 syncs", "längstes von 20 Sicherungen"},
    {"longest sync", "längste Sicherung"},
    // interlocks
    {"each interlock acts on injected values", "jede Verriegelung wirkt bei eingespeisten Werten"},
    {"with the reaction of the rig file", "mit der Reaktion der Prüfstandsdatei"},
    {"no interlock acts", "keine Verriegelung wirkt"},
    {" without a fault, or inside its limit", " ohne Fehler oder innerhalb ihrer Grenze"},
    {"not tested: ", "nicht geprüft: "},
    {"FAILED: ", "NICHT bestanden: "},
    {"the rig has no power supply", "der Prüfstand hat kein Netzgerät"},
    {"the rig has no room air", "der Prüfstand hat keine Raumluft"},
    {"the rig records no dew point", "der Prüfstand zeichnet keinen Taupunkt auf"},
    {"the rig has fewer than three thermometers", "der Prüfstand hat weniger als drei Thermometer"},
    {"no unit may be silent while others send", "kein Prüfling darf schweigen, während andere senden"},
    {"the analysis needs no thermometer", "die Auswertung braucht kein Thermometer"},
    {"the band exceeds the distance of the safe set point from the limits of the chamber",
     "das Band ist größer als der Abstand des sicheren Sollwerts von den Grenzen der Kammer"},
    {"it acts only after ", "sie wirkt erst nach "},
    {", longer than its test", ", länger als ihre Prüfung"},
    {"acts on readings without a fault", "wirkt bei Messwerten ohne Fehler"},
    {" on values inside its limit", " bei Werten innerhalb der Grenze"},
    {"does not act on injected values", "wirkt nicht bei eingespeisten Werten"},
    {"acts after ", "wirkt nach "},
    {", before its ", ", vor den eingestellten "},
    {"reacts by ", "reagiert mit "},
    {", expected ", ", erwartet "},
    // proof tests
    {": the chamber was not left as found: ", ": die Kammer wurde nicht wie vorgefunden hinterlassen: "},
    {": the protocol cannot be read, restore it or move its folder away: ",
     ": das Protokoll ist nicht lesbar, es ist wiederherzustellen oder sein Ordner zu entfernen: "},
    {": the rig file has changed since these proof tests",
     ": die Prüfstandsdatei wurde seit diesen Prüfungen geändert"},
    {": a rehearsal on a virtual chamber; it does not count",
     ": eine Übung an einer virtuellen Kammer; sie zählt nicht"},
    {"proof test ", "Prüfung "},
    {": due since ", ": fällig seit "},
    {" (passed on ", " (bestanden am "},
    {": its date is in the future: ", ": ihr Datum liegt in der Zukunft: "},
    {": its date cannot be read: ", ": ihr Datum ist nicht lesbar: "},
    {": the protocol is UNSIGNED", ": das Protokoll ist NICHT SIGNIERT"},
};

/// Texts that are translated only as a whole, or as the beginning of "hold after 2 s".
constexpr Phrase kWholeTexts[] = {
    {"go_on", "weiter"},       {"warn", "warnen"},      {"suspend", "anhalten"},
    {"hold", "halten"},        {"abort", "abbrechen"},  {"set point", "Sollwert"},
    {"trip", "Auslösung"},     {"air", "Luft"},         {"program", "Programm"},
    {"killed", "abgebrochen"}, {"relay", "Relais"},     {"chamber", "Kammer"},
    {"clock", "Uhr"},          {"disk", "Datenträger"}, {"file system", "Dateisystem"},
    {"folder", "Ordner"},
};

/// Replaces a decimal point by a comma in a number that is followed by a unit.
void localise_decimals(std::string& text) {
  const auto is_digit = [&](std::size_t at) { return at < text.size() && text[at] >= '0' && text[at] <= '9'; };
  for (std::size_t i = 1; i + 1 < text.size(); ++i) {
    if (text[i] != '.' || !is_digit(i - 1) || !is_digit(i + 1)) continue;
    std::size_t end = i + 1;
    while (is_digit(end)) ++end;
    const auto unit = std::string_view(text).substr(end);
    for (const std::string_view known : {" s", " ms", " min", " h", " K", " °C", " GB", " %"})
      if (unit.starts_with(known)) text[i] = ',';
  }
}

}  // namespace

std::string translate_evidence(std::string english) {
  constexpr std::string_view kAfter = " after ";
  for (const auto& [text, german] : kWholeTexts) {
    if (english == text) return std::string(german);
    if (english.starts_with(text) && std::string_view(english).substr(text.size()).starts_with(kAfter))
      english.replace(0, text.size() + kAfter.size(), std::string(german) + " nach ");
  }
  for (const auto& [phrase, german] : kPhrases)
    for (auto at = english.find(phrase); at != std::string::npos; at = english.find(phrase, at + german.size()))
      english.replace(at, phrase.size(), german);
  localise_decimals(english);
  return english;
}

}  // namespace gyrotherm::app
