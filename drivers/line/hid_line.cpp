// SPDX-License-Identifier: Apache-2.0
#include "drivers/line/hid_line.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <hidapi.h>
#include <linux/hidraw.h>
#include <sys/ioctl.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstring>
#include <mutex>
#include <utility>

#include "core/deadline.hpp"
#include "core/file.hpp"
#include "drivers/line/pauses.hpp"

namespace gyrotherm::drivers {

namespace {

using std::chrono::milliseconds;

constexpr std::size_t kLongestReport = 64;
/// Number of failed reads after which the device is closed. A read may fail although the device is present, for example
/// after a signal.
constexpr int kMostOddFailures = 3;

/// Returns the lock for hidapi, whose listing, opening and closing is not thread-safe.
std::mutex& library() {
  static std::mutex one;
  return one;
}

struct CloseDevice {
  void operator()(hid_device* device) const {
    const std::scoped_lock lock(library());
    hid_close(device);
  }
};

/// Converts to ASCII; other characters become question marks.
std::string narrow(const wchar_t* text) {
  std::string narrowed;
  for (; text != nullptr && *text != L'\0'; ++text) narrowed += *text < 128 ? static_cast<char>(*text) : '?';
  return narrowed;
}

/// Returns the reason why a device file cannot be used, or "". hidapi reads freed memory when it opens a file that is
/// not an HID device, or a device that is being removed.
std::string objection_to(const std::string& path) {
  const Descriptor node(open(path.c_str(), O_RDWR | O_CLOEXEC));
  if (!node.is_open() && errno == EACCES) return "permission denied; see \"gyrotherm devices\"";
  if (!node.is_open()) return std::strerror(errno);
  int size = 0;
  return ioctl(node.number(), HIDIOCGRDESCSIZE, &size) == 0 ? "" : std::strerror(errno);
}

class OpenedHid final : public HidReports {
 public:
  OpenedHid(std::vector<HidKind> kinds, std::string serial) : kinds_(std::move(kinds)), serial_(std::move(serial)) {}

  Result<std::string> open() override {
    if (device_) return who_;
    if (backoff_.left() > Duration::zero()) return failure(FaultKind::disconnected, place(), backoff_.words());
    const auto found = find();
    if (!found) return broken(found.error().what);
    if (auto objection = objection_to(found->path); !objection.empty()) return broken(std::move(objection));
    {
      const std::scoped_lock lock(library());
      device_.reset(hid_open_path(found->path.c_str()));
    }
    if (!device_) return broken("cannot be opened");
    path_ = found->path;
    who_ = fmt::format("{} {}", kind_of(*found)->name, found->serial);
    std::array<unsigned char, kLongestReport> stale;
    while (hid_read_timeout(device_.get(), stale.data(), stale.size(), 0) > 0) {
    }
    return who_;
  }

  Result<void> write(std::span<const std::byte> report) override {
    if (auto opened = open(); !opened) return failure(std::move(opened.error()));
    const auto* bytes = reinterpret_cast<const unsigned char*>(report.data());
    if (hid_write(device_.get(), bytes, report.size()) >= 0) return {};
    return broken(is_still_connected() ? "the device did not accept the report" : "unplugged");
  }

  Result<std::size_t> read(std::span<std::byte> report, Duration within) override {
    if (auto opened = open(); !opened) return failure(std::move(opened.error()));
    const Deadline deadline(within);
    for (int failures = 0; failures < kMostOddFailures;) {
      const auto left = std::chrono::ceil<milliseconds>(deadline.left()).count();
      auto* bytes = reinterpret_cast<unsigned char*>(report.data());
      const int size = hid_read_timeout(device_.get(), bytes, report.size(), static_cast<int>(left));
      if (size > 0) {
        backoff_.succeeded();
        return static_cast<std::size_t>(size);
      }
      if (size == 0)
        return failure(FaultKind::timeout, place(), fmt::format("no report in {} ms", within / milliseconds(1)));
      if (!is_still_connected()) return broken("unplugged");
      ++failures;
    }
    return broken("reports cannot be read");
  }

 private:
  [[nodiscard]] const HidKind* kind_of(const HidDeviceFound& device) const {
    const auto found = std::ranges::find_if(
        kinds_, [&](const auto& kind) { return kind.vendor == device.vendor && kind.product == device.product; });
    return found == kinds_.end() ? nullptr : &*found;
  }

  [[nodiscard]] Result<HidDeviceFound> find() const {
    std::vector<HidDeviceFound> fitting;
    std::string serials;
    for (auto& device : hid_devices()) {
      if (kind_of(device) == nullptr || (!serial_.empty() && device.serial != serial_)) continue;
      serials += (serials.empty() ? "" : ", ") + device.serial;
      fitting.push_back(std::move(device));
    }
    if (fitting.size() == 1) return std::move(fitting.front());
    const auto which = serial_.empty() ? std::string() : fmt::format(" with serial number {}", serial_);
    if (fitting.empty())
      return failure(FaultKind::disconnected, "", fmt::format("no {}{} is connected", names(), which));
    return failure(FaultKind::disconnected, "",
                   fmt::format("{} of {}{} are connected ({}); expected one", fitting.size(), names(), which, serials));
  }

  [[nodiscard]] std::string names() const {
    std::string all;
    for (const auto& kind : kinds_) all += (all.empty() ? "" : " or ") + std::string(kind.name);
    return all;
  }

  [[nodiscard]] std::string place() const { return serial_.empty() ? "hid" : "hid " + serial_; }

  [[nodiscard]] tl::unexpected<Fault> broken(std::string why) {
    device_.reset();
    backoff_.failed();
    return failure(FaultKind::disconnected, place(), std::move(why));
  }

  [[nodiscard]] bool is_still_connected() const { return access(path_.c_str(), F_OK) == 0; }

  std::vector<HidKind> kinds_;
  std::string serial_;
  std::unique_ptr<hid_device, CloseDevice> device_;
  std::string path_, who_;
  Backoff backoff_;
};

}  // namespace

std::unique_ptr<HidReports> make_hid_line(std::vector<HidKind> kinds, std::string serial) {
  return std::make_unique<OpenedHid>(std::move(kinds), std::move(serial));
}

std::vector<HidDeviceFound> hid_devices() {
  const std::scoped_lock lock(library());
  std::vector<HidDeviceFound> found;
  auto* first = hid_enumerate(0, 0);
  for (const auto* device = first; device != nullptr; device = device->next) {
    const std::string path = device->path == nullptr ? "" : device->path;
    const bool seen = std::ranges::any_of(found, [&](const auto& other) { return other.path == path; });
    if (seen) continue;  // listed once per usage
    found.push_back({path, device->vendor_id, device->product_id, narrow(device->serial_number),
                     narrow(device->manufacturer_string), narrow(device->product_string)});
  }
  hid_free_enumeration(first);
  std::ranges::sort(found, {}, &HidDeviceFound::path);
  return found;
}

}  // namespace gyrotherm::drivers
