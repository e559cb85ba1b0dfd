// SPDX-License-Identifier: Apache-2.0
/// Compares an instrument with the one that a run began with, after everything that may have put another in its place:
/// a broken connection, a silence, or seconds in which nobody called it. One thread calls it, that of the instrument;
/// stranger() and doubt() any.
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

/// An instrument as it was known when the run began.
struct KnownAs {
  std::string title{};     ///< "chamber", "thermometer 2"
  std::string identity{};  ///< Identified::identify(); empty: not compared
};

class IdentityWatch {
 public:
  explicit IdentityWatch(KnownAs known) : known_(std::move(known)) {}

  /// Asks the instrument who it is where another may have taken its place. Fails with mismatch, naming both, if it has,
  /// or as identify() does: then nothing may be read from it or sent to it.
  [[nodiscard]] Result<void> confirm(drivers::Identified& instrument);

  /// Makes a call between two comparisons: before it where a reconnection or a silence was noticed, after it where the
  /// line broke meanwhile. A value of an instrument that is not confirmed is dropped.
  template <class Call>
  [[nodiscard]] std::invoke_result_t<Call&> guard(drivers::Identified& instrument, Call call) {
    if (auto same = confirm(instrument); !same) return failure(std::move(same.error()));
    auto answer = call();
    see(answer ? nullptr : &answer.error());
    if (!answer) return answer;
    if (auto same = confirm(instrument); !same) return failure(std::move(same.error()));
    return answer;
  }

  /// Makes a call that makes the instrument safe: also where it is the one that is known, with other settings.
  template <class Call>
  [[nodiscard]] std::invoke_result_t<Call&> guard_safe(drivers::Identified& instrument, Call call) {
    if (auto same = confirm(instrument); !same && !is_known_by_name(instrument))
      return failure(std::move(same.error()));
    auto answer = call();
    see(answer ? nullptr : &answer.error());
    return answer;
  }

  /// Takes note of how a call ended; null: with an answer.
  void see(const Fault* fault);

  /// Has the instrument compared before its next call.
  void doubt() { is_doubted_ = true; }

  /// Describes the instrument that answered in place of the expected one, when it was last asked; empty: none did.
  [[nodiscard]] std::string stranger() const;

 private:
  [[nodiscard]] bool is_known_by_name(drivers::Identified& instrument) const;
  [[nodiscard]] Result<void> compare(drivers::Identified& instrument);
  void set_stranger(std::string text);

  KnownAs known_;
  std::atomic<bool> is_doubted_{};
  bool in_doubt_ = false;
  int silences_ = 0;          ///< unanswered calls in a row
  std::uint64_t breaks_ = 0;  ///< when it was last confirmed
  bool has_begun_ = false;    ///< `breaks_` is known
  mutable std::mutex mutex_;  ///< guards the text
  std::string stranger_text_;
};

}  // namespace gyrotherm::io
