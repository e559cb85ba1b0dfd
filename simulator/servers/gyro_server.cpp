// SPDX-License-Identifier: Apache-2.0
#include "simulator/servers/gyro_server.hpp"

#include <unistd.h>

#include <array>
#include <cassert>
#include <cmath>
#include <utility>

namespace gyrotherm::simulator {
namespace {

/// What the other end reads where `value` was sent.
double as_sent(const drivers::FrameField& field, double value) {
  const auto raw = unscaled(field, value);
  if (is_word(field.type)) {
    const auto read = parse_word(field, print_word(field, raw));
    return read ? scaled(field, *read) : value;
  }
  if (field.type == drivers::FieldType::f32)
    return scaled(field, {.real = static_cast<float>(raw.real), .is_real = true});
  return scaled(field, raw);
}

double wrapped(double angle, double wraps_at) { return angle - wraps_at * std::floor(angle / wraps_at); }

constexpr std::size_t kMostHeard = 1024;
constexpr const char* kReplyEnd = "\r\n";

std::span<const std::byte> bytes_of(const std::string& text) { return std::as_bytes(std::span(text)); }

}  // namespace

drivers::FrameFormat at_one_frame_a_second(drivers::FrameFormat format) {
  if (format.rate_hz > 0) format.rate_hz = 1;
  return format;
}

StreamWriter::StreamWriter(drivers::FrameFormat format, double arcsec_per_pulse)
    : format_(std::move(format)), arcsec_per_pulse_(arcsec_per_pulse) {
  assert(format_.gyro() != nullptr);
}

/// Of the frame numbered `number`, which may be before the first.
std::uint32_t StreamWriter::sequence(std::int64_t number) const {
  const auto* field = format_.find(drivers::FieldRole::sequence);
  const auto steps = number * static_cast<std::int64_t>(field ? field->step : 1);
  const auto range = static_cast<std::int64_t>(field && field->range != 0 ? field->range : 1ull << 32);
  return static_cast<std::uint32_t>((steps % range + range) % range);
}

drivers::GyroFrame StreamWriter::frame(std::int64_t number, std::int64_t device_time_us) const {
  drivers::GyroFrame frame{.sequence = sequence(number)};
  const auto* time = format_.find(drivers::FieldRole::timestamp);
  const double unit_us = time ? time->unit_s * 1e6 : 1;
  frame.timestamp = static_cast<std::uint64_t>(std::llround(static_cast<double>(device_time_us) / unit_us));
  frame.gyro = 0;
  if (!is_real(format_.gyro()->type)) frame.pulses = unscaled(*format_.gyro(), 0).whole;
  frame.temperature = 25;
  return frame;
}

std::vector<std::byte> StreamWriter::lead_in() const {
  if (format_.line) {
    const auto bytes = std::as_bytes(std::span(format_.line->terminator));
    return {bytes.begin(), bytes.end()};
  }
  std::vector<std::byte> bytes;
  for (auto before = static_cast<std::int64_t>(format_.lock_frames); before > 0; --before) {
    const auto one = encode_frame(format_, frame(number_ - before, 0));
    bytes.insert(bytes.end(), one.begin(), one.end());
    bytes.insert(bytes.end(), format_.tail.begin(), format_.tail.end());
  }
  return bytes;
}

/// Whole counts, or whole parts of an angle.
void StreamWriter::put_counts(double pulses, drivers::GyroFrame& frame) {
  const auto& field = *format_.gyro();
  const auto unit = arcsec_per(field.unit, field.role);
  const double counts = unit ? pulses * arcsec_per_pulse_ / field.scale.of(*unit) : pulses;
  const auto total = static_cast<std::int64_t>(std::floor(counts));
  frame.pulses = field.role == drivers::FieldRole::increment ? total - sent_counts_ : total;
  sent_counts_ = total;
}

void StreamWriter::put_angle(double pulses, double seconds, drivers::GyroFrame& frame) {
  const auto& field = *format_.gyro();
  const double angle = pulses * arcsec_per_pulse_ / arcsec_per(field.unit, field.role).value_or(1);
  double value = field.role == drivers::FieldRole::rate ? (angle - sent_) / seconds : angle - sent_;
  if (field.role == drivers::FieldRole::integrated_angle)
    value = field.wraps_at > 0 ? wrapped(angle, field.wraps_at) : angle;
  const double read = as_sent(field, value);
  if (field.role == drivers::FieldRole::rate) sent_ += read * seconds;
  if (field.role == drivers::FieldRole::increment) sent_ += read;
  frame.gyro = value;
  if (!is_real(field.type)) frame.pulses = unscaled(field, value).whole;
}

std::vector<std::byte> StreamWriter::next(double pulses, std::int64_t device_time_us, double seconds) {
  auto one = frame(number_++, device_time_us);
  if (is_counted(*format_.gyro()))
    put_counts(pulses, one);
  else
    put_angle(pulses, seconds, one);
  auto bytes = encode_frame(format_, one);
  bytes.insert(bytes.end(), format_.tail.begin(), format_.tail.end());
  return bytes;
}

void StreamWriter::skip(double pulses) {
  const auto& field = *format_.gyro();
  ++number_;
  drivers::GyroFrame nobody;
  if (is_counted(field))
    put_counts(pulses, nobody);
  else
    sent_ = pulses * arcsec_per_pulse_ / arcsec_per(field.unit, field.role).value_or(1);
}

GyroServer::GyroServer(Descriptor listener, StreamWriter writer, std::vector<drivers::GyroCommand> commands)
    : listener_(std::move(listener)), writer_(std::move(writer)), commands_(std::move(commands)) {
  std::erase_if(commands_, [](const auto& command) { return command.reply.empty(); });
}

void GyroServer::add(Pty line) { lines_.push_back({std::move(line)}); }

/// Answers to what has come since; a description's commands are answered in the order in which they were heard.
std::string GyroServer::replies(int descriptor, std::string& heard) const {
  std::array<char, kMostHeard> buffer{};
  const auto size = ::read(descriptor, buffer.data(), buffer.size());
  if (size <= 0) return {};
  heard.append(buffer.data(), static_cast<std::size_t>(size));
  std::string answer;
  for (bool found = true; found;) {
    found = false;
    for (const auto& command : commands_) {
      const auto at = heard.find(command.send);
      if (at == std::string::npos) continue;
      answer += command.reply + kReplyEnd;
      heard.erase(0, at + command.send.size());
      found = true;
    }
  }
  if (heard.size() > kMostHeard) heard.erase(0, heard.size() - kMostHeard);
  return answer;
}

void GyroServer::attend() {
  for (auto client = accept_client(listener_); client.is_open(); client = accept_client(listener_))
    if (clients_.size() < kMostClients && send_now(client, writer_.lead_in())) clients_.push_back({std::move(client)});
  if (commands_.empty()) return;
  for (auto& client : clients_)
    if (const auto answer = replies(client.socket.number(), client.heard); !answer.empty())
      (void)send_now(client.socket, bytes_of(answer));
  for (auto& line : lines_)
    if (const auto answer = replies(line.pty.ours.number(), line.heard); !answer.empty())
      send_now(line.pty, bytes_of(answer));
}

void GyroServer::send(double pulses, std::int64_t device_time_us, double seconds) {
  attend();
  if (clients_.empty() && lines_.empty()) return skip(pulses);
  const auto bytes = writer_.next(pulses, device_time_us, seconds);
  std::erase_if(clients_, [&](const Client& client) { return !send_now(client.socket, bytes); });
  for (const auto& line : lines_) send_now(line.pty, bytes);
}

}  // namespace gyrotherm::simulator
