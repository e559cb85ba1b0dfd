// SPDX-License-Identifier: Apache-2.0
#include "sequencer/run/chamber_ownership.hpp"

#include <chrono>
#include <filesystem>

#include "core/deadline.hpp"
#include "drivers/line/line_address.hpp"
#include "drivers/line/pauses.hpp"
#include "sequencer/watchdog/safe_attempt.hpp"

namespace gyrotherm::run {
namespace {

/// Longest exchange with the chamber; a longer one is a hang. Together with 8 s of silence and 10 s for make-safe, the
/// chamber is safe within 20 s.
constexpr Duration kLongestExchange = std::chrono::seconds(2);

watchdog::SafeState safe_state_for(const rig::RigFile& rig, const std::string& record, bool by_program) {
  std::error_code error;
  return {.record = std::filesystem::absolute(record, error).string(),
          .line = rig.chamber_line,
          .link = rig.chamber_map.link.kind,
          .word_order = rig.chamber_word_order,
          .link_settings = rig.chamber_link,
          .parameters = rig.chamber_parameters,
          .safe_set_point = rig.safe_set_point,
          .switch_off = rig.safe_off,
          .by_program = by_program,
          .observe = rig.safe_observe,
          .written_by = watchdog::own_identity(),
          .map_text = rig.chamber_map.text,
          .power = rig.chamber_power,
          .also = rig.safe_also};
}

/// Longest time for which gyrotherm-make-safe holds the lock for one reading, while it watches the air of a chamber
/// that it has made safe.
constexpr Duration kLongestInspection = std::chrono::seconds(5);
constexpr auto kRetryEvery = std::chrono::milliseconds(50);

bool is_being_inspected(const rig::RigFile& rig, const Fault& why) {
  if (why.kind != FaultKind::refused) return false;
  const auto holder = drivers::ChamberLock::holder(chamber_lock_name(rig));
  return !holder || holder->words.ends_with(watchdog::kMadeSafeMark);
}

}  // namespace

std::string chamber_lock_name(const rig::RigFile& rig) {
  const auto& link = rig.chamber_map.link.modbus;
  return chamber_lock_name(drivers::parse_line(rig.chamber_line).value(), link.port, link.unit);
}

Result<ChamberOwnership> ChamberOwnership::take(const rig::RigFile& rig, const std::string& record, bool by_program) {
  ChamberOwnership ownership;
  if (rig.simulated) return ownership;
  ownership.place_ = chamber_lock_name(rig);
  ownership.safe_state_ = safe_state_for(rig, record, by_program);
  const auto pauses = drivers::make_real_pauses();
  auto lock = drivers::ChamberLock::take(chamber_lock_name(rig), ownership.safe_state_->record);
  for (const Deadline limit(kLongestInspection);
       !lock && is_being_inspected(rig, lock.error()) && !limit.has_passed();) {
    pauses->rest(kRetryEvery);
    lock = drivers::ChamberLock::take(chamber_lock_name(rig), ownership.safe_state_->record);
  }
  if (!lock) return failure(lock.error());
  ownership.lock_ = std::move(*lock);
  ownership.waiting_guards_ = watchdog::find_waiting_guards(ownership.place_);
  return ownership;
}

std::vector<std::string> ChamberOwnership::unauthorised_holders() const {
  std::vector<std::string> words;
  if (lock_)
    for (const auto& stranger : lock_->unauthorised_holders()) words.push_back(stranger.words);
  return words;
}

Result<void> ChamberOwnership::arm(const std::string& identity, const drivers::ControllerSettings& settings) {
  if (!safe_state_) return {};
  safe_state_->identity = identity;
  safe_state_->settings = settings;
  auto line = watchdog::WatchdogClient::start(*safe_state_, place_);
  if (!line) return failure(line.error());
  watchdog_ = std::move(*line);
  return {};
}

void ChamberOwnership::heartbeat(Duration stuck) {
  if (watchdog_ && stuck <= kLongestExchange) watchdog_->heartbeat();
  if (lock_) lock_->close_callers();
}

void ChamberOwnership::release() {
  if (watchdog_) watchdog_->end_watch();
  watchdog_.reset();
}

}  // namespace gyrotherm::run
