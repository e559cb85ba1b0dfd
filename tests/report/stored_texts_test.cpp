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
