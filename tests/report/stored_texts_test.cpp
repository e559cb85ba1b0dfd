// SPDX-License-Identifier: Apache-2.0
#include "report/stored_texts.hpp"

#include <gtest/gtest.h>

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
        std::pair("fault", "u1: no reply (3 ×)")})
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
            "gyro u1: der Rahmenzähler begann neu; die Zählungen davor sind verloren (3 ×)");
  EXPECT_EQ(event("resumed",
                  "resumed after an unknown time; cause of the interruption: the program ended without "
                  "stating a reason; it was held: paused by ada"),
            "fortgesetzt nach unbekannter Zeit; Ursache der Unterbrechung: das Programm endete ohne Angabe eines "
            "Grundes; es war gehalten: angehalten von ada");
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
  EXPECT_EQ(note("2 gaps longer than 1.5 s, 12.5 s in all; the first, of 8 s, after row 9"),
            "2 Lücken länger als 1,5 s, insgesamt 12,5 s; die erste, von 8 s, nach Zeile 9");
}

TEST(StoredTexts, KeepWordingOfPeopleAndUnknownTexts) {
  for (const auto& [kind, text] :
       {std::pair("note", "ada: held: the door"), std::pair("stated", "held: paused by root"),
        std::pair("gap", "silent line"), std::pair("alarm", "chamber air 1.20 °C is outside -1 … 1 °C"),
        std::pair("note", "dropped by ada")})
    EXPECT_EQ(translate_event(kTranslated, kind, text), text);
  EXPECT_EQ(translate_event(kUntranslated, "held", "held: paused by root"), "held: paused by root");
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
