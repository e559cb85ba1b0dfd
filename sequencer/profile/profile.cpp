#include "sequencer/profile/profile.hpp"

#include <algorithm>

#include "core/toml_reader.hpp"
#include "sequencer/profile/expansion.hpp"
#include "sequencer/profile/written_profile.hpp"

namespace gyrotherm {
namespace {

constexpr const char* kSchema = "gyrotherm-profile/1";

/// `prefix.key = number`, however deep the tables: both "a.b" = 1 and a.b = 1 are the path a.b.
void read_accept(const TomlTable& table, const std::string& prefix, std::vector<AcceptLimit>& limits) {
  for (const auto& key : table.keys()) {
    if (table.is_table(key))
      read_accept(table.table(key), prefix + key + ".", limits);
    else
      limits.push_back({prefix + key, table.number(key)});
  }
}

}  // namespace

Duration shortest(const Segment& segment) {
  return segment.guaranteed_soak ? std::max(segment.duration, segment.soak_time + segment.soak_dwell)
                                 : segment.duration;
}

Celsius set_point_before(const Profile& profile, std::size_t segment) {
  return profile.segments[segment == 0 ? 0 : segment - 1].target;
}

Result<Profile> parse_profile(std::string_view text, const std::string& file) {
  const auto root = TomlTable::parse(text, file);
  if (!root) return failure(root.error());
  root->expect("schema", kSchema);
  Profile profile;
  profile.text = text;
  profile.name = root->text("name");
  profile.title = root->text("title", profile.name);
  const auto metadata = root->table("metadata");
  for (const auto& key : metadata.keys()) profile.metadata[key] = metadata.text(key);
  read_accept(root->table("accept"), "", profile.accept);
  const auto written = read_segments(*root, read_defaults(root->table("defaults")));
  if (const auto verdict = root->verdict(); !verdict) return failure(verdict.error());
  expand(written, profile);
  if (const auto verdict = root->verdict(); !verdict) return failure(verdict.error());
  return profile;
}

}  // namespace gyrotherm
