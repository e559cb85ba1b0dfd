/// Any bytes as a message of `tell`: one line that means something, or a fault; what is read is written and read back
/// the same.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>

#include "core/plain_text.hpp"
#include "sequencer/run/control_message.hpp"

namespace {

using namespace gyrotherm;

void require(bool condition) {
  if (!condition) std::abort();
}

void take(std::string_view message) {
  if (const auto telling = parse_telling(message)) {
    require(telling->note.size() <= kLongestNote && telling->note.find('\n') == std::string::npos);
    require(telling->command.has_value() == telling->note.empty());
    require(is_utf8(telling->note));
    const auto again = parse_telling(to_message(*telling));
    require(again.has_value() && *again == *telling);
  }
  if (const auto answer = parse_answer(message)) {
    const auto again = parse_answer(to_message(*answer));
    require(again.has_value() && *again == *answer);
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string bytes(reinterpret_cast<const char*>(data), size);
  take(bytes);
  for (const auto* beginning : {" ", " note ", " pause ", " done ", " refused "})
    take(std::string(kTellSchema) + beginning + bytes);
  return 0;
}
