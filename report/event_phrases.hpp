// SPDX-License-Identifier: Apache-2.0
/// Fixed texts of events in a record, in English and German.
#pragma once

#include <span>
#include <string_view>

namespace gyrotherm::report {

/// A text of the program in both languages. A {} is a variable part that stays as it is, such as a name or a number. A
/// {c} is one without ": " and "; ", an {n} also without ", ", and a {p} consists of the words of a person. An {s} is
/// the name of an instrument or a channel, which list_subject_phrases() translates. A {t} must itself be a text of the
/// same tables, an {l} a list of such texts, separated by "; ", and an {e} a cause; otherwise the phrase does not
/// match. A text is therefore translated wholly or not at all. The first phrase that matches is used. The German text
/// has the variable parts in the same order.
struct StoredPhrase {
  std::string_view english, german;
};

/// Lists names such as "thermometer A" and "supply 1, output 2". Other names stay as they are.
[[nodiscard]] std::span<const StoredPhrase> list_subject_phrases();

/// Lists the states of a run and their causes, and the evidence for the safe state of the chamber.
[[nodiscard]] std::span<const StoredPhrase> list_state_phrases();

/// Lists the causes of the interlocks.
[[nodiscard]] std::span<const StoredPhrase> list_interlock_phrases();

/// Lists the faults that the drivers, the record and the run report.
[[nodiscard]] std::span<const StoredPhrase> list_fault_phrases();

/// Lists the notes of a run.
[[nodiscard]] std::span<const StoredPhrase> list_run_note_phrases();

/// Lists the notes of an import about its file and its channels.
[[nodiscard]] std::span<const StoredPhrase> list_import_note_phrases();

}  // namespace gyrotherm::report
