// SPDX-License-Identifier: Apache-2.0
#include "tests/sequencer/faults/chamber_port.hpp"

#include <algorithm>
#include <cmath>

#include "drivers/chamber/register_item.hpp"
#include "drivers/line/modbus_frame.hpp"

namespace gyrotherm::faults {
namespace {

constexpr std::size_t kTcpFunctionAt = 7, kRtuFunctionAt = 1, kTcpUnitAt = 6, kTcpHeader = 8;
constexpr std::uint8_t kLastReadFunction = 4;

}  // namespace

ChamberPort::ChamberPort(simulator::ChamberRegisters& registers, simulator::VirtualLaboratory& laboratory,
                         const Clock& rig, std::uint64_t seed)
    : registers_(registers),
      laboratory_(laboratory),
      set_point_(*registers.map().find("set_point")),
      session_(make_modbus_session(registers)),
      line_(
          rig, seed, [this](auto frame, Bytes& bytes) { answer(frame, bytes); }, garble_burst) {}

std::optional<Celsius> ChamberPort::set_point_in(const drivers::ModbusRequest& request) const {
  if (request.address != set_point_.address || request.words.size() != word_count(set_point_)) return std::nullopt;
  return Celsius{decode_as_written(set_point_, request.words)};
}

bool ChamberPort::shows_set_point(const drivers::ModbusRequest& request) const {
  return request.address <= set_point_.address &&
         request.address + request.count >= set_point_.address + word_count(set_point_);
}

bool ChamberPort::is_identity_request(const drivers::ModbusRequest& request) const {
  const auto& map = registers_.map();
  const auto is = [&](const drivers::RegisterItem& item) {
    return request.address == item.address && request.count == word_count(item);
  };
  return is_read(request.function) && map.identity &&
         (is(*map.find(map.identity->item)) || is(*map.find("air_temperature")));
}

/// Checks that the next request after each set point reads it back. Ignores identity requests, which follow a
/// reconnection. A set point without an acknowledgement may be repeated. A refused one need not be read back before
/// another command, such as one that switches the chamber off. The line may lose the request that reads it back.
void ChamberPort::note(const drivers::ModbusRequest& request) {
  if (is_identity_request(request)) return;
  const auto sent = is_read(request.function) ? std::nullopt : set_point_in(request);
  const bool is_another = sent && to_be_read_back_ && abs(*sent - *to_be_read_back_) >= Kelvins{1e-3};
  const bool reads_back = is_read(request.function) && shows_set_point(request);
  const bool commands_after_refusal = !is_read(request.function) && is_refused_;
  const bool may_be_lost = line_.lost_requests() > lost_before_;
  if (to_be_read_back_ && !sent && !reads_back && !commands_after_refusal && !may_be_lost) ++not_read_back_;
  to_be_read_back_ = sent;
  lost_before_ = line_.lost_requests();
  is_refused_ = trouble.exception != 0;
  if (sent) sent_.push_back({*sent, !trouble.ignores_writes && !is_refused_, is_another});
}

void ChamberPort::clamp() {
  const auto limit = trouble.clamps_at->value;
  if (std::abs(laboratory_.set_point().value) > limit)
    laboratory_.change_set_point({std::copysign(limit, laboratory_.set_point().value)});
}

void ChamberPort::corrupt(Bytes& answer) {
  if (answer.empty()) return;
  if (trouble.wrong_number && is_tcp()) answer[1] ^= std::byte{0x01};
  if (!trouble.foreign_unit) return;
  answer[is_tcp() ? kTcpUnitAt : 0] ^= std::byte{0x02};
  if (is_tcp()) return;
  answer.resize(answer.size() - 2);
  drivers::append_rtu_crc(answer);
}

void ChamberPort::answer(std::span<const std::byte> frame, Bytes& answer) {
  ++exchanges_;
  const auto function = drivers::byte_at(frame, is_tcp() ? kTcpFunctionAt : kRtuFunctionAt);
  const bool writes = function > kLastReadFunction;
  if (writes && trouble.exchanged) ++sent_to_another_;
  std::optional<drivers::ModbusRequest> request;
  if (writes || to_be_read_back_)
    if (auto decoded = is_tcp() ? drivers::decode_request(frame) : drivers::decode_rtu_request(frame))
      request = std::move(*decoded);
  if (request) note(*request);
  if (trouble.exception != 0 && (writes || !trouble.only_writes)) {
    answer = is_tcp() ? drivers::encode_exception(frame, trouble.exception)
                      : drivers::encode_rtu_exception(frame, trouble.exception);
  } else if (writes && request && trouble.ignores_writes) {
    answer = is_tcp() ? encode_reply(*request, {}) : encode_rtu_reply(*request, {});
  } else {
    if (!session_->feed(frame, answer)) session_ = make_modbus_session(registers_);
    if (writes && trouble.clamps_at) clamp();
  }
  corrupt(answer);
}

Result<void> MemoryConnection::open(Duration within) {
  if (port_.line().trouble.gone) return failure(FaultKind::disconnected, "", "no connection: Connection refused");
  if (port_.trouble.half_open) {
    port_.line().line_clock().pass(within);
    return failure(FaultKind::disconnected, "", "no connection: Connection refused");
  }
  open_ = true;
  return {};
}

Result<void> MemoryConnection::send(std::span<const std::byte> frame) {
  auto& line = port_.line();
  const auto& trouble = line.trouble;
  if (trouble.gone) return failure(FaultKind::disconnected, "", "connection lost: Connection reset by peer");
  const auto loss = line.loss();
  if (trouble.silent || port_.trouble.half_open || loss == LineEnd::Loss::of_request) return {};
  answer_.clear();
  port_.answer(frame, answer_);
  if (answer_.empty() || trouble.answers_lost || loss == LineEnd::Loss::of_answer) return {};
  if (line.draw_event(trouble.garbled))
    answer_[line.random()() % kTcpHeader] ^= std::byte{0x40};  // TCP protects the remaining bytes
  const bool cut = line.draw_event(trouble.cut);
  const auto at = line.line_clock().time() + trouble.late;
  coming_.push_back({at, answer_, cut});
  if (line.draw_event(trouble.doubled)) coming_.push_back({at, answer_, false});
  return {};
}

Result<std::size_t> MemoryConnection::receive(std::span<std::byte> frame, Duration within) {
  auto& line_clock = port_.line().line_clock();
  if (port_.line().trouble.gone)
    return failure(FaultKind::disconnected, "", "connection lost: Connection reset by peer");
  if (coming_.empty() || coming_.front().at > line_clock.time() + within || coming_.front().cut) {
    line_clock.pass(within);
    return failure(FaultKind::timeout, "", "no reply");
  }
  if (const auto wait = coming_.front().at - line_clock.time(); wait > Duration::zero()) line_clock.pass(wait);
  const auto& bytes = coming_.front().frame;
  const auto size = std::min(frame.size(), bytes.size());
  std::copy_n(bytes.begin(), size, frame.begin());
  coming_.pop_front();
  return size;
}

bool MemoryConnection::is_silent_for(Duration time) {
  auto& line_clock = port_.line().line_clock();
  if (!coming_.empty() && coming_.front().at <= line_clock.time() + time) return false;
  line_clock.pass(time);
  return true;
}

}  // namespace gyrotherm::faults
