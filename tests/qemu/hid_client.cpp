// SPDX-License-Identifier: Apache-2.0
/// Runs inside the emulated machine: the USB-TEMP driver on the real hidapi and the kernel's hidraw. There are two
/// devices; the selected one is unplugged and plugged in again.
#include <unistd.h>

#include <chrono>

#include "core/deadline.hpp"
#include "drivers/line/hid_line.hpp"
#include "drivers/thermometer/mcc_usb_temp.hpp"
#include "tests/qemu/checks.hpp"

namespace gyrotherm::tests {
namespace {

using std::chrono::milliseconds, std::chrono::seconds;

constexpr const char* kSerial = "01234567";

std::unique_ptr<drivers::Thermometer> make_thermometer(const std::string& serial) {
  drivers::MccOptions options;
  options.sensors[0] = options.sensors[1] = drivers::MccRtd{.r0_ohm = 100.02f};
  return make_mcc_usb_temp(drivers::make_hid_line({drivers::kMccKinds.begin(), drivers::kMccKinds.end()}, serial),
                           "bank", options);
}

bool has_good_readings(drivers::Thermometer& thermometer) {
  const auto readings = thermometer.read();
  bool well = true;
  for (std::size_t i = 0; i < readings.size(); ++i)
    well = well && (i == 5 ? !readings[i] && readings[i].error().kind == FaultKind::out_of_range
                           : readings[i].value_or(Celsius{}) == Celsius{20.125 + static_cast<double>(i)});
  return well;
}

/// Reads until the readings are valid, or invalid, as required. Returns false after half a minute.
bool wait_for_readings(drivers::Thermometer& thermometer, bool good) {
  const Deadline deadline(seconds(30));
  while (!deadline.has_passed()) {
    if (has_good_readings(thermometer) == good) return true;
    usleep(100'000);
  }
  return false;
}

int run() {
  Checks checks;
  const auto devices = drivers::list_hid_devices();
  for (const auto& device : devices)
    fmt::print("{} {:04x}:{:04x} {} {}\n", device.path, device.vendor, device.product, device.serial, device.model);
  checks.expect(devices.size() == 2, "two devices are listed");

  const auto any = make_thermometer("")->identify();
  checks.expect(!any && any.error().what.find("expected one") != std::string::npos,
                "without a number neither is taken");
  const auto none = make_thermometer("99999999")->identify();
  checks.expect(!none && none.error().kind == FaultKind::disconnected, "a number that is not there is disconnected");

  const auto wanted = make_thermometer(kSerial);
  const auto who = wanted->identify();
  fmt::print("{}\n", who ? *who : text(who.error()));
  checks.expect(who && *who == "MCC USB-TEMP 01234567, calibrated 2024-05-17", "it is the one with the number");
  checks.expect(has_good_readings(*wanted), "eight inputs are read, the open one a fault");

  const Deadline began(seconds(60));
  int good = 0;
  for (int i = 0; i < 200; ++i) good += has_good_readings(*wanted);
  fmt::print("{} of 200 scans good, {:.2f} ms each\n", good, 1e3 * (60 - to_seconds(began.left())) / 200);
  checks.expect(good == 200, "two hundred scans");

  fmt::print("READY TO UNPLUG\n");
  (void)fflush(stdout);
  checks.expect(wait_for_readings(*wanted, false), "it is unplugged");
  const auto gone = wanted->read().front();
  fmt::print("{}\n", gone ? "still there" : text(gone.error()));
  checks.expect(!gone && gone.error().kind == FaultKind::disconnected, "unplugged is disconnected");
  checks.expect(wait_for_readings(*wanted, true), "it is found again, set up again and read again");
  return checks.exit_code();
}

}  // namespace
}  // namespace gyrotherm::tests

int main() { return gyrotherm::tests::run(); }
