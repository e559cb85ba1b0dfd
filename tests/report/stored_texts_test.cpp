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
  for (const char* other : {"", "Fluke 1524 in room 3", "a bridge, input A"})
    EXPECT_EQ(translate_instrument(kTranslated, other), other);
  EXPECT_EQ(translate_instrument(kUntranslated, "dcon 2 at x, input 3"), "dcon 2 at x, input 3");
}

TEST(StoredTexts, TranslateThermometerOfUnit) {
  EXPECT_EQ(translate_thermometer(kTranslated, "self"), "eigene");
  EXPECT_EQ(translate_thermometer(kTranslated, "self-made"), "self-made");
  EXPECT_EQ(translate_thermometer(kUntranslated, "self"), "self");
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
            "Aufzeichnungen: Kalibrierschein eines Thermometers: B, C; ohne Kalibrierschein in der Messplatzdatei: "
            "Messeinrichtung mit der Rolle \"thermometer\" in laboratory.toml");
  EXPECT_EQ(translate_missing(kUntranslated, {"a: b", "c: d"}), "a: b; c: d");
  EXPECT_EQ(translate_missing(kTranslated, {}), "");
}

}  // namespace
}  // namespace gyrotherm::report
