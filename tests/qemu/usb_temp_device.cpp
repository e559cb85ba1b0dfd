// SPDX-License-Identifier: Apache-2.0
/// Runs inside the emulated machine: a USB-TEMP that the kernel treats as a real HID device.
///   usb_temp_device SERIAL [UNPLUG_AFTER_MS PLUG_IN_AFTER_MS]
/// The real report descriptor is not public, so the report lengths are arbitrary. The kernel drops an input report that
/// is shorter than its descriptor states, so all reports are padded.
#include <fcntl.h>
#include <linux/input.h>
#include <linux/uhid.h>
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <string>

#include "core/deadline.hpp"
#include "core/file.hpp"
#include "tests/support/fake_usb_temp.hpp"

namespace gyrotherm::tests {
namespace {

struct ReportLengths {
  /// Report number, and its lengths without the number.
  std::uint8_t number, input, output;
};
constexpr ReportLengths kReports[] = {{0x18, 4, 2}, {0x19, 32, 3}, {0x30, 62, 4}, {0x40, 0, 1}, {0x41, 0, 1},
                                      {0x44, 1, 1}, {0x49, 0, 6},  {0x4A, 4, 2},  {0x4B, 0, 1}, {0x4C, 1, 1}};

/// Returns a descriptor with one collection of a vendor-defined page. Every field is a byte (Device Class Definition
/// for HID 1.11, section 6.2.2).
std::vector<std::uint8_t> report_descriptor() {
  std::vector<std::uint8_t> bytes{0x06, 0x00, 0xFF, 0x09, 0x01, 0xA1, 0x01, 0x15, 0x00, 0x26, 0xFF, 0x00, 0x75, 0x08};
  const auto append = [&](std::initializer_list<std::uint8_t> more) { bytes.insert(bytes.end(), more); };
  for (const auto& report : kReports) {
    append({0x85, report.number});
    if (report.input > 0) append({0x95, report.input, 0x09, 0x02, 0x81, 0x02});
    append({0x95, report.output, 0x09, 0x03, 0x91, 0x02});
  }
  append({0xC0});
  return bytes;
}

class UserspaceHid {
 public:
  explicit UserspaceHid(std::string serial) : serial_(std::move(serial)), node_(open("/dev/uhid", O_RDWR | O_CLOEXEC)) {
    if (!node_.is_open()) std::perror("/dev/uhid"), std::exit(1);
    model_.temperatures[5] = drivers::kMccOpen;
  }

  void plug_in() {
    uhid_event event{};
    event.type = UHID_CREATE2;
    auto& device = event.u.create2;
    const auto descriptor = report_descriptor();
    std::strcpy(reinterpret_cast<char*>(device.name), "MCC USB-TEMP");
    std::strncpy(reinterpret_cast<char*>(device.uniq), serial_.c_str(), sizeof device.uniq - 1);
    device.bus = BUS_USB;
    device.vendor = 0x09DB;
    device.product = 0x008D;
    device.rd_size = static_cast<std::uint16_t>(descriptor.size());
    std::ranges::copy(descriptor, device.rd_data);
    put(event);
  }

  void unplug() {
    uhid_event event{};
    event.type = UHID_DESTROY;
    put(event);
    model_.items.clear();
  }

  /// Answers requests for `time`.
  void serve(Duration time) {
    const Deadline deadline(time);
    while (wait_until_ready(node_.number(), POLLIN, deadline)) {
      uhid_event event{};
      if (read(node_.number(), &event, sizeof event) <= 0) return;
      if (event.type == UHID_OUTPUT) answer({event.u.output.data, event.u.output.size});
    }
  }

 private:
  void put(const uhid_event& event) {
    if (write(node_.number(), &event, sizeof event) < 0) std::perror("uhid");
  }

  void answer(std::span<const std::uint8_t> report) {
    if (!model_.write(std::as_bytes(report))) return;
    std::array<std::byte, drivers::kMccLongestReport> reply{};
    while (const auto size = model_.read(reply, {})) {
      uhid_event event{};
      event.type = UHID_INPUT2;
      const auto number = std::to_integer<std::uint8_t>(reply[0]);
      const auto* known = std::ranges::find(kReports, number, &ReportLengths::number);
      const auto padded = known == std::end(kReports) ? *size : std::max<std::size_t>(*size, known->input + 1u);
      std::memcpy(event.u.input2.data, reply.data(), *size);
      event.u.input2.size = static_cast<std::uint16_t>(padded);
      put(event);
    }
  }

  std::string serial_;
  Descriptor node_;
  FakeUsbTemp model_;
};

}  // namespace
}  // namespace gyrotherm::tests

int main(int count, char** arguments) {
  using std::chrono::milliseconds;
  gyrotherm::tests::UserspaceHid device(count > 1 ? arguments[1] : "01234567");
  device.plug_in();
  if (count > 3) {
    device.serve(milliseconds(std::atoi(arguments[2])));
    device.unplug();
    device.serve(milliseconds(std::atoi(arguments[3])));
    device.plug_in();
  }
  device.serve(std::chrono::hours(1));
}
