// SPDX-License-Identifier: Apache-2.0
/// Queries of the site's store. Results are printed as a table or as JSON. A query is a row of the table in queries.cpp
/// and a view in apps/site/migrations.
#pragma once

#include <cstddef>
#include <span>
#include <string>

#include "apps/site/postgres.hpp"
#include "core/result.hpp"

namespace gyrotherm::site {

struct StoreQuery {
  const char* name;  ///< the command
  const char* view;  ///< in the schema gyrotherm
  /// SQL: columns of the view.
  const char* columns;
  /// SQL: selects the rows that are printed without --all; empty: all rows.
  const char* condition;
  const char* order;  ///< SQL
  const char* help;
};

[[nodiscard]] std::span<const StoreQuery> queries();

/// The options of a query.
struct QueryOptions {
  /// Serial number of the only unit to print; empty: all units. Requires has_units().
  std::string unit{};
  std::size_t most = 100;  ///< rows; 0: all
  bool all{};              ///< ignores the condition
};

/// Returns true if the rows of the query belong to units, so `QueryOptions::unit` can select one.
[[nodiscard]] bool has_units(const StoreQuery& query);

/// Sends a query to the store. Fails like Postgres.
[[nodiscard]] Result<QueryResult> run_query(Postgres& store, const StoreQuery& query, const QueryOptions& options);

/// Returns the column titles and the rows as lines, with aligned columns. Returns an empty text if there are no rows.
[[nodiscard]] std::string format_table(const QueryResult& answer);
/// Returns a JSON array with an object per row. Values other than numbers, booleans and NULL are strings.
[[nodiscard]] std::string format_rows_as_json(const QueryResult& answer);

}  // namespace gyrotherm::site
