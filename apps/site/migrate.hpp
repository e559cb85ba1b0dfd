// SPDX-License-Identifier: Apache-2.0
/// Updates the store's schema by numbered migrations. The store keeps the number and the digest of each one.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <string_view>

#include "apps/site/postgres.hpp"
#include "core/result.hpp"

namespace gyrotherm::site {

/// Return the embedded SQL of the files in apps/site/migrations, in their order. A released migration is never edited.
/// A change needs a new migration, with its own file and function.
[[nodiscard]] std::string_view store_schema();
[[nodiscard]] std::string_view units_schema();
[[nodiscard]] std::string_view alarms_schema();
[[nodiscard]] std::string_view check_standards_schema();
[[nodiscard]] std::string_view figures_of_types_schema();
[[nodiscard]] std::string_view real_runs_schema();
[[nodiscard]] std::string_view growing_runs_schema();

struct Migration {
  int number{};
  const char* name = "";
  std::string_view (*sql)() = nullptr;
};

/// Returns the migrations of this program, in the order of their numbers, from 1.
[[nodiscard]] std::span<const Migration> migrations();

/// Applies the migrations of `known` that the store does not have, up to number `last`, each in its own transaction,
/// and calls `done` after each. If two programs migrate at the same time, one waits for the other. Fails like Postgres,
/// or with refused, without changes, if the store has a migration that is unknown or differs from the one in `known`.
[[nodiscard]] Result<void> migrate(Postgres& store, std::span<const Migration> known, int last,
                                   const std::function<void(const Migration&)>& done);

}  // namespace gyrotherm::site
