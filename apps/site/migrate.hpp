// SPDX-License-Identifier: Apache-2.0
/// Brings the store's schema up to date, step by step. The store keeps the number and the digest of each step.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <string_view>

#include "apps/site/postgres.hpp"
#include "core/result.hpp"

namespace gyrotherm::site {

/// Returns the SQL of apps/site/migrations/0001-store.sql, which is embedded. A released step is not edited: a change
/// is a step of its own, with a file and a function of its own.
[[nodiscard]] std::string_view store_schema();

struct Migration {
  int number{};
  const char* name = "";
  std::string_view (*sql)() = nullptr;
};

/// Returns the steps that this program knows, numbered from 1 in order.
[[nodiscard]] std::span<const Migration> migrations();

/// Executes the steps of `known` that are new to the store, up to number `last`, each in a transaction of its own, and
/// calls `done` after each. If two programs migrate at the same time, one waits for the other. Fails like Postgres.
/// Fails with refused, and changes nothing, if the store has a step that is not one of `known`.
[[nodiscard]] Result<void> migrate(Postgres& store, std::span<const Migration> known, int last,
                                   const std::function<void(const Migration&)>& done);

}  // namespace gyrotherm::site
