// SPDX-License-Identifier: Apache-2.0
/// Imports random tables with the draft map, and compares the records with the content of the tables.
#include "tests/acquisition/exchange/random_table.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>

#include "acquisition/exchange/guess.hpp"
#include "acquisition/exchange/import.hpp"
#include "acquisition/record/record.hpp"
#include "tests/support/folder.hpp"

namespace gyrotherm::exchange {
namespace {

#ifdef GYROTHERM_NIGHTLY
constexpr std::uint64_t kTables = 10'000;
#else
constexpr std::uint64_t kTables = 100;
#endif

/// Returns the differences between a record and its table; empty if there are none.
std::string differences(const RandomTable& table, std::size_t damaged, const record::Record& made,
                        const ImportSummary& summary) {
  const auto rows = table.time_s.size();
  if (made.slot.size() != rows) return "rows " + std::to_string(made.slot.size()) + " of " + std::to_string(rows);
  if (summary.lines_left_out != damaged)
    return "left out " + std::to_string(summary.lines_left_out) + " of " + std::to_string(damaged);
  if (made.thermometers_c.size() != table.temperatures_c.size()) return "thermometers";
  if (made.units.size() != 1 || made.units[0].rotation.size() != table.rates_deg_per_h.size()) return "axes";
  const auto is_alike = [](double a, double b, double within) {
    return std::isnan(a) ? std::isnan(b) : std::abs(a - b) <= within;
  };
  for (std::size_t i = 0; i < rows; ++i) {
    if (!is_alike(table.time_s[i], made.time_s[i], 2e-3))
      return "time of row " + std::to_string(i) + ": " + std::to_string(made.time_s[i]) + " for " +
             std::to_string(table.time_s[i]);
    for (std::size_t t = 0; t < table.temperatures_c.size(); ++t)
      if (!is_alike(table.temperatures_c[t][i], made.thermometers_c[t][i], 1e-9))
        return "temperature of row " + std::to_string(i);
    for (std::size_t a = 0; a < table.rates_deg_per_h.size(); ++a) {
      const double rate = made.units[0].rotation[a][i] * made.info.units[0].axes[a].scale;
      if (!is_alike(table.rates_deg_per_h[a][i], rate, 1e-6)) return "rate of row " + std::to_string(i);
    }
  }
  if (table.started_utc_s && std::abs(to_seconds(made.info.started_utc) - *table.started_utc_s) > 1e-2) return "UTC";
  return "";
}

/// Imports each table with the map of the undamaged table, as a user does who has many files of one logger.
TEST(RandomTables, AreImportedCorrectlyIfFirstRowsAreDamaged) {
  const tests::TestFolder folder;
  std::size_t compared = 0;
  for (std::uint64_t seed = 0; seed < kTables; ++seed) {
    const RandomTable table = random_table(seed);
    const std::string file = folder / "table.csv", map = folder / "map.toml", out = folder / "run.db";
    std::ofstream(file, std::ios::binary) << table.text;
    auto guess = guess_map(file);
    if (!guess) continue;
    if (guess->find("damaged = ") == std::string::npos)
      guess->insert(guess->find("[file]\n") + 7, "damaged = \"skip\"\n");
    std::ofstream(map) << *guess;
    if (!import_record(file, map, out, "0.2.0")) continue;
    for (const char* suffix : {"", ".sha256"}) std::filesystem::remove(out + suffix);
    std::ofstream(file, std::ios::binary) << table.damaged_text;
    const auto summary = import_record(file, map, out, "0.2.0");
    ASSERT_TRUE(summary) << "seed " << seed << " (" << table.drawn << "): " << text(summary.error());
    const auto made = record::read_record(out);
    ASSERT_TRUE(made) << text(made.error());
    EXPECT_EQ(differences(table, table.damaged_in_text, *made, *summary), "") << seed << " (" << table.drawn << ")";
    for (const char* suffix : {"", ".sha256"}) std::filesystem::remove(out + suffix);
    ++compared;
  }
  EXPECT_GE(compared, kTables * 9 / 10);
}

TEST(RandomTables, AreImportedCorrectlyOrRefused) {
  const tests::TestFolder folder;
  std::size_t wrong = 0, refused = 0, unnamed = 0;
  std::map<std::string, int> causes;
  const char* only = std::getenv("GYROTHERM_TABLE");
  for (std::uint64_t seed = only ? std::stoull(only) : 0; seed < (only ? std::stoull(only) + 1 : kTables); ++seed) {
    const RandomTable table = random_table(seed);
    const std::string file = folder / "table.csv", map = folder / "map.toml", out = folder / "run.db";
    std::ofstream(file, std::ios::binary) << table.text;
    const auto guess = guess_map(file);
    if (guess) std::ofstream(map) << *guess;
    const auto summary = guess ? import_record(file, map, out, "0.1.0") : failure(guess.error());
    if (only) {
      std::ofstream("/tmp/table.csv", std::ios::binary) << table.text;
      std::ofstream("/tmp/table.toml") << guess.value_or("");
    }
    if (!summary) {
      ++refused;
      ++causes[summary.error().what.substr(0, 60)];
      const bool names = summary.error().what.find("column") != std::string::npos ||
                         summary.error().what.find("unit") != std::string::npos ||
                         summary.error().what.find("order") != std::string::npos;
      if (!names) ++unnamed;
      if (!names) ADD_FAILURE() << "seed " << seed << " (" << table.drawn << "): " << text(summary.error());
      continue;
    }
    const auto made = record::read_record(out);
    const auto difference = made ? differences(table, table.damaged, *made, *summary) : text(made.error());
    if (!difference.empty() && ++wrong < 20)
      ADD_FAILURE() << "seed " << seed << " (" << table.drawn << "): " << difference;
    std::filesystem::remove(out);
    std::filesystem::remove(out + ".sha256");
  }
  for (const auto& [cause, count] : causes) std::cout << count << " refused: " << cause << "\n";
  std::cout << kTables << " tables: " << wrong << " wrong, " << refused << " refused, " << unnamed
            << " without a cause\n";
  EXPECT_EQ(wrong, 0u);
  EXPECT_LE(refused, kTables / 20);
}

}  // namespace
}  // namespace gyrotherm::exchange
