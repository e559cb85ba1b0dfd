// SPDX-License-Identifier: Apache-2.0
/// Questions that an operator answers on the live page or with `gyrotherm tell`, before a run has a record. The page
/// shows the run as held, with the question as its cause. The operator resumes it with the answer as text, as for a
/// prompt of a profile.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "apps/console/console.hpp"
#include "core/result.hpp"

namespace gyrotherm::app {

/// Uses the status file and the control socket of the future record. Both are removed by the destructor. One thread.
class RemotePrompt {
 public:
  /// Takes an answer, and returns the text for the operator, or the reason why the answer is not accepted.
  using Acceptor = std::function<Result<std::string>(const std::string& answer)>;

  /// Creates the folder of the record if necessary. Catches signals from now on. Fails with storage, or with refused if
  /// another program already uses the name of the record.
  [[nodiscard]] static Result<std::unique_ptr<RemotePrompt>> open(Console& console, const std::string& record,
                                                                  bool simulated);
  virtual ~RemotePrompt() = default;

  /// Shows the question and waits for an answer that `accept` takes. Fails with interrupted if the operator stops the
  /// run, or at a signal.
  [[nodiscard]] virtual Result<void> ask(const std::string& question, const Acceptor& accept) = 0;
};

}  // namespace gyrotherm::app
