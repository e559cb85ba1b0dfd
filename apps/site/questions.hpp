// SPDX-License-Identifier: Apache-2.0
/// What a site asks of its store, and the answers as a table for people or as JSON. The views are in
/// apps/site/migrations; a question is a row of the table in questions.cpp.
#pragma once

#include <cstddef>
#include <span>
#include <string>

#include "apps/site/postgres.hpp"
#include "core/result.hpp"

namespace gyrotherm::site {

struct Question {
  const char* name;       ///< the command
  const char* view;       ///< in the schema gyrotherm
  const char* columns;    ///< of it, as SQL has them
  const char* condition;  ///< SQL, what is shown unless --all asks for everything; empty: everything
  const char* order;      ///< SQL
  const char* help;
};

[[nodiscard]] std::span<const Question> questions();

struct Asked {
  std::string unit{};      ///< a serial number; empty: every unit's. For a view that has units
  std::size_t most = 100;  ///< rows; 0: all
  bool all{};              ///< also what the question's condition leaves out
};

/// Whether a question is about units, so that `Asked::unit` may be given.
[[nodiscard]] bool has_units(const Question& question);

/// Fails like Postgres.
[[nodiscard]] Result<Answer> ask(Postgres& store, const Question& question, const Asked& asked);

/// A line of titles, a line a row; columns are set apart by two blanks. Empty if there is no row.
[[nodiscard]] std::string as_table(const Answer& answer);
/// An array with an object a row: numbers and truth values as such, all else as text, NULL as null.
[[nodiscard]] std::string as_json(const Answer& answer);

}  // namespace gyrotherm::site
