// SPDX-License-Identifier: Apache-2.0
/// Parses any text as a profile. The result must be either a profile that can be planned, described and begun, or a
/// fault with a position.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <iterator>
#include <string>
#include <string_view>

#include "sequencer/profile/machine.hpp"
#include "sequencer/profile/profile.hpp"
#include "tests/support/fuzz_target.hpp"

namespace gyrotherm::profile {

using fuzz::require;

namespace {

constexpr std::string_view kHead =
    "schema = \"gyrotherm-profile/1\"\nname = \"p\"\n[[segment]]\nkind = \"hold\"\nat = 20\ntime = \"10 s\"\n";

void run(std::string_view text) {
  const auto profile = parse_profile(text, "fuzz.toml");
  if (!profile) return require(!profile.error().what.empty() && profile.error().where.starts_with("fuzz.toml:"));
  require(!profile->segments.empty() && profile->segments.size() <= 20'000);
  const auto timeline = plan(*profile);
  require(timeline.segments.size() == profile->segments.size());
  (void)check_profile(*profile, {});
  auto state = begin(*profile);
  for (int i = 0; i < 100; ++i) state = next(*profile, state, {std::chrono::seconds(1 + i * i), Celsius{20}});
  require(restore_state(*profile, profile_position(*profile, state)).has_value());
  if (profile->segments.size() < 100) require(!describe(*profile, timeline).empty());
}

/// Builds a profile from bytes. Each byte selects a segment or one of its lines, so random input reaches the expansion.
std::string build_profile(const std::uint8_t* data, std::size_t size) {
  constexpr std::string_view kParts[] = {
      "[[segment]]\nkind = \"hold\"\ntime = \"1 h\"\n",
      "[[segment]]\nkind = \"hold\"\nat = -10\ntime = \"5 s\"\nguaranteed_soak = true\n",
      "[[segment]]\nkind = \"ramp\"\nto = 30\nrate = 2\n",
      "[[segment]]\nkind = \"ramp\"\nto = -40\ntime = \"1 h\"\n",
      "[[segment]]\nkind = \"random\"\nseed = 1\nduration = \"90 h\"\ntargets = [[0, 50]]\nrates = [1, 5]\n"
      "hold = [\"1 s\", \"1 h\"]\n",
      "[[segment]]\nkind = \"repeat\"\ncount = 3\n[[segment.segment]]\nkind = \"hold\"\ntime = \"9 s\"\n",
      "[[segment]]\nkind = \"repeat\"\nrates = [1, 5]\n[[segment.segment]]\nkind = \"ramp\"\nto = 60\n",
      "[[segment.segment]]\nkind = \"ramp\"\nto = 10\nrate = 3\n",
      "[[segment.segment]]\nkind = \"repeat\"\ncount = 200\n[[segment.segment.segment]]\nkind = \"hold\"\ntime = \"1 "
      "s\"\n",
      "cycle = true\n",
      "least_step = 49\n",
      "soak_time = \"2 h\"\n",
      "deadline = \"1 h\"\n"};
  std::string text(kHead);
  for (std::size_t i = 0; i < size; ++i) text += kParts[data[i] % std::size(kParts)];
  return text;
}

}  // namespace

FUZZ_TARGET(profile, const std::uint8_t* data, std::size_t size) {
  const std::string bytes(reinterpret_cast<const char*>(data), size);
  run(bytes);
  run(std::string(kHead) + bytes);
  if (size > 0) run(build_profile(data, std::min<std::size_t>(size, 1 + data[0] % 5)));
  return 0;
}

}  // namespace gyrotherm::profile
