// SPDX-License-Identifier: Apache-2.0
/// The queries of a site to its store, and the answers as a table for people or as JSON. The views are in
/// apps/site/migrations; a query is a row of the table in questions.cpp.
#pragma once

#include <cstddef>
#include <span>
#include <string>

#include "apps/site/postgres.hpp"
#include "core/result.hpp"

namespace gyrotherm::site {

struct Question {
  const char* name;  ///< the command
  const char* view;  ///< in the schema gyrotherm
  /// SQL: columns of the view.
  const char* columns;
  /// SQL: the rows that are shown without --all; empty: all rows.
  const char* condition;
  const char* order;  ///< SQL
  const char* help;
};

[[nodiscard]] std::span<const Question> questions();

/// The options of a query.
struct QueryOptions {
  /// A serial number; empty: all units. Only for a view with units.
  std::string unit{};
  std::size_t most = 100;  ///< rows; 0: all
  bool all{};              ///< ignores the condition
};

/// Returns true if the query is about units; then `QueryOptions::unit` applies.
[[nodiscard]] bool has_units(const Question& question);

/// Sends the query. Fails like Postgres.
[[nodiscard]] Result<Answer> ask(Postgres& store, const Question& question, const QueryOptions& query);

/// Returns a line of titles and one line per row; two blanks separate the columns. Empty without rows.
[[nodiscard]] std::string as_table(const Answer& answer);
/// Returns an array with one object per row: numbers and booleans as such, other values as text, NULL as null.
[[nodiscard]] std::string as_json(const Answer& answer);

}  // namespace gyrotherm::site
