/// Any text is either a profile that can be planned, described and begun, or refused with a place.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <iterator>
#include <string>
#include <string_view>

#include "sequencer/machine.hpp"
#include "sequencer/timeline.hpp"

namespace {

constexpr std::string_view kHead =
    "schema = \"gyrotherm-profile/1\"\nname = \"p\"\n[[segment]]\nkind = \"hold\"\nat = 20\ntime = \"10 s\"\n";

void require(bool law) {
  if (!law) std::abort();
}

void run(std::string_view text) {
  using namespace gyrotherm;
  const auto profile = parse_profile(text, "fuzz.toml");
  if (!profile) return require(!profile.error().what.empty() && profile.error().where.starts_with("fuzz.toml:"));
  require(!profile->segments.empty() && profile->segments.size() <= 100'000);
  const auto timeline = plan(*profile);
  require(timeline.segments.size() == profile->segments.size());
  (void)check_profile(*profile, {});
  auto state = begin(*profile);
  for (int i = 0; i < 100; ++i) state = next(*profile, state, {std::chrono::seconds(1 + i * i), Celsius{20}});
  require(state_of(*profile, progress_of(*profile, state)).has_value());
  if (profile->segments.size() < 100) require(!describe(*profile, timeline).empty());
}

/// Grammar from bytes: each picks a line, so that random input reaches the expansion.
std::string spelled(const std::uint8_t* data, std::size_t size) {
  constexpr std::string_view kLines[] = {
      "[[segment]]\n",          "[[segment.segment]]\n", "[[segment.segment.segment]]\n", "kind = \"hold\"\n",
      "kind = \"ramp\"\n",      "kind = \"repeat\"\n",   "kind = \"random\"\n",           "time = \"1 h\"\n",
      "to = 30\n",              "to = -40\n",            "rate = 2\n",                    "rates = [1, 5]\n",
      "count = 1000000000\n",   "count = 2\n",           "cycle = true\n",                "seed = 1\n",
      "duration = \"10 h\"\n",  "targets = [[0, 50]]\n", "hold = [\"1 s\", \"1 h\"]\n",   "least_step = 49\n",
      "guaranteed_soak = true\n"};
  std::string text(kHead);
  for (std::size_t i = 0; i < size; ++i) text += kLines[data[i] % std::size(kLines)];
  return text;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string bytes(reinterpret_cast<const char*>(data), size);
  run(bytes);
  run(std::string(kHead) + bytes);
  run(spelled(data, std::min<std::size_t>(size, 24)));
  return 0;
}
