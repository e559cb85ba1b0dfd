// SPDX-License-Identifier: Apache-2.0
#include "simulator/servers/gyro_server.hpp"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <utility>

namespace gyrotherm::simulator {
namespace {

/// Returns the value that a receiver reads after `value` was sent.
double received_value(const drivers::FrameField& field, double value) {
  const auto raw = invert_scale(field, value);
  if (is_word(field.type)) {
    const auto read = parse_token(field, print_token(field, raw));
    return read ? apply_scale(field, *read) : value;
  }
  if (field.type == drivers::FieldType::f32)
    return apply_scale(field, {.real = static_cast<float>(raw.real), .is_real = true});
  return apply_scale(field, raw);
}

/// Returns the frame's field for this value.
drivers::AxisReading make_reading(const drivers::FrameField& field, double value) {
  drivers::AxisReading reading{.value = value};
  if (!is_real(field.type)) reading.pulses = invert_scale(field, value).whole;
  return reading;
}

/// Returns the reading of a device that is configured to another unit of measure.
drivers::AxisReading rescale_reading(const drivers::FrameField& field, drivers::AxisReading reading, double factor) {
  const bool is_angle = field.role == drivers::FieldRole::increment || field.role == drivers::FieldRole::rate;
  if (!is_angle) return reading;
  if (reading.value) *reading.value *= factor;
  if (reading.pulses) reading.pulses = std::llround(static_cast<double>(*reading.pulses) * factor);
  return reading;
}

double wrap_angle(double angle, double wraps_at) { return angle - wraps_at * std::floor(angle / wraps_at); }

constexpr double kDefaultTemperature = 25;  // °C
constexpr std::size_t kMostReceived = 1024;
constexpr const char* kReplyEnd = "\r\n";

std::span<const std::byte> text_bytes(const std::string& text) { return std::as_bytes(std::span(text)); }

}  // namespace

drivers::FrameFormat slow_to_one_frame_per_second(drivers::FrameFormat format) {
  if (format.rate_hz > 0) format.rate_hz = 1;
  return format;
}

StreamWriter::StreamWriter(drivers::FrameFormat format, std::vector<double> arcsec_per_pulse)
    : format_(std::move(format)) {
  const auto gyros = format_.gyros();
  assert(!gyros.empty() && gyros.size() == arcsec_per_pulse.size());
  for (std::size_t i = 0; i < gyros.size(); ++i)
    axes_.push_back({.field = *gyros[i],
                     .arcsec_per_pulse = arcsec_per_pulse[i],
                     .arcsec_per_unit = arcsec_per(gyros[i]->unit, gyros[i]->role).value_or(0)});
  for (const auto* field : format_.values())
    default_values_.push_back(field->role == drivers::FieldRole::temperature ? kDefaultTemperature : 0);
}

/// Returns the sequence number of a frame. `number` may be before the first frame.
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
  for (const auto& axis : axes_) frame.axes.push_back(make_reading(axis.field, 0));
  frame.values.assign(default_values_.begin(), default_values_.end());
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

/// Returns the reading of an integer field: pulses, or an angle in steps of the field's resolution.
drivers::AxisReading StreamWriter::put_counts(double pulses, Axis& axis) {
  const double counts =
      axis.arcsec_per_unit != 0 ? pulses * axis.arcsec_per_pulse / axis.field.scale.of(axis.arcsec_per_unit) : pulses;
  const auto total = static_cast<std::int64_t>(std::floor(counts));
  const auto before = std::exchange(axis.counts, total);
  return {.pulses = axis.field.role == drivers::FieldRole::increment ? total - before : total};
}

drivers::AxisReading StreamWriter::put_angle(double pulses, double seconds, Axis& axis) {
  const auto& field = axis.field;
  const double angle = pulses * axis.arcsec_per_pulse / axis.arcsec_per_unit;
  double value = field.role == drivers::FieldRole::rate ? (angle - axis.angle) / seconds : angle - axis.angle;
  if (field.role == drivers::FieldRole::integrated_angle)
    value = field.wraps_at > 0 ? wrap_angle(angle, field.wraps_at) : angle;
  const double read = received_value(field, value);
  if (field.role == drivers::FieldRole::rate) axis.angle += read * seconds;
  if (field.role == drivers::FieldRole::increment) axis.angle += read;
  return make_reading(field, value);
}

std::vector<std::byte> StreamWriter::next(std::span<const double> pulses, std::int64_t device_time_us, double seconds,
                                          std::span<const double> values) {
  assert(pulses.size() == axes_.size() && values.size() <= default_values_.size());
  auto one = frame(number_++, device_time_us);
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    auto reading =
        is_counted(axes_[i].field) ? put_counts(pulses[i], axes_[i]) : put_angle(pulses[i], seconds, axes_[i]);
    one.axes[i] = factor_ == 1 ? reading : rescale_reading(axes_[i].field, reading, factor_);
  }
  for (std::size_t i = 0; i < values.size(); ++i)
    if (std::isfinite(values[i])) one.values[i] = values[i];
  auto bytes = encode_frame(format_, one);
  bytes.insert(bytes.end(), format_.tail.begin(), format_.tail.end());
  return bytes;
}

void StreamWriter::skip(std::span<const double> pulses) {
  assert(pulses.size() == axes_.size());
  ++number_;
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    if (is_counted(axes_[i].field))
      (void)put_counts(pulses[i], axes_[i]);
    else
      axes_[i].angle = pulses[i] * axes_[i].arcsec_per_pulse / axes_[i].arcsec_per_unit;
  }
}

GyroServer::GyroServer(Descriptor listener, StreamWriter writer, std::vector<drivers::GyroCommand> commands,
                       GyroUnitFaults faults)
    : listener_(std::move(listener)),
      writer_(std::move(writer)),
      commands_(std::move(commands)),
      faults_(std::move(faults)) {
  std::erase_if(commands_, [](const auto& command) { return !requires_answer(command); });
  writer_.set_factor(faults_.factor);
}

void GyroServer::set_powered(bool on) {
  is_powered_ = on;
  if (!on) is_silent_ = false;
}

void GyroServer::add(Pty line) { lines_.push_back({std::move(line)}); }

/// Executes a command and returns the answer.
std::string GyroServer::execute(const drivers::GyroCommand& command) {
  const auto name = drivers::command_name(command);
  const auto is_among = [&](const auto& names) { return std::ranges::find(names, name) != names.end(); };
  if (is_among(faults_.ignored)) return {};
  const std::string end = command.is_binary ? "" : kReplyEnd;
  if (is_among(faults_.refused)) return command.refusal + end;
  if (name == faults_.factor_until) writer_.set_factor(1);
  is_silent_ = command.then_silent.value_or(is_silent_);
  if (command.messages.empty()) return command.reply + end;
  const auto bytes = encode_settings(writer_.format(), command.messages.front(), faults_.has_other_settings);
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

/// Returns the answers to the new bytes, in the order of the commands in the description.
std::string GyroServer::replies(std::span<const char> bytes, std::string& received) {
  if (!is_powered_) return {};
  received.append(bytes.data(), bytes.size());
  std::string answer;
  for (bool found = true; found;) {
    found = false;
    for (const auto& command : commands_) {
      const auto at = received.find(command.send);
      if (at == std::string::npos) continue;
      answer += execute(command);
      received.erase(0, at + command.send.size());
      found = true;
    }
  }
  if (received.size() > kMostReceived) received.erase(0, received.size() - kMostReceived);
  return answer;
}

std::string GyroServer::replies(int descriptor, std::string& received) {
  std::array<char, kMostReceived> buffer{};
  const auto size = ::read(descriptor, buffer.data(), buffer.size());
  return size <= 0 ? std::string{} : replies(std::span(buffer).first(static_cast<std::size_t>(size)), received);
}

void GyroServer::admit(Descriptor client) {
  if (clients_.size() < kMaxClients && send_now(client, writer_.lead_in())) clients_.push_back({std::move(client)});
}

std::shared_ptr<MemoryConnection> GyroServer::connect() {
  auto& client = local_clients_.emplace_back(LocalClient{std::make_shared<MemoryConnection>()});
  send_to(client, writer_.lead_in());
  return client.connection;
}

/// Sends bytes to a client. Closes the connection if it does not accept them.
void GyroServer::send_to(LocalClient& client, std::span<const std::byte> bytes) {
  client.connection->open = client.connection->open && client.connection->to_client.put(bytes);
}

void GyroServer::serve_clients() {
  if (listener_.is_open())
    for (auto client = accept_client(listener_); client.is_open(); client = accept_client(listener_))
      admit(std::move(client));
  std::erase_if(local_clients_, [](const LocalClient& client) {
    return !client.connection->open || client.connection.use_count() == 1;
  });
  if (commands_.empty()) return;
  for (auto& client : clients_)
    if (const auto answer = replies(client.socket.number(), client.received); !answer.empty())
      (void)send_now(client.socket, text_bytes(answer));
  for (auto& line : lines_)
    if (const auto answer = replies(line.pty.ours.number(), line.received); !answer.empty())
      send_now(line.pty, text_bytes(answer));
  for (auto& client : local_clients_) {
    std::array<std::byte, kMostReceived> buffer{};
    const auto size = client.connection->to_instrument.take(buffer);
    if (size == 0) continue;
    const std::span said(reinterpret_cast<const char*>(buffer.data()), size);
    send_to(client, text_bytes(replies(said, client.received)));
  }
}

void GyroServer::send(std::span<const double> pulses, std::int64_t device_time_us, double seconds,
                      std::span<const double> values) {
  serve_clients();
  if (is_silent_ || (clients_.empty() && lines_.empty() && local_clients_.empty())) return skip(pulses);
  const auto bytes = writer_.next(pulses, device_time_us, seconds, values);
  std::erase_if(clients_, [&](const Client& client) { return !send_now(client.socket, bytes); });
  for (const auto& line : lines_) send_now(line.pty, bytes);
  for (auto& client : local_clients_) send_to(client, bytes);
}

}  // namespace gyrotherm::simulator
