// SPDX-License-Identifier: Apache-2.0
#include "tests/sequencer/faults/operators.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>

#include "tests/sequencer/faults/invariants.hpp"

namespace gyrotherm::faults {

namespace {

/// Returns the minimum severity of the state after a command.
int least_severity(control::OperatorCommand command) {
  switch (command) {
    case control::OperatorCommand::resume: return severity(RunState::execute);
    case control::OperatorCommand::pause: return severity(RunState::held);
    case control::OperatorCommand::stop:
    case control::OperatorCommand::abort: return severity(RunState::aborting);
  }
  return 0;
}

}  // namespace

/// Submits a request. If the run controller does not refuse it, it has promised to carry it out. If there are several
/// promises, only the most severe one must be kept.
void Operators::submit(control::OperatorCommand command, run::RunController& run_controller) {
  if (!run_controller.refusal_reason(command).empty()) return;
  run_controller.submit(command, "operator");
  promised_ = std::max(promised_.value_or(command), command);
}

void Operators::submit(const InjectedFault& fault, run::RunController& run_controller, std::int64_t second) {
  constexpr int kCommands = 4;
  switch (fault.kind) {
    case InjectedFaultKind::operator_pauses:
      resumes_at_ = second + fault.lasts;
      return submit(control::OperatorCommand::pause, run_controller);
    case InjectedFaultKind::operator_stops: return submit(control::OperatorCommand::stop, run_controller);
    case InjectedFaultKind::operator_aborts: return submit(control::OperatorCommand::abort, run_controller);
    case InjectedFaultKind::operators_at_once:
      for (int which = static_cast<int>(fault.size); which > 0; which /= kCommands)
        submit(static_cast<control::OperatorCommand>(which % kCommands), run_controller);
      return;
    default: return;
  }
}

bool Operators::has_dropped(const std::string& unit) const {
  return std::ranges::any_of(returns_at_, [&](const auto& one) { return one.first == unit; });
}

void Operators::drop(const std::string& unit, std::int64_t lasts, run::RunController& run_controller,
                     std::int64_t second) {
  const control::ControlRequest request{.note = "it came to grief",
                                        .unit = control::UnitRequest{.drop = true, .unit = unit}};
  if (run_controller.carry_out(request, "operator").done) returns_at_.emplace_back(unit, second + lasts);
}

void Operators::resume_after_wait(run::RunController& run_controller, std::int64_t second) {
  std::erase_if(returns_at_, [&](const auto& one) {
    const control::ControlRequest request{.unit = control::UnitRequest{.drop = false, .unit = one.first}};
    return second >= one.second && run_controller.carry_out(request, "operator").done;
  });
  if (run_controller.run_state() != RunState::held) {
    resumes_at_.reset();
    return;
  }
  if (!resumes_at_) resumes_at_ = second + kOperatorComesAfter;
  if (second < *resumes_at_) return;
  submit(control::OperatorCommand::resume, run_controller);
  resumes_at_ = second + kOperatorComesAfter;
}

std::optional<std::string> Operators::broken_promise(RunState state) {
  const auto promised = std::exchange(promised_, std::nullopt);
  if (!promised || severity(state) >= least_severity(*promised)) return {};
  return fmt::format("{} was promised, and the run is in state {}", name(*promised), name(state));
}

namespace {

/// So long that the messages of an hour exceed the memory of an outlet.
constexpr std::size_t kLongMessage = 1000;
constexpr int kLongestSilence = 2000;  ///< ms

}  // namespace

Listener::Listener() {
  int ends[2];
  if (::pipe2(ends, O_CLOEXEC) != 0) return;
  reader_ = Descriptor(ends[0]);
  writer_ = Descriptor(ends[1]);
  outlet_ = std::make_unique<app::Outlet>(writer_.number());
  outlet_->never_wait();
}

/// Writes "#12 0#": the twelfth message, and no message was dropped before it.
void Listener::write_second() {
  outlet_->write_lines([&](std::size_t dropped) {
    return fmt::format("#{} {}#{}\n", last_written_ + 1, dropped, std::string(kLongMessage, '.'));
  });
  ++last_written_;
  outlet_->draw({fmt::format("{} s", last_written_)});
}

void Listener::take(const char* bytes, std::size_t size) {
  for (const char c : std::string_view(bytes, size)) {
    if (c != '#') {
      if (in_number_) number_ += c;
      continue;
    }
    in_number_ = !in_number_;
    if (in_number_) continue;
    std::int64_t number = 0, dropped = 0;
    const auto* end = number_.data() + number_.size();
    const auto first = std::from_chars(number_.data(), end, number);
    std::from_chars(first.ptr + 1, end, dropped);
    if (number != last_read_ + dropped + 1 && !missing_)
      missing_ = fmt::format("message {} follows {}, and reports {} dropped messages", number, last_read_, dropped);
    last_read_ = number;
    number_.clear();
  }
}

bool Listener::wait_for_output(int milliseconds) {
  pollfd waiting{reader_.number(), POLLIN, 0};
  if (::poll(&waiting, 1, milliseconds) <= 0) return false;
  char bytes[1 << 16];
  const auto size = ::read(reader_.number(), bytes, sizeof bytes);
  if (size > 0) take(bytes, static_cast<std::size_t>(size));
  return size > 0;
}

void Listener::read() {
  while (wait_for_output(0)) continue;
}

std::optional<std::string> Listener::first_lost_message() {
  constexpr int kUntilQuiet = 20;  // ms
  while (wait_for_output(kUntilQuiet)) continue;
  // The outlet has memory again, and this message reports the drops before it.
  write_second();
  while (last_read_ < last_written_ && !missing_)
    if (!wait_for_output(kLongestSilence))
      missing_ = fmt::format("no message after {}, expected {}", last_read_, last_written_);
  return missing_;
}

}  // namespace gyrotherm::faults
