#include "simulator/servers/gyro_server.hpp"

#include <unistd.h>

#include <array>
#include <utility>

namespace gyrotherm {
namespace {

constexpr std::size_t kMostHeard = 1024;
constexpr const char* kReplyEnd = "\r\n";

std::span<const std::byte> bytes_of(const std::string& text) { return std::as_bytes(std::span(text)); }

}  // namespace

GyroServer::GyroServer(Descriptor listener, StreamWriter writer, std::vector<GyroCommand> commands)
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

}  // namespace gyrotherm
