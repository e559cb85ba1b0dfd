// SPDX-License-Identifier: Apache-2.0
#include "sequencer/run/chamber_ownership.hpp"

#include <filesystem>

#include "drivers/line/line_address.hpp"

namespace gyrotherm::run {
namespace {

/// An exchange with the chamber ends in about this time; one that does not is a hang. With the 8 s of silence and the
/// 10 s of make-safe it makes the 20 s within which the chamber is safe.
constexpr Duration kLongestExchange = std::chrono::seconds(2);

watchdog::SafeState safe_state_for(const rig::RigFile& rig, const std::string& record, bool by_program) {
  std::error_code error;
  return {.record = std::filesystem::absolute(record, error).string(),
          .line = rig.chamber_line,
          .link = rig.chamber_map.link.kind,
          .word_order = rig.chamber_word_order,
          .safe_set_point = rig.safe_set_point,
          .switch_off = rig.safe_off,
          .by_program = by_program,
          .written_by = watchdog::own_identity(),
          .map_text = rig.chamber_map.text,
          .power = rig.chamber_power};
}

}  // namespace

std::string chamber_place(const rig::RigFile& rig) {
  const auto& link = rig.chamber_map.link.modbus;
  return chamber_place(drivers::parse_line(rig.chamber_line).value(), link.port, link.unit);
}

Result<ChamberOwnership> ChamberOwnership::take(const rig::RigFile& rig, const std::string& record, bool by_program) {
  ChamberOwnership ownership;
  if (rig.simulated) return ownership;
  ownership.safe_state_ = safe_state_for(rig, record, by_program);
  auto lock = drivers::ChamberLock::take(chamber_place(rig), ownership.safe_state_->record);
  if (!lock) return failure(lock.error());
  ownership.lock_ = std::move(*lock);
  return ownership;
}

Result<void> ChamberOwnership::arm(const std::string& identity) {
  if (!safe_state_) return {};
  safe_state_->identity = identity;
  auto line = watchdog::WatchdogClient::tie(*safe_state_);
  if (!line) return failure(line.error());
  watchdog_ = std::move(*line);
  return {};
}

void ChamberOwnership::heartbeat(Duration stuck) {
  if (watchdog_ && stuck <= kLongestExchange) watchdog_->heartbeat();
  if (lock_) lock_->dismiss_callers();
}

void ChamberOwnership::release() {
  if (watchdog_) watchdog_->good_bye();
  watchdog_.reset();
}

}  // namespace gyrotherm::run
