// SPDX-License-Identifier: Apache-2.0
/// Checks that an instrument is still the one with which the run began. The check is made after every event during
/// which the instrument could have been exchanged: a broken connection, a series of unanswered calls, or several
/// seconds without a call. Only the instrument's own thread may use a watch, except for mismatch_text(),
/// last_fault() and request_check(), which any thread may call.
#pragma once

#include <atomic>
#include <cstdint>
#include <mutex>
#include <string>
#include <type_traits>
#include <utility>

#include "core/result.hpp"
#include "drivers/instruments.hpp"

namespace gyrotherm::io {

/// The name of an instrument and the identity that it had when the run began.
struct KnownIdentity {
  std::string title{};  ///< for example "thermometer 2"
  /// The text that Identified::identify() returned. If it is empty, no comparison is made.
  std::string identity{};
};

class IdentityWatch {
 public:
  explicit IdentityWatch(KnownIdentity known) : known_(std::move(known)) {}

  /// Compares the instrument's identity with the known one if there is a reason to doubt it. Fails with mismatch,
  /// naming both instruments, if another instrument answers. Fails as identify() does if none answers. After a failure
  /// the caller must neither read from the instrument nor send to it.
  [[nodiscard]] Result<void> confirm(drivers::Identified& instrument);

  /// Makes `call`. Confirms the instrument before the call, and again after it if the connection broke meanwhile. If
  /// the instrument is not confirmed, returns the fault instead of the result.
  template <class Call>
  [[nodiscard]] std::invoke_result_t<Call&> guard(drivers::Identified& instrument, Call call) {
    if (auto same = confirm(instrument); !same) return failure(std::move(same.error()));
    auto answer = call();
    note_result(answer ? nullptr : &answer.error());
    if (!answer) return answer;
    if (auto same = confirm(instrument); !same) return failure(std::move(same.error()));
    return answer;
  }

  /// Makes `call`, which must make the instrument safe. Unlike guard(), also makes it if the known instrument answers
  /// with other settings.
  template <class Call>
  [[nodiscard]] std::invoke_result_t<Call&> guard_safe(drivers::Identified& instrument, Call call) {
    if (auto same = confirm(instrument); !same && !is_known_by_name(instrument))
      return failure(std::move(same.error()));
    auto answer = call();
    note_result(answer ? nullptr : &answer.error());
    return answer;
  }

  /// Returns whether commands may be sent although `fault` prevented the last call: the instrument was identified when
  /// the run began, its answers since cannot be understood or are missing, and no other instrument has answered.
  [[nodiscard]] bool may_be_commanded_after(const Fault& fault) const;

  /// Records how a call ended: with the given fault, or successfully if null.
  void note_result(const Fault* fault);

  /// Requests a comparison before the next call.
  void request_check() { is_check_requested_ = true; }

  /// Describes the instrument that answered at the last comparison if it is not the known one. Returns an empty text if
  /// it is.
  [[nodiscard]] std::string mismatch_text() const;
  /// Returns the text of the fault of the last call that ended; empty if it succeeded. Any thread may call it.
  [[nodiscard]] std::string last_fault() const;

 private:
  [[nodiscard]] bool is_known_by_name(drivers::Identified& instrument) const;
  [[nodiscard]] Result<void> compare(drivers::Identified& instrument);
  void set_mismatch_text(std::string text);
  void set_last_fault(const Fault* fault);

  KnownIdentity known_;
  std::atomic<bool> is_check_requested_{};
  bool in_doubt_ = false;
  int silences_ = 0;  ///< unanswered calls in a row
  /// The instrument's count of broken connections at the last successful comparison. Valid if `has_begun_`.
  std::uint64_t breaks_ = 0;
  bool has_begun_ = false;
  mutable std::mutex mutex_;  ///< guards the members below
  std::string mismatch_text_;
  std::string last_fault_;
};

}  // namespace gyrotherm::io
