// SPDX-License-Identifier: Apache-2.0
/// Any bytes as a client's lines: each has an answer of whole lines in text, and nothing of the node changes but what
/// the client hears of.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>

#include "apps/monitor/secop_node.hpp"
#include "core/text.hpp"

namespace gyrotherm::monitor {
namespace {

void require(bool condition) {
  if (!condition) std::abort();
}

const SecopState& state() {
  static const SecopState made = [] {
    SecopNode node{.equipment_id = "fuzz", .description = "fuzz", .firmware = "fuzz", .modules = {}};
    node.modules = {{"t",
                     "t",
                     {},
                     {{"value", "v", R"({"type":"double"})", "1", {}, 1, true},
                      {"status", "s", R"({"type":"string"})", "HardwareError", "none", 1, false}}}};
    auto structure = structure_of(node);
    return SecopState{std::move(node), std::move(structure)};
  }();
  return made;
}

void take(SecopSession& session, const std::string& line) {
  const auto answer = answer_secop(state(), session, line, 1.5);
  require(!answer.empty() && answer.back() == '\n' && is_utf8(answer));
  require(std::ranges::none_of(answer, [](unsigned char c) { return c < ' ' && c != '\n'; }));
  require(session.modules.size() <= state().node.modules.size());
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  std::string line(reinterpret_cast<const char*>(data), size);
  std::ranges::replace(line, '\n', ' ');
  SecopSession session;
  for (const auto* before : {"", "activate ", "deactivate ", "read ", "read t:", "change t:value ", "do t:", "ping "})
    take(session, before + line);
  std::set<std::string> taken;
  const auto name = secop_name(line, taken);
  require(!name.empty() && name.size() <= 63 && name.front() != '_');
  return 0;
}

}  // namespace gyrotherm::monitor
