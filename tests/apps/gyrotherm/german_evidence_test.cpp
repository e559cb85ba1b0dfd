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
