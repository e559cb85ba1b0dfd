// SPDX-License-Identifier: Apache-2.0
/// Feeds any bytes to a virtual chamber with lines of text and a profile memory, also as values in a line of a program.
/// Each reply must be a whole line, and a stored line must be read back as it was stored.
#include <cstdlib>
#include <string>

#include "simulator/chamber_registers.hpp"
#include "simulator/servers/text_server.hpp"
#include "tests/simulator/shipped_rigs.hpp"
#include "tests/support/fuzz_target.hpp"

namespace gyrotherm::simulator {
namespace {

std::string feed(Session& session, const std::string& lines) {
  std::vector<std::byte> reply;
  if (!session.feed(std::as_bytes(std::span(lines)), reply)) std::abort();
  if (!reply.empty() && reply.back() != std::byte{'\n'}) std::abort();
  return {reinterpret_cast<const char*>(reply.data()), reply.size()};
}

/// Returns the text without line ends.
std::string one_line(std::string text) {
  std::erase_if(text, [](char c) { return c == '\r' || c == '\n'; });
  return text;
}

}  // namespace

FUZZ_TARGET(text_session, const std::uint8_t* data, std::size_t size) {
  static VirtualLaboratory laboratory(laboratory_of_rig("virtual"), {});
  static ChamberRegisters unit(chamber_map("espec_p300"), laboratory);
  const auto session = make_text_session(unit, drivers::LinkKind::text_tcp, false);
  const std::string text(reinterpret_cast<const char*>(data), size);
  feed(*session, text + "\r\n");
  const auto value = one_line(text);
  feed(*session, "PRGM DATA WRITE, PGM1, STEP" + value + "\r\n");
  feed(*session, "PRGM DATA WRITE, PGM1, NAME, " + value + "\r\n");
  feed(*session, "PRGM ERASE,RAM:1\r\n");
  const auto stored =
      feed(*session, "PRGM DATA WRITE, PGM1, STEP1, TEMP" + value + ", TRAMPON, TIME1:05, GRANTY OFF, PAUSE OFF\r\n");
  const auto shown = feed(*session, "PRGM DATA?,RAM:1,STEP1\r\n");
  if (stored.starts_with("OK:") && !shown.starts_with("1,TEMP")) std::abort();
  feed(*session, "PRGM, RUN, RAM:1, STEP1\r\n");
  unit.advance_second();
  if (feed(*session, "TYPE?\r\n").empty()) std::abort();
  return 0;
}

}  // namespace gyrotherm::simulator
