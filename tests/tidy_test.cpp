/// The house rules, held: who may include what, how large a file and a function may grow, which words are not used.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <string>
#include <vector>

namespace {

namespace fs = std::filesystem;

const fs::path kRoot = GYROTHERM_SOURCE_DIR;
const std::vector<std::string> kRooms{"core",   "drivers",   "sequencer", "acquisition", "analysis",
                                      "report", "simulator", "rig",       "app"};

/// Room → the rooms whose headers it may include, beside its own.
const std::map<std::string, std::set<std::string>> kArrows{
    {"core", {}},
    {"drivers", {"core"}},
    {"sequencer", {"core"}},
    {"acquisition", {"core", "drivers"}},
    {"analysis", {"core"}},  // and acquisition in dataset alone
    {"report", {"core", "analysis"}},
    {"simulator", {"core", "drivers"}},
    {"rig", {"core", "drivers", "sequencer", "acquisition", "simulator"}},
    {"app", {"core", "drivers", "sequencer", "acquisition", "analysis", "report", "simulator", "rig"}},
};

/// Room → beginnings of the third-party headers that it may include. fmt and tl::expected are allowed everywhere.
const std::map<std::string, std::vector<std::string>> kThirdParties{
    {"core", {"toml++/"}},
    {"drivers", {"modbus/", "libserialport.h", "hidapi.h"}},
    {"sequencer", {}},
    {"acquisition", {"sqlite3.h", "nlohmann/"}},
    {"analysis", {"Eigen/", "tbb/", "oneapi/", "nlohmann/"}},
    {"report", {"nlohmann/", "Eigen/"}},
    {"simulator", {"Eigen/", "HYPRE", "mpi.h"}},
    {"rig", {}},
    {"app", {"Q", "CLI/", "spdlog/", "nlohmann/", "Eigen/"}},
};

struct Source {
  fs::path path;
  std::string room;
  std::vector<std::string> lines;
  [[nodiscard]] std::string at(std::size_t line) const {
    return fmt::format("{}:{}", fs::relative(path, kRoot).string(), line + 1);
  }
};

std::vector<std::string> lines_of(const fs::path& path) {
  std::ifstream file(path);
  std::vector<std::string> lines;
  for (std::string line; std::getline(file, line);) lines.push_back(line);
  return lines;
}

/// Every .hpp and .cpp of the rooms.
const std::vector<Source>& sources() {
  static const std::vector<Source> all = [] {
    std::vector<Source> found;
    for (const auto& room : kRooms)
      for (const auto& entry : fs::recursive_directory_iterator(kRoot / room))
        if (const auto extension = entry.path().extension(); extension == ".hpp" || extension == ".cpp")
          found.push_back({entry.path(), room, lines_of(entry.path())});
    return found;
  }();
  return all;
}

bool is_room(const std::string& name) { return kArrows.contains(name); }

bool may_include(const Source& source, const std::string& room) {
  if (room == source.room || kArrows.at(source.room).contains(room)) return true;
  const auto stem = source.path.stem().string();
  return source.room == "analysis" && room == "acquisition" && stem.starts_with("dataset");
}

TEST(House, IncludesPointOneWay) {
  const std::regex include(R"(^#include "([a-z_]+)/)");
  for (const auto& source : sources())
    for (std::size_t i = 0; i < source.lines.size(); ++i) {
      std::smatch match;
      if (!std::regex_search(source.lines[i], match, include) || !is_room(match[1])) continue;
      EXPECT_TRUE(may_include(source, match[1]))
          << source.at(i) << ": " << source.room << " may not include " << match[1];
    }
}

TEST(House, ThirdPartiesStayInTheirRooms) {
  const std::regex include(R"(^#include <([^>]+)>)");
  const std::vector<std::string> known{"toml++/",         "modbus/", "sqlite3.h", "nlohmann/", "Eigen/", "tbb/",
                                       "oneapi/",         "Q",       "CLI/",      "spdlog/",   "HYPRE",  "mpi.h",
                                       "libserialport.h", "hidapi.h"};
  const auto starts = [](const std::string& header, const std::vector<std::string>& with) {
    return std::any_of(with.begin(), with.end(), [&](const auto& prefix) { return header.starts_with(prefix); });
  };
  for (const auto& source : sources())
    for (std::size_t i = 0; i < source.lines.size(); ++i) {
      std::smatch match;
      if (!std::regex_search(source.lines[i], match, include) || !starts(match[1], known)) continue;
      EXPECT_TRUE(starts(match[1], kThirdParties.at(source.room))) << source.at(i) << ": " << match[1];
    }
}

TEST(House, HeadersOfOneRoomHideItsThirdParties) {
  const std::regex include(
      R"(^#include <(toml\+\+/|modbus/|libserialport|hidapi|sqlite3\.h|nlohmann/|Q[A-Z]|HYPRE|mpi\.h))");
  for (const auto& source : sources()) {
    if (source.path.extension() != ".hpp" || source.room == "app") continue;
    if (source.path.stem() == "sqlite") continue;  // acquisition's own wrapper, included by its .cpp files alone
    for (std::size_t i = 0; i < source.lines.size(); ++i)
      EXPECT_FALSE(std::regex_search(source.lines[i], include)) << source.at(i) << ": third party in a header";
  }
}

TEST(House, FilesHaveOneSubject) {
  for (const auto& source : sources()) EXPECT_LE(source.lines.size(), 400u) << source.at(0) << ": split this file";
}

TEST(House, LinesFitASheet) {
  constexpr std::size_t kWidest = 120;
  const auto width = [](const std::string& line) {
    return static_cast<std::size_t>(
        std::count_if(line.begin(), line.end(), [](unsigned char byte) { return (byte & 0xC0) != 0x80; }));
  };
  for (const auto& source : sources())
    for (std::size_t i = 0; i < source.lines.size(); ++i)
      EXPECT_LE(width(source.lines[i]), kWidest) << source.at(i) << ": too wide";
}

/// In this layout a function starts on an unindented (or twice-indented member) line that ends with "{" and ends at a
/// line that is "}" with the same indent.
TEST(House, FunctionsAreShort) {
  const std::regex opening(R"(^( {0,2})[A-Za-z_~\[].*\(.*\{$|^( {0,4})[^ #/].*\).*\{$)");
  for (const auto& source : sources())
    for (std::size_t i = 0; i < source.lines.size(); ++i) {
      const auto& line = source.lines[i];
      const auto indent = line.find_first_not_of(' ');
      if (indent == std::string::npos || indent > 2 || !std::regex_match(line, opening)) continue;
      if (line.starts_with("namespace") || line.starts_with("extern")) continue;
      const std::string closing = std::string(indent, ' ') + "}";
      auto end = i + 1;
      while (end < source.lines.size() && !source.lines[end].starts_with(closing)) ++end;
      EXPECT_LE(end - i, 70u) << source.at(i) << ": shorten this function";
    }
}

TEST(House, BannedWordsAreNotUsed) {
  struct Ban {
    std::regex word;
    std::string instead;
    std::set<std::string> allowed_rooms;
  };
  const std::vector<Ban> bans{
      {std::regex(R"(\bsleep_for\b|\busleep\b|\bnanosleep\b)"), "hand in a Clock", {"app"}},
      {std::regex(R"(\b(TODO|FIXME|XXX|HACK)\b)"), "do it, or file an issue", {}},
      {std::regex(R"(\busing namespace\b)"), "name what you use", {}},
      {std::regex(R"(\b\w*(Manager|Helper|Utils|Impl)\b)"), "say what it is", {}},
      {std::regex(R"((^|[^:.>\w])get_[a-z_]+\()"), "name the thing, not the getting", {}},
      {std::regex(R"(\bstd::rand\b|\brand\(\))"), "a seeded engine", {}},
      {std::regex(R"(\bmodbus_(set|get)_float)"), "drivers/chamber/register_value", {}},
      {std::regex(R"(\bsystem_clock\b)"), "Clock", {"core"}},
      {std::regex(R"(\bthrow\b)"), "Result", {}},
      {std::regex(R"(\bistreambuf_iterator\b)"), "getline: no exception if a read fails", {}},
      {std::regex(R"(: (std::file|f)s(ystem)?::(recursive_)?directory_iterator)"), "entries_of", {}},
      {std::regex(R"(\bstd::cout\b|\bprintf\()"), "the program's own output", {"app"}},
  };
  for (const auto& source : sources())
    for (std::size_t i = 0; i < source.lines.size(); ++i)
      for (const auto& ban : bans) {
        if (ban.allowed_rooms.contains(source.room)) continue;
        EXPECT_FALSE(std::regex_search(source.lines[i], ban.word))
            << source.at(i) << ": not used here; instead: " << ban.instead << "\n"
            << source.lines[i];
      }
}

/// The documents name scripts as commands.
TEST(House, ScriptsCanBeRun) {
  for (const std::string folder : {"bench", "debian", "profiles", "tests"}) {
    for (const auto& entry : fs::recursive_directory_iterator(kRoot / folder)) {
      if (!entry.is_regular_file()) continue;
      std::string first;
      std::getline(std::ifstream(entry.path()), first);
      if (first.starts_with("#!"))
        EXPECT_NE(entry.status().permissions() & fs::perms::owner_exec, fs::perms::none)
            << entry.path() << ": chmod +x";
    }
  }
}

TEST(House, TopLevelHoldsTheRoomsAndNothingElse) {
  std::set<std::string> allowed{
      "CMakeLists.txt", "CMakePresets.json", "README.md", "CHANGELOG.md", "LICENSE", "cmake", "debian",
      "docs",           "profiles",          "tests",     "bench",        "monitor"};
  allowed.insert(kRooms.begin(), kRooms.end());
  for (const auto& entry : fs::directory_iterator(kRoot)) {
    const auto name = entry.path().filename().string();
    if (name.starts_with('.') || name == "build" || name == "out") continue;
    EXPECT_TRUE(allowed.contains(name)) << name << " has no room";
  }
}

}  // namespace
