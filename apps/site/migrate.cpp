// SPDX-License-Identifier: Apache-2.0
#include "apps/site/migrate.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "core/sha256.hpp"

namespace gyrotherm::site {
namespace {

constexpr std::array kMigrations{Migration{1, "store", store_schema},
                                 Migration{2, "units", units_schema},
                                 Migration{3, "alarms", alarms_schema},
                                 Migration{4, "check-standards", check_standards_schema},
                                 Migration{5, "figures-of-types", figures_of_types_schema},
                                 Migration{6, "real-runs", real_runs_schema},
                                 Migration{7, "growing-runs", growing_runs_schema}};

constexpr const char* kCreateMigrationTable = R"(
CREATE SCHEMA IF NOT EXISTS gyrotherm;
CREATE TABLE IF NOT EXISTS gyrotherm.migration (number integer PRIMARY KEY, name text NOT NULL, sha256 text NOT NULL,
                                                applied timestamptz NOT NULL DEFAULT now());
)";

/// Creates the schema and the table of applied migrations, if they do not exist. If another program creates them at the
/// same time, PostgreSQL refuses the first attempt.
Result<void> create_migration_table(Postgres& store) {
  auto created = store.execute(kCreateMigrationTable);
  if (!created && created.error().kind == FaultKind::refused) created = store.execute(kCreateMigrationTable);
  return created;
}

/// Fails with refused if the store has a migration that is unknown, or that differs from the known one of its number.
Result<void> check_applied_migrations(Postgres& store, std::span<const Migration> known) {
  const auto seen = store.query("SELECT number, sha256 FROM gyrotherm.migration ORDER BY number");
  if (!seen) return failure(seen.error());
  for (int row = 0; row < seen->rows(); ++row) {
    const auto number = seen->integer(row, 0);
    const auto step = std::ranges::find(known, number, [](const Migration& one) { return std::int64_t{one.number}; });
    if (step == known.end())
      return failure(FaultKind::refused, kStore,
                     fmt::format("has migration {}, but this version ends at {}: a newer version migrated it; use that "
                                 "version",
                                 number, known.back().number));
    if (seen->text(row, 1) != sha256(step->sql()))
      return failure(
          FaultKind::refused, kStore,
          fmt::format("has a migration {} that differs from this version's: another version created the store; "
                      "create a new store and publish the records again",
                      number));
  }
  return {};
}

/// Applies a migration. Returns false, without changes, if another program has applied it in the meantime.
Result<bool> apply_migration(Postgres& store, std::span<const Migration> known, const Migration& step) {
  // Only the owner of the store may take this lock. Any role could hold an advisory lock.
  auto begun = store.execute("BEGIN; LOCK TABLE gyrotherm.migration IN SHARE ROW EXCLUSIVE MODE");
  if (!begun) {
    if (!store.is_broken()) static_cast<void>(store.execute("ROLLBACK"));
    return failure(begun.error());
  }
  const auto seen = check_applied_migrations(store, known).and_then([&] {
    return store.query("SELECT FROM gyrotherm.migration WHERE number = $1", {std::to_string(step.number)});
  });
  if (!seen || seen->rows() > 0) {
    if (!store.is_broken()) static_cast<void>(store.execute("ROLLBACK"));
    return seen.map([](const QueryResult&) { return false; });
  }
  const auto applied = store.execute(std::string(step.sql())).and_then([&] {
    return store.query("INSERT INTO gyrotherm.migration(number, name, sha256) VALUES ($1, $2, $3)",
                       {std::to_string(step.number), step.name, sha256(step.sql())});
  });
  if (!applied) {
    if (!store.is_broken()) static_cast<void>(store.execute("ROLLBACK"));
    return failure(applied.error().kind, fmt::format("migration {}", step.number), text(applied.error()));
  }
  return store.execute("COMMIT").map([] { return true; });
}

}  // namespace

std::span<const Migration> migrations() { return kMigrations; }

Result<void> migrate(Postgres& store, std::span<const Migration> known, int last,
                     const std::function<void(const Migration&)>& done) {
  if (auto created = create_migration_table(store); !created) return created;
  if (auto good = check_applied_migrations(store, known); !good) return good;
  for (const auto& step : known) {
    if (step.number > last) break;
    const auto applied = apply_migration(store, known, step);
    if (!applied) return failure(applied.error());
    if (*applied) done(step);
  }
  return {};
}

}  // namespace gyrotherm::site
