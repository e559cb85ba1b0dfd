// SPDX-License-Identifier: Apache-2.0
#include "apps/site/migrate.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "apps/site/migrations.hpp"
#include "core/sha256.hpp"

namespace gyrotherm::site {
namespace {

constexpr std::array kMigrations{Migration{1, "store", store_schema},     Migration{2, "questions", fleet_questions},
                                 Migration{3, "owners", document_owners}, Migration{4, "simulated", simulated_apart},
                                 Migration{5, "bounds", bounds_of_rigs},  Migration{6, "isolation", rigs_apart},
                                 Migration{7, "alarms", alarm_rows},      Migration{8, "zeros", zeros_in_conditions}};

/// What has to be there before the first step.
constexpr const char* kBeginning = R"(
BEGIN;
SELECT pg_advisory_xact_lock(hashtext('gyrotherm.migrate'));
CREATE SCHEMA IF NOT EXISTS gyrotherm;
CREATE TABLE IF NOT EXISTS gyrotherm.migration (number integer PRIMARY KEY, name text NOT NULL, sha256 text NOT NULL,
                                                applied timestamptz NOT NULL DEFAULT now());
COMMIT;
)";

/// Nothing changes unless the step is the next one now: another program may have taken it meanwhile.
Result<bool> take_step(Postgres& store, const Migration& step) {
  const auto digest = sha256(step.sql());
  auto begun = store.run("BEGIN; SELECT pg_advisory_xact_lock(hashtext('gyrotherm.migrate'))");
  if (!begun) return failure(begun.error());
  const auto seen =
      store.ask("SELECT sha256 FROM gyrotherm.migration WHERE number = $1", {std::to_string(step.number)});
  if (!seen) return failure(seen.error());
  if (seen->rows() > 0) {
    const bool same = seen->text(0, 0) == digest;
    if (auto ended = store.run("ROLLBACK"); !ended) return failure(ended.error());
    if (same) return false;
    return failure(FaultKind::refused, fmt::format("migration {}", step.number),
                   "the store has seen another one of that number");
  }
  const auto taken = store.run(std::string(step.sql())).and_then([&] {
    return store.ask("INSERT INTO gyrotherm.migration(number, name, sha256) VALUES ($1, $2, $3)",
                     {std::to_string(step.number), step.name, digest});
  });
  if (!taken) {
    if (!store.is_broken()) static_cast<void>(store.run("ROLLBACK"));
    return failure(taken.error().kind, fmt::format("migration {}", step.number), text(taken.error()));
  }
  return store.run("COMMIT").map([] { return true; });
}

}  // namespace

std::span<const Migration> migrations() { return kMigrations; }

Result<void> migrate(Postgres& store, int last, const std::function<void(const Migration&)>& done) {
  if (auto begun = store.run(kBeginning); !begun) return begun;
  const auto known = store.ask("SELECT coalesce(max(number), 0) FROM gyrotherm.migration");
  if (!known) return failure(known.error());
  if (known->integer(0, 0) > kMigrations.back().number)
    return failure(FaultKind::refused, kStore,
                   fmt::format("has migration {}, and this program knows {}: a newer one made it", known->integer(0, 0),
                               kMigrations.back().number));
  for (const auto& step : kMigrations) {
    if (step.number > last) break;
    const auto taken = take_step(store, step);
    if (!taken) return failure(taken.error());
    if (*taken) done(step);
  }
  return {};
}

}  // namespace gyrotherm::site
