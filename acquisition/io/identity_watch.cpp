// SPDX-License-Identifier: Apache-2.0
#include "acquisition/io/identity_watch.hpp"

#include <fmt/format.h>

#include <utility>

namespace gyrotherm::io {
namespace {

/// The number of consecutive unanswered calls after which the instrument may have been exchanged. Exchanging an
/// instrument takes more seconds than this.
constexpr int kSilencesInDoubt = 3;
/// The number of attempts in one call. If the connection breaks during all of them, the next call tries again.
constexpr int kMaxTries = 3;

}  // namespace

Result<void> IdentityWatch::confirm(drivers::Identified& instrument) {
  if (known_.identity.empty()) return {};
  if (!std::exchange(has_begun_, true)) breaks_ = instrument.breaks();
  if (is_check_requested_.exchange(false)) in_doubt_ = true;
  if (!in_doubt_ && instrument.breaks() == breaks_) return {};
  in_doubt_ = true;
  auto same = compare(instrument);
  if (!same) set_last_fault(&same.error());
  return same;
}

bool IdentityWatch::may_be_commanded_after(const Fault& fault) const {
  const bool is_understood =
      fault.kind != FaultKind::timeout && fault.kind != FaultKind::corrupted && fault.kind != FaultKind::disconnected;
  return !known_.identity.empty() && !is_understood && mismatch_text().empty();
}

bool IdentityWatch::is_known_by_name(drivers::Identified& instrument) const {
  const auto found = instrument.recognise();
  return found && known_.identity.starts_with(*found);
}

/// Compares the instrument's identity with the known one. Repeats the query if the connection broke during it, because
/// the parts of the answer may then come from two instruments.
Result<void> IdentityWatch::compare(drivers::Identified& instrument) {
  for (int tries = 0; tries < kMaxTries; ++tries) {
    const auto before = instrument.breaks();
    const auto found = instrument.identify();
    const bool is_answer =
        found || found.error().kind == FaultKind::mismatch || found.error().kind == FaultKind::refused;
    if (!is_answer) return failure(found.error());
    if (instrument.breaks() != before) continue;
    if (found && *found == known_.identity) {
      set_mismatch_text("");
      breaks_ = before;
      in_doubt_ = false;
      silences_ = 0;
      return {};
    }
    auto what = fmt::format("another instrument, or other settings: {}; the run began with: {}",
                            found ? *found : text(found.error()), known_.identity);
    set_mismatch_text(fmt::format("{}: {}", known_.title, what));
    return failure(FaultKind::mismatch, known_.title, std::move(what));
  }
  return failure(FaultKind::disconnected, known_.title, "the connection broke during every query of its identity");
}

void IdentityWatch::note_result(const Fault* fault) {
  set_last_fault(fault);
  const bool is_silence =
      fault != nullptr && (fault->kind == FaultKind::timeout || fault->kind == FaultKind::corrupted);
  silences_ = is_silence ? silences_ + 1 : 0;
  const bool is_break =
      fault != nullptr && (fault->kind == FaultKind::disconnected || fault->kind == FaultKind::mismatch);
  in_doubt_ = in_doubt_ || is_break || silences_ >= kSilencesInDoubt;
}

std::string IdentityWatch::mismatch_text() const {
  const std::lock_guard lock(mutex_);
  return mismatch_text_;
}

std::string IdentityWatch::last_fault() const {
  const std::lock_guard lock(mutex_);
  return last_fault_;
}

void IdentityWatch::set_last_fault(const Fault* fault) {
  const std::lock_guard lock(mutex_);
  last_fault_ = fault != nullptr ? fault->what : "";
}

void IdentityWatch::set_mismatch_text(std::string text) {
  const std::lock_guard lock(mutex_);
  mismatch_text_ = std::move(text);
}

}  // namespace gyrotherm::io
