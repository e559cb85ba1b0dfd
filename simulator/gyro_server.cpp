#include "simulator/gyro_server.hpp"

#include <cmath>
#include <utility>

namespace gyrotherm {

GyroServer::GyroServer(Socket listener, FrameFormat format)
    : listener_(std::move(listener)), format_(std::move(format)) {}

void GyroServer::send(std::int64_t pulses, std::int64_t device_time_us) {
  admit_all();
  if (!clients_.empty()) {
    const auto bytes = frame(pulses, device_time_us);
    std::erase_if(clients_, [&](const Socket& client) { return !send_now(client, bytes); });
  }
  skip(pulses);
}

std::vector<std::byte> GyroServer::frame(std::int64_t pulses, std::int64_t device_time_us) const {
  const auto* timestamp = format_.find(FieldRole::timestamp);
  const double unit_us = timestamp ? timestamp->unit_s * 1e6 : 1;
  const bool increment = format_.find(FieldRole::increment) != nullptr;
  return encode_frame(format_, {.pulses = increment ? pulses - sent_pulses_ : pulses,
                                .sequence = sequence_,
                                .timestamp = std::llround(static_cast<double>(device_time_us) / unit_us)});
}

void GyroServer::admit_all() {
  for (auto client = accept_client(listener_); client.is_open(); client = accept_client(listener_)) {
    if (clients_.size() < kMostClients) clients_.push_back(std::move(client));
  }
}

}  // namespace gyrotherm
