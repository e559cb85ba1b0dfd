// SPDX-License-Identifier: Apache-2.0
/// Migrations after the first one, with a PostgreSQL server whose address is in GYROTHERM_STORE. Site.RefusesOtherRoles
/// starts the server, and a publisher sends to it meanwhile.
#include "apps/site/migrate.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace gyrotherm::site {
namespace {

std::string_view a_table() { return "CREATE TABLE gyrotherm.further (number integer)"; }
std::string_view another_table() { return "CREATE TABLE gyrotherm.another (number integer)"; }
std::string_view broken() { return "CREATE TABLE gyrotherm.half (number integer); SELECT 1/0"; }

/// Name and statements of a migration that the program does not have.
using Further = std::pair<const char*, std::string_view (*)()>;

/// Returns the migrations of the program, followed by further ones.
std::vector<Migration> known_with(const std::vector<Further>& further) {
  std::vector<Migration> known(migrations().begin(), migrations().end());
  for (const auto& [name, sql] : further) known.push_back({static_cast<int>(known.size()) + 1, name, sql});
  return known;
}

TEST(Migrations, AreNumberedWithoutAHole) {
  int number = 0;
  for (const auto& step : migrations()) {
    EXPECT_EQ(step.number, ++number);
    EXPECT_FALSE(step.sql().empty());
    EXPECT_EQ(step.sql().find("BEGIN;"), std::string_view::npos) << "each has its transaction already";
  }
  EXPECT_GT(number, 0);
}

class MigratedStore : public testing::Test {
 protected:
  void SetUp() override {
    const char* address = std::getenv("GYROTHERM_STORE");
    if (address == nullptr) GTEST_SKIP() << "GYROTHERM_STORE is not set: Site.RefusesOtherRoles sets it";
    auto store = Postgres::connect({.conninfo = address}, {});
    ASSERT_TRUE(store) << text(store.error());
    store_.emplace(std::move(*store));
  }

  /// Returns the numbers of the steps that were executed.
  Result<std::vector<int>> take(const std::vector<Migration>& known, int last = 99) {
    std::vector<int> taken;
    const auto done = migrate(*store_, known, last, [&](const Migration& step) { taken.push_back(step.number); });
    if (!done) return failure(done.error());
    return taken;
  }
  bool has(const std::string& table) {
    const auto found = store_->query("SELECT to_regclass($1) IS NOT NULL", {table});
    return found && found->boolean(0, 0);
  }

  std::optional<Postgres> store_;
};

TEST_F(MigratedStore, TakesEachStepOnce) {
  const int last = migrations().back().number;
  const Further further{"further", a_table};
  EXPECT_EQ(take(known_with({further}), last).value(), std::vector<int>{});
  EXPECT_FALSE(has("gyrotherm.further"));
  EXPECT_EQ(take(known_with({further})).value(), std::vector{last + 1}) << "the program has executed its own ones";
  EXPECT_EQ(take(known_with({further})).value(), std::vector<int>{});
  EXPECT_TRUE(has("gyrotherm.further"));

  const auto differs = take(known_with({{"further", another_table}}));
  ASSERT_FALSE(differs);
  EXPECT_EQ(differs.error().kind, FaultKind::refused);
  EXPECT_NE(differs.error().what.find(fmt::format("migration {} that differs", last + 1)), std::string::npos)
      << differs.error().what;
  EXPECT_FALSE(has("gyrotherm.another"));

  const auto fails = take(known_with({further, {"broken", broken}}));
  ASSERT_FALSE(fails);
  EXPECT_EQ(fails.error().where, fmt::format("migration {}", last + 2));
  EXPECT_FALSE(has("gyrotherm.half")) << "the whole step is undone";
  EXPECT_EQ(take(known_with({further, {"another", another_table}})).value(), std::vector{last + 2});

  const auto is_older = take(known_with({further}));
  ASSERT_FALSE(is_older);
  EXPECT_EQ(is_older.error().kind, FaultKind::refused);
}

}  // namespace
}  // namespace gyrotherm::site
