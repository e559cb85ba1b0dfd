// SPDX-License-Identifier: Apache-2.0
/// A mark beside the record of a real run: an operator must confirm a resume. It is set while the run is held or being
/// aborted. It needs no space on a full disk, which may lack the rows that state this.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "core/sample.hpp"

namespace gyrotherm::app {

class OperatorMark {
 public:
  explicit OperatorMark(const std::string& record);

  /// Sets or removes the mark if the state requires another one than the previous state. A thread of its own does this,
  /// because a disk may hang; nothing waits for it.
  void follow(RunState state);

 private:
  struct Shared;

  std::shared_ptr<Shared> shared_;
  std::optional<bool> last_;
};

/// Returns the path of the mark: "RUN.db" → "RUN.db.ask-operator".
[[nodiscard]] std::string operator_mark_path(const std::string& record);
[[nodiscard]] bool has_operator_mark(const std::string& record);
/// Returns true if a real run was held, aborted or ended by its program, and its record may not state this.
/// `is_end_recorded` is true if the record states how its program ended.
[[nodiscard]] bool has_lost_end(const std::string& record, bool is_end_recorded);
/// Removes the mark of a run whose record states its end.
void remove_operator_mark(const std::string& record);

}  // namespace gyrotherm::app
