/// An open file of the operating system.
#pragma once

#include <unistd.h>

#include <utility>

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
  /// Whoever takes the number owns it.
  [[nodiscard]] int release() && { return std::exchange(number_, kNoDescriptor); }
  void close() {
    if (is_open()) ::close(number_);
    number_ = kNoDescriptor;
  }

 private:
  int number_ = kNoDescriptor;
};

}  // namespace gyrotherm
