// SPDX-License-Identifier: Apache-2.0
#include "apps/gyrotherm/german_evidence.hpp"

#include <gtest/gtest.h>

#include <utility>

namespace gyrotherm::app {
namespace {

TEST(GermanEvidence, TranslatesKnownPhrases) {
  const std::pair<const char*, const char*> cases[] = {
      {"abort after 2 s", "abbrechen nach 2 s"},
      {"hold after 11 s", "halten nach 11 s"},
      {"not tested: the rig has no power supply", "nicht geprüft: der Prüfstand hat kein Netzgerät"},
      {"FAILED: does not act on injected values", "NICHT bestanden: wirkt nicht bei eingespeisten Werten"},
      {"120.0 °C ± 2.5 K", "120,0 °C ± 2,5 K"},
      {"confirmed by the guard after", "von der Wache bestätigt nach"},
      {"air", "Luft"},
      {"0.2 s; set point 20 °C, air 19.99 °C, running", "0,2 s; Sollwert 20 °C, Luft 19,99 °C, läuft"},
      {"set point unreadable, air 20.85 °C, unknown", "Sollwert nicht lesbar, Luft 20,85 °C, unbekannt"},
      {"set point -10.5 °C, air 21.00 °C, not following its set point",
       "Sollwert -10,5 °C, Luft 21,00 °C, folgt ihrem Sollwert nicht"},
      {"the chamber was not safe 60 s after the line returned: set point 20 °C, air 30.10 °C, door open",
       "die Kammer war nicht sicher 60 s nach der Rückkehr der Leitung: Sollwert 20 °C, Luft 30,10 °C, Tür offen"},
      {"the chamber did not take the set point: timeout", "die Kammer nahm den Sollwert nicht an: timeout"},
      {"the chamber does not show its set point and its mode: it is left at the safe set point of 22.5 °C",
       "die Kammer zeigt Sollwert und Betriebsart nicht: sie bleibt auf dem sicheren Sollwert von 22,5 °C"},
      {"the air did not exceed the limiter's setting of 50 °C by 3 K in 30 min 00 s: 51.20 °C",
       "die Luft überschritt nicht die Einstellung des Begrenzers von 50 °C um 3 K in 30 min 00 s: 51,20 °C"},
      {"file system: ext4, blocks of 4096 bytes; disk: /data: 12.5 GB free, 900 inodes",
       "Dateisystem: ext4, Blöcke zu 4096 Byte; Datenträger: /data: 12,5 GB frei, 900 Inodes"},
  };
  for (const auto& [english, german] : cases) EXPECT_EQ(translate_evidence(english), german);
}

TEST(GermanEvidence, KeepsNamesAddressesAndInstants) {
  for (const char* text : {"", "tcp://10.0.0.5:502", "2026-03-01T12:00:00Z", "air_limit", "holdings", "chamber-5"})
    EXPECT_EQ(translate_evidence(text), text);
}

}  // namespace
}  // namespace gyrotherm::app
