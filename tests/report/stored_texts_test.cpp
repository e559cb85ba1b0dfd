// SPDX-License-Identifier: Apache-2.0
#include "report/stored_texts.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <fstream>
#include <iterator>
#include <regex>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "report/event_phrases.hpp"

namespace gyrotherm::report {
namespace {

constexpr auto kTranslated = plot::Language::german, kUntranslated = plot::Language::english;

TEST(StoredTexts, TranslateInstrumentsButNotTheirNames) {
  EXPECT_EQ(translate_instrument(kTranslated, "lakeshore_218 1 at virtual, input 1"),
            "lakeshore_218 1 an virtueller Leitung, Eingang 1");
  EXPECT_EQ(translate_instrument(kTranslated, "dcon 2 at serial:/dev/ttyUSB0, module 0A, input 3"),
            "dcon 2 an serial:/dev/ttyUSB0, Modul 0A, Eingang 3");
  EXPECT_EQ(translate_instrument(kTranslated, "Fluke at home, thermometer 12 at tcp://10.0.0.5:502, input 16"),
            "Fluke at home, Thermometer 12 an tcp://10.0.0.5:502, Eingang 16");
  EXPECT_EQ(translate_instrument(kTranslated, "imported from flat at 20, input 2.csv"),
            "importiert aus flat at 20, input 2.csv");
  EXPECT_EQ(translate_instrument(kTranslated, "virtual chamber at virtual"), "virtuelle Kammer an virtueller Leitung");
  EXPECT_EQ(translate_instrument(kTranslated, "gyro at virtual"), "gyro an virtueller Leitung");
  EXPECT_EQ(translate_instrument(kTranslated, "F4T at tcp://10.0.0.5:502"), "F4T an tcp://10.0.0.5:502");
  for (const char* other : {"", "Fluke 1524 in room 3", "a bridge, input A", "Fluke at home", "bridge at room 3: left"})
    EXPECT_EQ(translate_instrument(kTranslated, other), other);
  EXPECT_EQ(translate_instrument(kUntranslated, "dcon 2 at x, input 3"), "dcon 2 at x, input 3");
}

TEST(StoredTexts, TranslateThermometerOfUnit) {
  EXPECT_EQ(translate_thermometer(kTranslated, "self"), "eigene");
  EXPECT_EQ(translate_thermometer(kTranslated, "self-made"), "self-made");
  EXPECT_EQ(translate_thermometer(kUntranslated, "self"), "self");
}

TEST(StoredTexts, TranslateFixedTextsOfEvents) {
  const auto event = [](const char* kind, const char* text) { return translate_event(kTranslated, kind, text); };
  EXPECT_EQ(event("held", "held: paused by root"), "gehalten: angehalten von root");
  EXPECT_EQ(event("paused",
                  "suspended: on the way back to the profile after: the air is not at the first set point of the "
                  "profile"),
            "angehalten: auf dem Rückweg zum Profil nach: die Luft ist nicht beim ersten Sollwert des Profils");
  EXPECT_EQ(event("resumed", "execute: the profile continues, after: paused by ada (uid 1000): door open"),
            "das Profil wird fortgesetzt nach: angehalten von ada (uid 1000): door open");
  EXPECT_EQ(event("stopped", "aborting: stopped by ada"), "Abbruch: beendet von ada");
  EXPECT_EQ(event("note", "the profile asks: switch the unit off; done by the virtual rig"),
            "Aufforderung des Profils: switch the unit off; vom virtuellen Prüfstand erledigt");
  EXPECT_EQ(event("note", "calibration of A (certificate 7) was due 2026-02-01"),
            "Kalibrierung von A (Kalibrierschein 7) war am 2026-02-01 fällig");
  EXPECT_EQ(event("note", "supply 1 is on: output 1 24.00 V, 0.495 A"),
            "Netzgerät 1 ist ein: Ausgang 1 24,00 V, 0,495 A");
  EXPECT_EQ(
      event("note",
            "decision 1: continue with \"mission\"; U 0.285 °/h now, 0.2 °/h expected, 0.1 °/h wanted; 1.5 h used, "
            "8 h left; \"mission\" 5 h 0.2 °/h"),
      "Entscheidung 1: weiter mit \"mission\"; U jetzt 0,285 °/h, 0,2 °/h erwartet, 0,1 °/h gewünscht; 1,5 h "
      "verbraucht, 8 h übrig; \"mission\" 5 h 0.2 °/h")
      << "the list of blocks is the wording of the record";
  EXPECT_EQ(event("note", "decision 2: end, U is met; U 0.09 °/h now, 0.1 °/h wanted; 6 h used, 2 h left"),
            "Entscheidung 2: Ende, U ist erreicht; U jetzt 0,09 °/h, 0,1 °/h gewünscht; 6 h verbraucht, 2 h übrig");
  EXPECT_EQ(event("dropped", "u3 dropped by ada: smoke"), "u3 herausgenommen von ada: smoke");
}

TEST(StoredTexts, TranslateStopWithStateOfChamber) {
  const auto stop = [](const char* text) { return translate_event(kTranslated, "stopped", text); };
  EXPECT_EQ(
      stop("aborted by root: smoke; the chamber was sent to 20 °C (set point read back; mode running; air 22.10 °C, "
           "40.00 °C 5 min 00 s before: near 22 °C)"),
      "abgebrochen von root: smoke; die Kammer wurde auf 20 °C gestellt (Sollwert zurückgelesen; Betriebsart in "
      "Betrieb; Luft 22,10 °C, 40,00 °C 5 min 00 s zuvor: nahe 22 °C)");
  EXPECT_EQ(
      stop("stopped by a signal; the chamber was sent to 23.5 °C and switched off, and is NOT confirmed safe yet "
           "(set point NOT shown: reads 50 °C; switched off, as acknowledged; air 50.00 °C: being watched (read "
           "12 s ago)); supply 1 off"),
      "beendet durch ein Signal; die Kammer wurde auf 23,5 °C gestellt und ausgeschaltet, ist aber noch NICHT als "
      "sicher bestätigt (Sollwert NICHT angezeigt: 50 °C gelesen; ausgeschaltet, wie quittiert; Luft 50,00 °C: wird "
      "beobachtet (vor 12 s gelesen)); Netzgerät 1 aus");
  EXPECT_EQ(stop("held for 2 h 00 min 00 s: paused by ada"), "gehalten während 2 h 00 min 00 s: angehalten von ada");
  EXPECT_EQ(stop("aborted by ada: smoke; see log"), "abgebrochen von ada: smoke; see log") << "words of a person";
}

TEST(StoredTexts, TranslateWholeTextOrNothing) {
  for (const auto& [kind, text] :
       {std::pair("held", "held: gyro_silent (hold): gyro u1 silent"),
        std::pair("stopped", "aborting: door open at 3 °C"),
        std::pair("resumed", "resumed after 5 s; cause of the interruption: power"),
        std::pair("stopped", "aborted by root; the chamber was sent to 20 °C (set point read back; its fan hums)"),
        std::pair("note", "values of the file: T: 3 values, 1 to 2 °C; g: lost"),
        std::pair("gap", "the program was not running; power"),
        std::pair("gap", "the program was not running, or its rows were lost"),
        std::pair("fault", "u1: its fan hums (3 ×)"),
        std::pair("alarm", "unguarded (warn): its fan hums [consequence of host_late]")})
    EXPECT_EQ(translate_event(kTranslated, kind, text), text);
}

TEST(StoredTexts, TranslateGapsAndFaults) {
  const auto event = [](const char* kind, const char* text) { return translate_event(kTranslated, kind, text); };
  EXPECT_EQ(event("gap", "the program was not running"), "das Programm lief nicht");
  EXPECT_EQ(event("gap", "the program was not running, or its rows did not reach the disk"),
            "das Programm lief nicht, oder seine Zeilen erreichten den Datenträger nicht");
  EXPECT_EQ(event("gap",
                  "the program was not running, or its rows did not reach the disk; by the wall clock it was down for "
                  "5 min 00 s, but the machine was started 2 min 00 s ago"),
            "das Programm lief nicht, oder seine Zeilen erreichten den Datenträger nicht; nach der Uhr stand es "
            "5 min 00 s still, doch der Rechner wurde erst vor 2 min 00 s gestartet");
  EXPECT_EQ(event("gap",
                  "the program was not running; there is no status file of this run: it was down for 1 h 00 min "
                  "00 s according to the wall clock only"),
            "das Programm lief nicht; zu diesem Prüflauf gibt es keine Statusdatei: es stand 1 h 00 min 00 s still, "
            "allein nach der Uhr");
  EXPECT_EQ(event("fault", "gyro u1: the frame counter restarted; the counts before it are lost (3 ×)"),
            "Kreisel u1: der Rahmenzähler begann neu; die Zählungen davor sind verloren (3 ×)");
  EXPECT_EQ(event("resumed",
                  "resumed after an unknown time; cause of the interruption: the program ended without "
                  "stating a reason; it was held: paused by ada"),
            "fortgesetzt nach unbekannter Zeit; Ursache der Unterbrechung: das Programm endete ohne Angabe eines "
            "Grundes; es war gehalten: angehalten von ada");
}

TEST(StoredTexts, TranslateAlarmsWithTheirTag) {
  const auto alarm = [](const char* kind, const char* text) { return translate_event(kTranslated, kind, text); };
  EXPECT_EQ(
      alarm("interlock", "gyro_silent (suspend): gyro u1 silent for 5 s [consequence of line_lost thermometer 2]"),
      "gyro_silent (anhalten): Kreisel u1 ohne Antwort seit 5 s [Folge von line_lost Thermometer 2]");
  EXPECT_EQ(alarm("alarm", "channel_lost (warn): no reading of thermometer A, thermometer B (2 ×)"),
            "channel_lost (warnen): kein Messwert von Thermometer A, Thermometer B (2 ×)");
  EXPECT_EQ(alarm("interlock", "power_limit (hold): supply 1, output 2: 23.100 V is below 23.5 V"),
            "power_limit (halten): Netzgerät 1, Ausgang 2: 23,100 V liegt unter 23,5 V");
  EXPECT_EQ(
      alarm("interlock", "chamber_sensor (abort): the chamber's sensor jumped by +8.1 K, too fast for air: 30.0 °C"),
      "chamber_sensor (abbrechen): der Fühler der Kammer sprang um +8,1 K, zu schnell für Luft: 30,0 °C");
  EXPECT_EQ(
      alarm("interlock", "program (abort): at the end of its program the controller does not run it: emergency stop"),
      "program (abbrechen): am Ende seines Programms führt der Regler es nicht aus: Not-Halt");
}

TEST(StoredTexts, TranslateFaultsOfInstrumentsWithTheirPlace) {
  const auto fault = [](const char* text) { return translate_event(kTranslated, "fault", text); };
  EXPECT_EQ(fault("chamber: tcp 10.0.0.5:502 unit 1 read 100+5: exception 6, server device busy; next try in 0.5 s"),
            "Kammer: tcp 10.0.0.5:502 Gerät 1 Lesen 100+5: Ausnahme 6, Gerät beschäftigt; nächster Versuch in 0,5 s");
  EXPECT_EQ(fault("thermometer A: thermometer 1 CRDG?: \"x; y: z\" is not 8 readings"),
            "Thermometer A: Thermometer 1 CRDG?: \"x; y: z\" enthält nicht 8 Messwerte");
  EXPECT_EQ(fault("chamber: no reply"), "Kammer: keine Antwort");
  EXPECT_EQ(fault("the record continues in run.2.db, with the rows from slot 90 on: the disk is full"),
            "die Aufzeichnung wird fortgesetzt in run.2.db, mit den Zeilen ab Sekunde 90: der Datenträger ist voll");
}

TEST(StoredTexts, TranslateNotesOfGuardAndOfStart) {
  const auto note = [](const char* text) { return translate_event(kTranslated, "note", text); };
  EXPECT_EQ(
      note("made safe by the guard at 2026-03-01T12:00:00Z (the program that drove it hung): the chamber was sent "
           "to 20 °C; set point read back; mode off; air 21.00 °C: being watched"),
      "von der Wache in den sicheren Zustand gebracht am 2026-03-01T12:00:00Z (das Programm, das sie führte, "
      "hing): die Kammer wurde auf 20 °C gestellt; Sollwert zurückgelesen; Betriebsart aus; Luft 21,00 °C: wird "
      "beobachtet");
  EXPECT_EQ(note("accepted: chamber: another instrument, or other settings: B, 2; the run began with: A; supply 1: "
                 "another instrument, or other settings: D; the run began with: C"),
            "angenommen: Kammer: ein anderes Gerät oder andere Einstellungen: B, 2; der Prüflauf begann mit: A; "
            "Netzgerät 1: ein anderes Gerät oder andere Einstellungen: D; der Prüflauf begann mit: C");
  EXPECT_EQ(note("ada: no reply"), "ada: no reply") << "words of a person";
  EXPECT_EQ(note("ada: the chamber's door is open"), "ada: the chamber's door is open") << "words of a person";
}

/// Returns the string literals of C++ source text; adjacent ones are joined.
std::vector<std::string> find_literals(const std::string& source) {
  std::vector<std::string> literals;
  bool is_adjacent = false;
  for (std::size_t i = 0; i < source.size(); ++i) {
    if (source.compare(i, 2, "//") == 0) i = std::min(source.find('\n', i), source.size() - 1);
    if (source[i] == '\'' && i + 2 < source.size() && source[i + 2] == '\'') i += 2;
    if (source[i] != '"') {
      is_adjacent = is_adjacent && std::isspace(static_cast<unsigned char>(source[i])) != 0;
      continue;
    }
    std::string literal;
    for (++i; i < source.size() && source[i] != '"'; ++i) {
      if (source[i] == '\\') ++i;
      literal += source[i];
    }
    if (std::exchange(is_adjacent, true))
      literals.back() += literal;
    else
      literals.push_back(literal);
  }
  return literals;
}

/// Returns the parts of a format string between its replacement fields that have two words or more.
std::vector<std::string> find_wordings(const std::string& literal) {
  static const std::regex kField(R"(\{[^}]*\}|; )"), kWords("[A-Za-z]{2,},? .*[A-Za-z]{2,}");
  std::vector<std::string> parts;
  for (std::sregex_token_iterator part(literal.begin(), literal.end(), kField, -1), end; part != end; ++part)
    if (std::regex_search(part->first, part->second, kWords)) parts.push_back(part->str());
  return parts;
}

TEST(StoredTexts, ContainWordingsOfSources) {
  // Texts of programmers, of refused commands and uploads, of identities and of alarms that end.
  const std::set<std::string> other_uses{
      "each interlock has its row, in the order of their names",
      "the program is on time",
      "chamber stop",
      "chamber upload",
      "the word order (the set point cannot be read)",
      "the job before has neither begun nor been withdrawn",
      "a set point is sent only while the run is carried out",
      "a controller cannot wait for an operator, and this segment has a prompt",
      "a controller cannot switch the units, and this segment requires them to be off",
      "a controller jumps from {:g} °C to {:g} °C, expected a ramp before this hold",
      "a controller has one soak band for the whole profile",
      "safe-state file",
      "analogue input",
  };
  std::string english;
  for (const auto table : {list_state_phrases(), list_interlock_phrases(), list_fault_phrases(),
                           list_run_note_phrases(), list_import_note_phrases()})
    for (const auto& phrase : table) english += std::string(phrase.english) + "\n";
  int wordings = 0;
  for (const char* file : {"drivers/line/modbus_lines.cpp",
                           "drivers/line/text_exchange.cpp",
                           "drivers/line/byte_streams.cpp",
                           "drivers/gyro/framed_gyro.cpp",
                           "drivers/chamber/modbus_chamber.cpp",
                           "drivers/chamber/text_client.cpp",
                           "drivers/thermometer/dcon_thermometer.cpp",
                           "drivers/supply/power_supply.cpp",
                           "acquisition/exchange/repeat_watch.cpp",

                           "acquisition/io/instrument_io.cpp",
                           "sequencer/run/chamber_lead.cpp",

                           "sequencer/watchdog/watchdog_client.cpp",
                           "sequencer/interlocks/interlocks.cpp",
                           "sequencer/interlocks/measurement_checks.cpp",
                           "sequencer/run/alarm_roots.cpp",
                           "sequencer/run/run_state_machine.cpp",
                           "sequencer/run/safe_sequence.cpp",
                           "sequencer/run/unit_power.cpp",
                           "sequencer/watchdog/air_watch.cpp",
                           "sequencer/watchdog/relay_rescue.cpp",
                           "sequencer/watchdog/safe_evidence.cpp"}) {
    std::ifstream stream(std::string(GYROTHERM_SOURCE_DIR "/") + file);
    const std::string source{std::istreambuf_iterator<char>(stream), {}};
    for (const auto& literal : find_literals(source))
      for (const auto& wording : find_wordings(literal)) {
        if (literal.find('_') != std::string::npos || other_uses.contains(literal)) continue;
        ++wordings;
        EXPECT_NE(english.find(wording), std::string::npos) << file << ": \"" << wording << "\" in no phrase";
      }
  }
  EXPECT_GT(wordings, 150);
}

TEST(StoredTexts, HaveSameVariablePartsInBothLanguages) {
  static const std::regex kPart(R"(\{[a-z]?\})");
  int phrases = 0;
  for (const auto table : {list_subject_phrases(), list_state_phrases(), list_interlock_phrases(), list_fault_phrases(),
                           list_run_note_phrases(), list_import_note_phrases()})
    for (const auto& phrase : table) {
      const auto count_parts = [&](std::string_view text) {
        return std::distance(std::cregex_iterator(text.data(), text.data() + text.size(), kPart),
                             std::cregex_iterator());
      };
      EXPECT_EQ(count_parts(phrase.english), count_parts(phrase.german)) << phrase.english;
      ++phrases;
    }
  EXPECT_GT(phrases, 250);
}

TEST(StoredTexts, TranslateNotesOfImport) {
  const auto note = [](const char* text) { return translate_event(kTranslated, "note", text); };
  EXPECT_EQ(note("values of the file: T, top: 300 values, 20.5 to 24 °C, 3 missing (\"nan\", \"x\"), 1 of them outside "
                 "the valid range; g: 1 value, -1 to 1 °/h; h: 5 values; and 3 more channels"),
            "Werte der Datei: T, top: 300 Werte, 20,5 bis 24 °C, 3 fehlen (\"nan\", \"x\"), davon 1 außerhalb des "
            "gültigen Bereichs; g: 1 Wert, -1 bis 1 °/h; h: 5 Werte; und 3 weitere Kanäle");
  EXPECT_EQ(
      note("warning: B repeats 21.5 °C in 600 consecutive values, from row 100 (1 h 00 min 00 s) to row 700 (2 h 00 "
           "min 00 s), after a jump from 35.1 °C, while A moves from 20 to 40 °C: the sensor has probably failed; "
           "train with --clusters before or after them, or remove B from the map"),
      "Warnung: B wiederholt 21,5 °C in 600 aufeinanderfolgenden Werten, von Zeile 100 (1 h 00 min 00 s) bis Zeile "
      "700 (2 h 00 min 00 s), nach einem Sprung von 35,1 °C, während sich A von 20 auf 40 °C ändert: der Sensor "
      "ist wahrscheinlich ausgefallen; mit --clusters davor oder danach trainieren oder B aus der Zuordnung "
      "entfernen");
  EXPECT_EQ(note("warning: 50 of 300 values of A are missing (17 %); rows without a rate are not used"),
            "Warnung: 50 von 300 Werten von A fehlen (17 %); Zeilen ohne Drehrate werden nicht verwendet");
  EXPECT_EQ(
      note("warning: 12 of 20 values of A are missing (60 %); clusters with a missing temperature are left out, "
           "unless the map does not name the channel; if a slower instrument wrote it, combine rows by \"every\""),
      "Warnung: 12 von 20 Werten von A fehlen (60 %); Mittelwerte mit einer fehlenden Temperatur entfallen, außer "
      "wenn die Zuordnung den Kanal nicht nennt; wenn ein langsameres Gerät ihn schrieb, Zeilen mit \"every\" "
      "zusammenfassen");
  EXPECT_EQ(
      note("3 rows were left out because their time was not after the previous row's; their increments are added "
           "to the rows that follow"),
      "3 Zeilen entfielen, weil ihre Zeit nicht nach der der vorigen lag; ihre Inkremente werden zu den folgenden "
      "Zeilen addiert");
  EXPECT_EQ(note("2 gaps longer than 1.5 s, 12.5 s in all; the first, of 8 s, after row 9"),
            "2 Lücken länger als 1,5 s, insgesamt 12,5 s; die erste, von 8 s, nach Zeile 9");
}

TEST(StoredTexts, KeepWordingOfPeopleAndUnknownTexts) {
  for (const auto& [kind, text] :
       {std::pair("note", "ada: held: the door"), std::pair("stated", "held: paused by root"),
        std::pair("gap", "silent line"), std::pair("alarm", "chamber air 1.20 °C is odd"),
        std::pair("note", "dropped by ada")})
    EXPECT_EQ(translate_event(kTranslated, kind, text), text);
  EXPECT_EQ(translate_event(kUntranslated, "held", "held: paused by root"), "held: paused by root");
}

TEST(StoredTexts, KeepHostileTextsWithLittleEffort) {
  for (const std::string_view part :
       {"; received x", " for 5 s", "chamber: ", "; the chamber was sent to 20 °C (", "; supply 1 off",
        ", thermometer A", "; further attempts follow", " of 1 values of 2 are missing (", "held: "}) {
    std::string text = "held: ";
    while (text.size() + part.size() < 19'000) text += part;
    for (const char* kind : {"held", "fault", "alarm", "note"})
      EXPECT_EQ(translate_event(kTranslated, kind, text), text);
  }
}

TEST(StoredTexts, TranslateMissingItems) {
  const std::vector<std::string> items{
      "order.toml: received, on or before 2026-03-01 (UTC) when the calibration began", "laboratory.toml: city",
      "order.toml: issued, on or after 2026-03-05 when the unit was received",
      "laboratory.toml: person \"A. with role\" with role \"operator\", whom order.toml names"};
  EXPECT_EQ(translate_missing(kTranslated, items),
            "order.toml: received, spätestens am 2026-03-01 (UTC), als die Kalibrierung begann; laboratory.toml: city; "
            "order.toml: issued, frühestens am 2026-03-05, als der Prüfling einging; "
            "laboratory.toml: Person \"A. with role\" mit der Rolle \"operator\", die order.toml nennt");
  EXPECT_EQ(translate_missing(kTranslated, {"records: certificate of a thermometer: B, C; without one in the rig file, "
                                            "equipment with role \"thermometer\" in laboratory.toml"}),
            "Aufzeichnungen: Kalibrierschein eines Thermometers: B, C; ohne Kalibrierschein in der Prüfstandsdatei: "
            "Messeinrichtung mit der Rolle \"thermometer\" in laboratory.toml");
  EXPECT_EQ(translate_missing(kUntranslated, {"a: b", "c: d"}), "a: b; c: d");
  EXPECT_EQ(translate_missing(kTranslated, {}), "");
}

}  // namespace
}  // namespace gyrotherm::report
