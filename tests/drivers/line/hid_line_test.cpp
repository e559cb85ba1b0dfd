// SPDX-License-Identifier: Apache-2.0
// Tests of HID without a device. tests/qemu has tests with a device.
#include "drivers/line/hid_line.hpp"

#include <gtest/gtest.h>

#include <array>
#include <chrono>

namespace gyrotherm::drivers {
namespace {

TEST(HidLine, FailsAndRestsIfDeviceIsMissing) {
  const auto line = make_hid_line({{0xFFFF, 0xFFFE, "NONE"}, {0xFFFF, 0xFFFD, "NOTHING"}}, "01234567");
  EXPECT_EQ(text(line->open().error()), "hid 01234567: no NONE or NOTHING with serial number 01234567 is connected");
  std::array<std::byte, 2> report{};
  EXPECT_EQ(line->write(report).error().kind, FaultKind::disconnected);
  EXPECT_EQ(line->read(report, std::chrono::seconds(5)).error().what,
            "no NONE or NOTHING with serial number 01234567 is connected; next try in 0.5 s");
}

TEST(HidLine, ReplacesCharactersThatCannotBePrinted) {
  EXPECT_EQ(to_printable_ascii(L" 02021FD7~"), " 02021FD7~");
  EXPECT_EQ(to_printable_ascii(L"a\nb\x1b[2J\tc\x7f"), "a?b?[2J?c?");
  EXPECT_EQ(to_printable_ascii(L"\x01\x1f"), "??");
  EXPECT_EQ(to_printable_ascii(L"µm °C\x9b"), "?m ?C?");
  EXPECT_EQ(to_printable_ascii(L"😀"), "?");
  EXPECT_EQ(to_printable_ascii(L""), "");
  EXPECT_EQ(to_printable_ascii(nullptr), "");
}

TEST(HidLine, ListsEachDeviceOnce) {
  const auto devices = list_hid_devices();
  for (std::size_t i = 1; i < devices.size(); ++i) EXPECT_LT(devices[i - 1].path, devices[i].path);
}

}  // namespace
}  // namespace gyrotherm::drivers
