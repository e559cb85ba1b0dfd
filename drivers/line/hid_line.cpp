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
/// Number of failed reads in one call after which the device is closed. A single read may fail although the device is
/// present, for example after a signal.
constexpr int kMaxReadFailures = 3;

/// Returns the mutex for hidapi, whose functions for listing, opening and closing are not thread-safe.
std::mutex& hidapi_mutex() {
  static std::mutex one;
  return one;
}

struct CloseDevice {
  void operator()(hid_device* device) const {
    const std::scoped_lock lock(hidapi_mutex());
    hid_close(device);
  }
};

/// Returns the reason why a device file cannot be used, or "". It must be called before hidapi opens the file, because
/// hidapi reads freed memory if the file is not an HID device or the device is being removed.
std::string find_access_error(const std::string& path) {
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
    if (device_) return identity_;
    if (backoff_.left() > Duration::zero()) return failure(FaultKind::disconnected, place(), backoff_.message());
    const auto found = find_device();
    if (!found) return close_with_fault(found.error().what);
    if (auto access_error = find_access_error(found->path); !access_error.empty())
      return close_with_fault(std::move(access_error));
    {
      const std::scoped_lock lock(hidapi_mutex());
      device_.reset(hid_open_path(found->path.c_str()));
    }
    if (!device_) return close_with_fault("cannot be opened");
    path_ = found->path;
    identity_ = fmt::format("{} {}", find_kind(*found)->name, found->serial);
    std::array<unsigned char, kLongestReport> stale;
    while (hid_read_timeout(device_.get(), stale.data(), stale.size(), 0) > 0) {
    }
    return identity_;
  }

  Result<void> write(std::span<const std::byte> report) override {
    if (auto opened = open(); !opened) return failure(std::move(opened.error()));
    const auto* bytes = reinterpret_cast<const unsigned char*>(report.data());
    if (hid_write(device_.get(), bytes, report.size()) >= 0) return {};
    return close_with_fault(is_still_connected() ? "the device did not accept the report" : "unplugged");
  }

  Result<std::size_t> read(std::span<std::byte> report, Duration within) override {
    if (auto opened = open(); !opened) return failure(std::move(opened.error()));
    const Deadline deadline(within);
    for (int failures = 0; failures < kMaxReadFailures;) {
      const auto left = std::chrono::ceil<milliseconds>(deadline.left()).count();
      auto* bytes = reinterpret_cast<unsigned char*>(report.data());
      const int size = hid_read_timeout(device_.get(), bytes, report.size(), static_cast<int>(left));
      if (size > 0) {
        backoff_.note_success();
        return static_cast<std::size_t>(size);
      }
      if (size == 0)
        return failure(FaultKind::timeout, place(), fmt::format("no report in {} ms", within / milliseconds(1)));
      if (!is_still_connected()) return close_with_fault("unplugged");
      ++failures;
    }
    return close_with_fault("reports cannot be read");
  }

 private:
  [[nodiscard]] const HidKind* find_kind(const HidDeviceFound& device) const {
    const auto found = std::ranges::find_if(
        kinds_, [&](const auto& kind) { return kind.vendor == device.vendor && kind.product == device.product; });
    return found == kinds_.end() ? nullptr : &*found;
  }

  [[nodiscard]] Result<HidDeviceFound> find_device() const {
    std::vector<HidDeviceFound> matches;
    std::string serials;
    for (auto& device : list_hid_devices()) {
      if (find_kind(device) == nullptr || (!serial_.empty() && device.serial != serial_)) continue;
      serials += (serials.empty() ? "" : ", ") + device.serial;
      matches.push_back(std::move(device));
    }
    if (matches.size() == 1) return std::move(matches.front());
    const auto which = serial_.empty() ? std::string() : fmt::format(" with serial number {}", serial_);
    if (matches.empty())
      return failure(FaultKind::disconnected, "", fmt::format("no {}{} is connected", kind_names(), which));
    return failure(
        FaultKind::disconnected, "",
        fmt::format("{} of {}{} are connected ({}); expected one", matches.size(), kind_names(), which, serials));
  }

  [[nodiscard]] std::string kind_names() const {
    std::string all;
    for (const auto& kind : kinds_) all += (all.empty() ? "" : " or ") + std::string(kind.name);
    return all;
  }

  [[nodiscard]] std::string place() const { return serial_.empty() ? "hid" : "hid " + serial_; }

  [[nodiscard]] tl::unexpected<Fault> close_with_fault(std::string why) {
    device_.reset();
    backoff_.note_failure(why);
    return failure(FaultKind::disconnected, place(), std::move(why));
  }

  [[nodiscard]] bool is_still_connected() const { return access(path_.c_str(), F_OK) == 0; }

  std::vector<HidKind> kinds_;
  std::string serial_;
  std::unique_ptr<hid_device, CloseDevice> device_;
  std::string path_, identity_;
  Backoff backoff_;
};

}  // namespace

std::string to_printable_ascii(const wchar_t* text) {
  std::string ascii;
  for (; text != nullptr && *text != L'\0'; ++text)
    ascii += *text >= 0x20 && *text < 0x7F ? static_cast<char>(*text) : '?';
  return ascii;
}

std::unique_ptr<HidReports> make_hid_line(std::vector<HidKind> kinds, std::string serial) {
  return std::make_unique<OpenedHid>(std::move(kinds), std::move(serial));
}

std::vector<HidDeviceFound> list_hid_devices() {
  const std::scoped_lock lock(hidapi_mutex());
  std::vector<HidDeviceFound> found;
  auto* first = hid_enumerate(0, 0);
  for (const auto* device = first; device != nullptr; device = device->next) {
    const std::string path = device->path == nullptr ? "" : device->path;
    const bool seen = std::ranges::any_of(found, [&](const auto& other) { return other.path == path; });
    if (seen) continue;  // hidapi lists each usage
    found.push_back({path, device->vendor_id, device->product_id, to_printable_ascii(device->serial_number),
                     to_printable_ascii(device->manufacturer_string), to_printable_ascii(device->product_string)});
  }
  hid_free_enumeration(first);
  std::ranges::sort(found, {}, &HidDeviceFound::path);
  return found;
}

}  // namespace gyrotherm::drivers
