// SPDX-License-Identifier: Apache-2.0
/// Brings the store's schema up to date, step by step.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <string_view>

#include "apps/site/postgres.hpp"
#include "core/result.hpp"

namespace gyrotherm::site {

struct Migration {
  int number{};
  const char* name = "";
  std::string_view (*sql)() = nullptr;
};

/// All that this program knows, in order; numbers go on from 1.
[[nodiscard]] std::span<const Migration> migrations();

/// Carries out the steps that the store has not seen, up to `last`, each in a transaction of its own, and calls `done`
/// after each; two that migrate at once wait for each other. Fails like Postgres, and with refused if a step that the
/// store has seen was another one, or the store has steps that this program does not know.
[[nodiscard]] Result<void> migrate(Postgres& store, int last, const std::function<void(const Migration&)>& done);

}  // namespace gyrotherm::site
