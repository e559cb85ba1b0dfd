#include "sequencer/run/chamber_ownership.hpp"

#include <filesystem>

#include "drivers/line/line_address.hpp"

namespace gyrotherm {
namespace {

/// An exchange with the chamber ends in about this time; one that does not is a hang. With the 8 s of silence and the
/// 10 s of make-safe it makes the 20 s within which the chamber is safe.
constexpr Duration kLongestExchange = std::chrono::seconds(2);

Armed armed_for(const RigFile& rig, const std::string& record, bool by_program) {
  std::error_code error;
  return {.record = std::filesystem::absolute(record, error).string(),
          .line = rig.chamber_line,
          .link = rig.chamber_map.link.kind,
          .word_order = rig.chamber_word_order,
          .safe_set_point = rig.safe_set_point,
          .switch_off = rig.safe_off,
          .by_program = by_program,
          .armed_by = own_identity(),
          .map_text = rig.chamber_map.text};
}

}  // namespace

std::string chamber_place(const RigFile& rig) {
  const auto& link = rig.chamber_map.link.modbus;
  return chamber_place(parse_line(rig.chamber_line).value(), link.port, link.unit);
}

Result<Custody> Custody::take(const RigFile& rig, const std::string& record, bool by_program) {
  Custody custody;
  if (rig.simulated) return custody;
  custody.armed_ = armed_for(rig, record, by_program);
  auto lock = ChamberLock::take(chamber_place(rig), custody.armed_->record);
  if (!lock) return failure(lock.error());
  custody.lock_ = std::move(*lock);
  return custody;
}

Result<void> Custody::arm() {
  if (!armed_) return {};
  auto line = LifeLine::tie(*armed_);
  if (!line) return failure(line.error());
  life_line_ = std::move(*line);
  return {};
}

void Custody::beat(Duration stuck) {
  if (life_line_ && stuck <= kLongestExchange) life_line_->beat();
  if (lock_) lock_->dismiss_callers();
}

void Custody::release() {
  if (life_line_) life_line_->good_bye();
  life_line_.reset();
}

}  // namespace gyrotherm
