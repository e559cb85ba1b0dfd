// SPDX-License-Identifier: Apache-2.0
#include "apps/monitor/notifier.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "apps/monitor/deliver.hpp"
#include "apps/monitor/state_folder.hpp"
#include "core/text.hpp"
#include "sequencer/control/control_socket.hpp"

namespace gyrotherm::monitor {
namespace {

constexpr Duration kMonitorCheckInterval = std::chrono::seconds(20), kMonitorTimeout = std::chrono::seconds(10);

/// Shortens a note to the limit of a control request, at the end of a character. Replaces control characters by blanks.
std::string shorten_note(std::string note) {
  std::ranges::replace_if(
      note, [](unsigned char c) { return c < ' ' || c == 0x7F; }, ' ');
  note.resize(std::min(note.size(), control::kLongestNote / 2));
  while (!is_utf8(note)) note.pop_back();
  return note;
}

ObservedRun observe_run(const FoundRun& run) {
  const auto state = std::string(name(run.status.overview.state));
  const bool has_ended = !run.is_running();
  ObservedRun observed{.id = run.status.id + "@" + run.path,
                       .name = run.name,
                       .record = run.path,
                       .rig = run.info ? run.info->rig_name : std::string(),
                       .simulated = run.status.simulated,
                       .virtual_rig = is_in_virtual_time(run.status),
                       .running = run.is_running(),
                       .silent = run.is_silent() || run.is_abandoned(),
                       .outcome = !has_ended                    ? ""
                                  : run.status.ended_by.empty() ? state
                                                                : run.status.ended_by,
                       .alarms = {},
                       .free_bytes = has_ended ? std::nullopt : run.free_bytes};
  for (const auto& alarm : run.status.alarms)
    if (alarm.awaits_acknowledgement()) observed.alarms.push_back({alarm.number, alarm.text});
  return observed;
}

}  // namespace

Notifier::Notifier(Site site, std::string memory_file, const RunCatalogue& catalogue, const Clock& clock,
                   std::function<void(const Fault&)> report_fault)
    : site_(std::move(site)),
      memory_file_(std::move(memory_file)),
      catalogue_(catalogue),
      clock_(clock),
      report_fault_(std::move(report_fault)) {}

Result<void> Notifier::load() {
  const auto text = read_private_file(memory_file_);
  if (!text) return failure(text.error());
  if (!*text) return {};
  auto memory = NotificationMemory::parse(**text, memory_file_);
  if (!memory) return failure(memory.error());
  memory_ = std::move(*memory);
  return {};
}

Situation Notifier::observe_situation() {
  Situation now;
  for (const auto& run : catalogue_.runs())
    if (run.read_error.empty()) now.runs.push_back(observe_run(run));
  if (clock_.now().since_start - monitors_checked_at_ >= kMonitorCheckInterval) {
    monitors_checked_at_ = clock_.now().since_start;
    for (const auto& rule : site_.rules)
      if (!rule.monitor.empty())
        responding_monitors_[rule.monitor] = is_monitor_responding(rule.monitor, kMonitorTimeout);
  }
  now.responding_monitors = responding_monitors_;
  return now;
}

/// Delivers a message, adds a note to the record, and saves the memory, in this order. If the monitor is killed before
/// the memory is saved, the message is sent again, and the record contains both notes. No note is added to the record
/// of an ended or silent run: no program would accept it, and the folder of a silent run may block.
void Notifier::send_message(const DueMessage& message) {
  const auto address = std::ranges::find(site_.addresses, message.address, &NotifyAddress::name);
  if (address == site_.addresses.end()) return;
  const auto utc = clock_.now().utc;
  const NotificationText notification{
      .subject = message.subject,
      .text = fmt::format("{}\n\n{}\nrule \"{}\"", message.text, message.subject, message.rule)};
  const auto delivered = deliver(site_, *address, notification, utc);
  if (!delivered) {
    memory_.record_failure(message, utc);
    report_fault_({delivered.error().kind,
                   fmt::format("\"{}\" could not be notified (rule \"{}\")", message.address, message.rule),
                   text(delivered.error())});
  } else {
    memory_.record_delivery(message, utc);
  }
  const auto accepts_note = [&](const FoundRun& run) { return run.path == message.record && !run.is_silent(); };
  if (std::ranges::any_of(catalogue_.runs(), accepts_note)) {
    const auto alarm_text = message.alarm ? fmt::format(" of alarm {}", *message.alarm) : std::string();
    auto note =
        fmt::format("{} {}{}, by rule \"{}\": {}", message.address,
                    delivered ? "was notified" : "could not be notified", alarm_text, message.rule, message.text);
    (void)control::send_request(message.record, {.note = shorten_note(std::move(note)), .told = true}, kSecond);
  }
  save();
}

void Notifier::save() {
  auto text = memory_.to_text();
  if (text == saved_text_) return;
  const auto written = write_private_file(memory_file_, text);
  if (written) saved_text_ = std::move(text);
  if (!written && !has_save_failed_) report_fault_(written.error());
  has_save_failed_ = !written;
}

void Notifier::notify_due() {
  const auto due = due_messages(site_, observe_situation(), clock_.now().utc, memory_);
  save();
  for (const auto& message : due) send_message(message);
}

}  // namespace gyrotherm::monitor
