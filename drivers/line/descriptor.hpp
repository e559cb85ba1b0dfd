/// An open file of the operating system, and waiting for it.
#pragma once

#include <poll.h>
#include <unistd.h>

#include <cerrno>
#include <ctime>
#include <utility>

#include "drivers/line/deadline.hpp"

namespace gyrotherm {

inline constexpr int kNoDescriptor = -1;

/// Owns a descriptor.
class Descriptor {
 public:
  Descriptor() = default;
  explicit Descriptor(int number) : number_(number) {}
  ~Descriptor() { close(); }
  Descriptor(const Descriptor&) = delete;
  Descriptor(Descriptor&& other) noexcept : number_(std::exchange(other.number_, kNoDescriptor)) {}
  Descriptor& operator=(Descriptor&& other) noexcept {
    close();
    number_ = std::exchange(other.number_, kNoDescriptor);
    return *this;
  }
  [[nodiscard]] bool is_open() const { return number_ >= 0; }
  [[nodiscard]] int number() const { return number_; }
  void close() {
    if (is_open()) ::close(number_);
    number_ = kNoDescriptor;
  }

 private:
  int number_ = kNoDescriptor;
};

/// True once `descriptor` is ready for `events` (or broken); false if the time is over. A signal does not end the wait.
[[nodiscard]] inline bool ready(int descriptor, short events, const Deadline& deadline) {
  pollfd line{descriptor, events, 0};
  while (true) {
    const auto left = deadline.left();
    const auto seconds = std::chrono::floor<std::chrono::seconds>(left);
    const timespec limit{seconds.count(), (left - seconds).count()};
    const int found = ppoll(&line, 1, &limit, nullptr);
    if (found >= 0 || errno != EINTR) return found > 0;
  }
}

/// Whether errno says that the call is to be made again once the descriptor is ready.
[[nodiscard]] inline bool would_block() { return errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR; }

}  // namespace gyrotherm
