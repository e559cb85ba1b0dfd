// SPDX-License-Identifier: Apache-2.0
/// Checks the house rules: permitted includes, sizes of files and functions, banned words.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <string>
#include <vector>

#include "tests/support/source_functions.hpp"

#ifdef NDEBUG
#error "Assertions stay on in every build: see CMAKE_CXX_FLAGS_* in CMakeLists.txt."
#endif

namespace {

namespace fs = std::filesystem;

using gyrotherm::scan_functions;

const fs::path kRoot = GYROTHERM_SOURCE_DIR;
const std::vector<std::string> kModules{"core",      "drivers",  "simulator", "acquisition",
                                        "sequencer", "analysis", "report",    "apps"};

/// Module → the modules whose headers it may include. Each module lists only modules that precede it in kModules.
const std::map<std::string, std::set<std::string>> kModuleDependencies{
    {"core", {}},
    {"drivers", {"core"}},
    {"simulator", {"core", "drivers"}},
    {"acquisition", {"core", "drivers"}},
    {"sequencer", {"core", "drivers", "simulator", "acquisition"}},
    {"analysis", {"core", "acquisition"}},
    {"report", {"core", "analysis"}},
    {"apps", {"core", "drivers", "simulator", "acquisition", "sequencer", "analysis", "report"}},
};

/// Part of a module → the other parts whose headers it may include. A part is a module, or a folder of a module that
/// has its own library.
const std::map<std::string, std::set<std::string>> kPartDependencies{
    {"core", {}},
    {"drivers", {"core"}},
    {"simulator/thermal/reduced", {"core"}},
    {"simulator/thermal", {"core", "simulator/thermal/reduced"}},
    {"simulator", {"core", "drivers", "simulator/thermal/reduced"}},
    {"acquisition/io", {"core", "drivers"}},
    {"acquisition/record", {"core"}},
    {"acquisition/exchange", {"core", "acquisition/record"}},
    {"sequencer/control", {"core"}},
    {"sequencer/profile", {"core"}},
    {"sequencer/interlocks", {"core", "sequencer/profile"}},
    {"sequencer/rig",
     {"core", "drivers", "acquisition/io", "acquisition/record", "sequencer/profile", "sequencer/interlocks",
      "simulator"}},
    {"sequencer/run",
     {"core", "drivers", "acquisition/io", "acquisition/record", "sequencer/control", "sequencer/profile",
      "sequencer/interlocks", "sequencer/watchdog", "sequencer/rig"}},
    {"sequencer/watchdog", {"core", "drivers"}},
    {"sequencer/prove",
     {"core", "drivers", "sequencer/interlocks", "sequencer/watchdog", "sequencer/rig", "sequencer/run"}},
    {"analysis/dense", {}},
    {"analysis/data", {"core", "acquisition/record"}},
    {"analysis/svm", {"core"}},
    {"analysis/methods", {"core", "analysis/data", "analysis/svm"}},
    {"analysis/tracking", {"core", "analysis/data", "analysis/methods"}},
    {"analysis/fusion", {"core", "analysis/data"}},
    {"analysis/population", {"core", "analysis/data", "analysis/methods"}},
    {"analysis/model",
     {"core", "analysis/data", "analysis/svm", "analysis/methods", "analysis/tracking", "analysis/fusion",
      "analysis/population"}},
    {"analysis/planning", {"core", "analysis/data", "analysis/methods", "analysis/population", "analysis/model"}},
    {"analysis/assurance", {"core", "acquisition/record", "analysis/data"}},
    {"report/plot", {"core"}},
    {"report/standard", {"core", "analysis/assurance", "report/plot"}},
    {"report",
     {"core", "analysis/data", "analysis/svm", "analysis/methods", "analysis/model", "analysis/assurance",
      "report/plot", "report/standard"}},
    {"apps/console", {"core"}},
    {"apps/make_safe", {"core", "sequencer/watchdog"}},
    {"apps/pdf", {"core", "report/plot", "report"}},
    {"apps/gyrotherm",
     {"core",
      "drivers",
      "acquisition/io",
      "acquisition/record",
      "acquisition/exchange",
      "sequencer/control",
      "sequencer/profile",
      "sequencer/interlocks",
      "sequencer/run",
      "sequencer/prove",
      "sequencer/watchdog",
      "sequencer/rig",
      "analysis/data",
      "analysis/svm",
      "analysis/methods",
      "analysis/model",
      "analysis/planning",
      "analysis/assurance",
      "analysis/tracking",
      "analysis/fusion",
      "analysis/population",
      "report",
      "report/plot",
      "report/standard",
      "simulator",
      "apps/console"}},
    {"apps/monitor",
     {"core", "acquisition/record", "sequencer/profile", "sequencer/control", "analysis/assurance", "report/plot",
      "report/standard"}},
    {"apps/site", {"core", "acquisition/record", "analysis/assurance", "report/standard", "apps/site/job"}},
    {"apps/site/job", {"core", "acquisition/record"}},
    {"apps/thermal",
     {"core", "report", "report/plot", "simulator/thermal", "simulator/thermal/reduced", "apps/console"}},
};

/// Part → prefixes of the third-party headers that it may include. fmt and tl::expected are allowed everywhere.
const std::map<std::string, std::vector<std::string>> kThirdParties{
    {"core", {"toml++/", "nlohmann/", "openssl/"}},
    {"drivers", {"modbus/", "libserialport.h", "hidapi.h"}},
    {"acquisition/io", {}},
    {"acquisition/record", {"sqlite3.h"}},
    {"acquisition/exchange", {"netcdf.h"}},
    {"sequencer/control", {}},
    {"sequencer/profile", {}},
    {"sequencer/interlocks", {}},
    {"sequencer/run", {}},
    {"sequencer/watchdog", {}},
    {"analysis/dense", {"Eigen/"}},
    {"analysis/data", {"Eigen/", "boost/math/"}},
    {"analysis/svm", {"Eigen/", "tbb/", "oneapi/"}},
    {"analysis/methods", {"Eigen/", "tbb/", "oneapi/"}},
    {"analysis/tracking", {"Eigen/"}},
    {"analysis/fusion", {"Eigen/"}},
    {"analysis/population", {"Eigen/"}},
    {"analysis/model", {"Eigen/", "tbb/", "oneapi/"}},
    {"analysis/planning", {"Eigen/"}},
    {"analysis/assurance", {"Eigen/"}},
    {"report/plot", {"png.h"}},
    {"simulator/thermal/reduced", {"Eigen/"}},
    {"simulator/thermal", {"Eigen/", "HYPRE", "mpi.h"}},
    {"simulator", {"Eigen/"}},
    {"sequencer/rig", {}},
    {"report", {"Eigen/", "Q"}},
    {"apps/pdf", {"CLI/"}},
    {"apps/console", {"CLI/"}},
    {"apps/gyrotherm", {"Q", "CLI/", "Eigen/"}},
    {"apps/make_safe", {}},
    {"apps/thermal", {"Eigen/"}},
    {"apps/monitor", {"nlohmann/", "boost/", "sodium.h", "curl/", "openssl/", "CLI/"}},
    {"apps/site", {"nlohmann/", "libpq-fe.h", "CLI/"}},
    {"apps/site/job", {"CLI/"}},
};

/// Returns the part that contains a path relative to the root; empty if there is none.
std::string find_part(const std::string& path) {
  std::string best;
  for (const auto& [part, allowed] : kPartDependencies)
    if (path.starts_with(part + "/") && part.size() > best.size()) best = part;
  return best;
}

struct Source {
  fs::path path;
  std::string module;
  std::string part;
  std::vector<std::string> lines;
  [[nodiscard]] std::string at(std::size_t line) const {
    return fmt::format("{}:{}", fs::relative(path, kRoot).string(), line + 1);
  }
};

std::vector<std::string> read_lines(const fs::path& path) {
  std::ifstream file(path);
  std::vector<std::string> lines;
  for (std::string line; std::getline(file, line);) lines.push_back(line);
  return lines;
}

std::vector<Source> sources_in(const std::vector<std::string>& folders) {
  std::vector<Source> found;
  for (const auto& folder : folders)
    for (const auto& entry : fs::recursive_directory_iterator(kRoot / folder))
      if (const auto extension = entry.path().extension(); extension == ".hpp" || extension == ".cpp")
        found.push_back(
            {entry.path(), folder, find_part(fs::relative(entry.path(), kRoot).string()), read_lines(entry.path())});
  return found;
}

/// Returns every .hpp and .cpp file of the modules.
const std::vector<Source>& sources() {
  static const std::vector<Source> all = [] {
    auto found = sources_in(kModules);
    EXPECT_GT(found.size(), 600u);
    return found;
  }();
  return all;
}

/// Returns every .hpp and .cpp file of the tests and benchmarks except this one, which contains the banned words.
const std::vector<Source>& test_and_bench_sources() {
  static const std::vector<Source> all = [] {
    auto found = sources_in({"tests", "bench"});
    std::erase_if(found, [](const Source& source) { return source.path.filename() == "tidy_test.cpp"; });
    EXPECT_GT(found.size(), 450u);
    return found;
  }();
  return all;
}

std::vector<Source> all_sources() {
  auto all = sources();
  all.insert(all.end(), test_and_bench_sources().begin(), test_and_bench_sources().end());
  return all;
}

TEST(House, AssignsEachFileToPartOfModule) {
  for (const auto& source : sources()) EXPECT_TRUE(kPartDependencies.contains(source.part)) << source.at(0);
}

TEST(House, IncludesPointOneWay) {
  const std::regex include(R"re(^#include "([a-z_0-9/]+)/[a-z_0-9]+\.hpp")re");
  std::size_t includes = 0;
  for (const auto& source : sources())
    for (std::size_t i = 0; i < source.lines.size(); ++i) {
      std::smatch match;
      if (!std::regex_search(source.lines[i], match, include)) continue;
      const auto part = find_part(match[1].str() + "/");
      EXPECT_TRUE(part == source.part || kPartDependencies.at(source.part).contains(part))
          << source.at(i) << ": " << source.part << " may not include " << match[1];
      ++includes;
    }
  EXPECT_GT(includes, 2000u);
}

TEST(House, ModulesDependOneWay) {
  const std::regex include(R"re(^#include "([a-z_0-9]+)/[a-z_0-9/]+\.hpp")re");
  std::set<std::pair<std::string, std::string>> dependencies;
  for (const auto& source : sources())
    for (std::size_t i = 0; i < source.lines.size(); ++i) {
      std::smatch match;
      if (!std::regex_search(source.lines[i], match, include) || match[1] == source.module) continue;
      dependencies.emplace(source.module, match[1]);
      EXPECT_TRUE(kModuleDependencies.at(source.module).contains(match[1]))
          << source.at(i) << ": " << source.module << " may not include " << match[1];
    }
  EXPECT_GT(dependencies.size(), 10u);
  std::set<std::string> before;
  for (const auto& module : kModules) {
    for (const auto& below : kModuleDependencies.at(module))
      EXPECT_TRUE(before.contains(below)) << module << " → " << below;
    before.insert(module);
  }
}

/// Tests of different modules share only headers in tests/support. Only tests/bench includes headers of bench.
TEST(House, TestsAndBenchmarksIncludeOnlySharedHeaders) {
  const std::regex include(R"re(^#include "((tests|bench)/[a-z_0-9]+)/.*")re");
  std::size_t includes = 0;
  for (const auto& source : test_and_bench_sources())
    for (std::size_t i = 0; i < source.lines.size(); ++i) {
      std::smatch match;
      if (!std::regex_search(source.lines[i], match, include) || match[1] == "tests/support") continue;
      const auto path = fs::relative(source.path, kRoot).string();
      EXPECT_TRUE(path.starts_with(match[1].str() + "/") || (path.starts_with("tests/bench/") && match[2] == "bench"))
          << source.at(i) << ": move it to tests/support, or to bench/: " << match[1];
      ++includes;
    }
  EXPECT_GT(includes, 100u);
}

TEST(House, ThirdPartyHeadersAreIncludedInTheirModulesOnly) {
  const std::regex include(R"(^#include <([^>]+)>)");
  const std::vector<std::string> known{"toml++/",  "modbus/",         "sqlite3.h", "nlohmann/", "Eigen/", "tbb/",
                                       "oneapi/",  "boost/",          "Q",         "CLI/",      "png.h",  "HYPRE",
                                       "mpi.h",    "libserialport.h", "hidapi.h",  "sodium.h",  "curl/",  "openssl/",
                                       "netcdf.h", "libpq-fe.h"};
  const auto starts = [](const std::string& header, const std::vector<std::string>& with) {
    return std::any_of(with.begin(), with.end(), [&](const auto& prefix) { return header.starts_with(prefix); });
  };
  std::size_t includes = 0;
  for (const auto& source : sources())
    for (std::size_t i = 0; i < source.lines.size(); ++i) {
      std::smatch match;
      if (!std::regex_search(source.lines[i], match, include) || !starts(match[1], known)) continue;
      EXPECT_TRUE(starts(match[1], kThirdParties.at(source.part))) << source.at(i) << ": " << match[1];
      ++includes;
    }
  EXPECT_GT(includes, 100u);
}

TEST(House, HeadersIncludeNoThirdPartyHeaders) {
  const std::regex include(
      R"(^#include <(toml\+\+/|modbus/|libserialport|hidapi|sqlite3\.h|libpq|nlohmann/|Q[A-Z]|HYPRE|mpi\.h))");
  for (const auto& source : sources()) {
    const bool is_program =
        source.module == "apps" && !source.part.starts_with("apps/monitor") && !source.part.starts_with("apps/site");
    if (source.path.extension() != ".hpp" || is_program) continue;
    if (source.path.stem() == "sqlite" || source.path.stem() == "json") continue;  // wrappers for .cpp files only
    for (std::size_t i = 0; i < source.lines.size(); ++i)
      EXPECT_FALSE(std::regex_search(source.lines[i], include)) << source.at(i) << ": third party in a header";
  }
}

TEST(House, OnlySourcesIncludeThirdPartyWrappers) {
  for (const auto& source : sources()) {
    const bool is_header = source.path.extension() == ".hpp";
    for (std::size_t i = 0; i < source.lines.size(); ++i)
      EXPECT_FALSE(is_header && source.lines[i] == "#include \"core/json.hpp\"") << source.at(i);
  }
}

/// Returns the expected innermost namespace of a source: the name of its last folder in gyrotherm, with exceptions.
std::string expected_namespace(const Source& source) {
  static const std::map<std::string, std::string> exceptions{{"core", "gyrotherm"},
                                                             {"apps/console", "gyrotherm::app"},
                                                             {"apps/gyrotherm", "gyrotherm::app"},
                                                             {"apps/thermal", "gyrotherm::app"},
                                                             {"apps/make_safe", "gyrotherm::watchdog"},
                                                             {"simulator/thermal/reduced", "gyrotherm::thermal"},
                                                             {"apps/site/job", "gyrotherm::site"}};
  if (const auto found = exceptions.find(source.part); found != exceptions.end()) return found->second;
  return "gyrotherm::" + source.part.substr(source.part.find('/') + 1);
}

TEST(House, EachPartHasItsNamespace) {
  std::size_t seen = 0;
  for (const auto& source : sources()) {
    std::string last;  // earlier ones may be opened for declarations or specialisations
    for (const auto& line : source.lines)
      if (line.starts_with("namespace gyrotherm")) last = line;
    if (last.empty()) continue;
    EXPECT_EQ(last, "namespace " + expected_namespace(source) + " {") << source.at(0);
    ++seen;
  }
  EXPECT_GT(seen, 600u);
}

TEST(House, EachSourceStatesItsLicence) {
  for (const auto& source : all_sources())
    EXPECT_EQ(source.lines.front(), "// SPDX-License-Identifier: Apache-2.0") << source.at(0);
}

TEST(House, FilesHaveOneSubject) {
  for (const auto& source : all_sources()) EXPECT_LE(source.lines.size(), 800u) << source.at(0) << ": split this file";
}

std::size_t display_width(const std::string& line) {
  return static_cast<std::size_t>(
      std::count_if(line.begin(), line.end(), [](unsigned char byte) { return (byte & 0xC0) != 0x80; }));
}

constexpr std::size_t kMaxWidth = 120;

TEST(House, LinesAreAtMost120Characters) {
  for (const auto& source : all_sources())
    for (std::size_t i = 0; i < source.lines.size(); ++i)
      EXPECT_LE(display_width(source.lines[i]), kMaxWidth) << source.at(i) << ": too wide";
}

/// Rows of tables and code may be wider.
TEST(House, LinesOfDocumentsAreAtMost120Characters) {
  std::vector<fs::path> documents;
  for (const auto* folder : {"", "docs", "docs/decisions", "docs/how-to", "docs/reference", "docs/tutorial", "bench",
                             "profiles", "profiles/analogue-inputs", "profiles/gyro-streams", "tests/edges"})
    for (const auto& entry : fs::directory_iterator(kRoot / folder))
      if (entry.path().extension() == ".md") documents.push_back(entry.path());
  EXPECT_GT(documents.size(), 30u);
  for (const auto& path : documents) {
    bool code = false;
    int number = 0;
    for (const auto& line : read_lines(path)) {
      ++number;
      if (line.find("```") != std::string::npos) code = !code;
      if (code || line.starts_with("|") || line.starts_with("    ")) continue;
      EXPECT_LE(display_width(line), kMaxWidth) << fs::relative(path, kRoot).string() << ":" << number << ": too wide";
    }
  }
}

TEST(House, FunctionsAreShort) {
  std::size_t functions = 0, wrapped = 0;
  for (const auto& source : sources()) {
    const auto scanned = scan_functions(fmt::format("{}\n", fmt::join(source.lines, "\n")));
    EXPECT_TRUE(scanned.is_balanced) << source.at(0) << ": the scanner finds unbalanced braces";
    for (const auto& function : scanned.functions) {
      EXPECT_LE(function.lines(), 70u) << source.at(function.first_line - 1) << ": shorten this function";
      if (source.lines[function.first_line - 1].find('{') == std::string::npos) ++wrapped;
    }
    functions += scanned.functions.size();
  }
  EXPECT_GT(functions, 7000u);
  EXPECT_GT(wrapped, 400u);
}

/// Returns the signatures that the scanner finds, each with its first and its last line.
std::vector<std::string> scan_signatures(const std::string& source) {
  const auto scanned = scan_functions(source);
  EXPECT_TRUE(scanned.is_balanced) << source;
  std::vector<std::string> found;
  for (const auto& function : scanned.functions)
    found.push_back(fmt::format("{}-{} {}", function.first_line, function.last_line, function.signature));
  return found;
}
using Found = std::vector<std::string>;

TEST(FunctionScanner, FindsWrappedSignatures) {
  EXPECT_EQ(scan_signatures("namespace a {\nint sum(int first,\n        int second) {\n  return first;\n}\n}\n"),
            (Found{"2-5 int sum(int first, int second)"}));
  EXPECT_EQ(scan_signatures("template <class T,\n          class U = T>\nauto f(T t) -> std::vector<T> {\n}\n"),
            (Found{"1-4 template <class T, class U = T> auto f(T t) -> std::vector<T>"}));
  EXPECT_EQ(scan_signatures("std::map<int,\n         int>\nC::f()\n    const noexcept {}\n"),
            (Found{"1-4 std::map<int, int> C::f() const noexcept"}));
}

TEST(FunctionScanner, FindsMembersAndConstructorsWithInitialisers) {
  const std::string source = R"(class C : public B<int> {
 public:
  explicit C(int n)
      : n_(n), list_{1, 2},
        work_([this] { run(); }),
        base_<int>{n} {
    run();
  }
  ~C() { stop(); }
  C& operator=(const C&) = delete;
  bool operator==(const C& other) const { return n_ == other.n_; }
  int operator()(int x) const { return x; }

 private:
  int n_{}, m_ = 3;
  std::function<void(int)> f_{[](int) {}};
  struct Inner {
    void g() {}
  };
};)";
  EXPECT_EQ(
      scan_signatures(source),
      (Found{"3-8 explicit C(int n) : n_(n), list_{ }, work_([this] { run(); }), base_<int>{ }", "9-9 ~C()",
             "11-11 bool operator==(const C& other) const", "12-12 int operator()(int x) const", "18-18 void g()"}));
}

TEST(FunctionScanner, SkipsBracesInLiteralsAndComments) {
  const std::string source = R"code(// a brace {
#define OPEN {
/* another { */ const char* const kText = R"({ "( )";
const std::string kRaw = R"x({ )" { )x";
const char kBrace = '{', kQuote = '\'';
constexpr int kMany = 10'000;
void f() {
  const char* text = "}\"}";  // }
  use(text, '}', 1'0);
}
)code";
  EXPECT_EQ(scan_signatures(source), (Found{"7-10 void f()"}));
}

TEST(FunctionScanner, DistinguishesValuesTypesAndNamespacesFromFunctions) {
  const std::string source = R"(extern "C" {
int c_function(void) { return 0; }
}
enum class Colour { red, green };
const std::map<std::string, std::function<int(int)>> kTable{{"a", [](int x) { return x; }}};
const auto kMade = make(3, [] {
  return 4;
});
constexpr Pair kPair = Pair(1){2};
struct Plain {
  int x = 3, y{4};
};
struct stat status_of(int file) { return {}; }
template <>
struct LineOf<float> {
  using Line = float __attribute__((vector_size(64)));
};
)";
  EXPECT_EQ(scan_signatures(source), (Found{"2-2 int c_function(void)", "13-13 struct stat status_of(int file)"}));
}

TEST(FunctionScanner, ReportsUnmatchedBrace) {
  EXPECT_FALSE(scan_functions("void f() { if (x) { }\n").is_balanced);
  EXPECT_FALSE(scan_functions("namespace a {\nvoid f() {}\n").is_balanced);
  EXPECT_FALSE(scan_functions("void f() {} }\n").is_balanced);
}

struct Ban {
  /// Texts of which a line with the word contains one. A search for them takes a tenth of the time of the expression.
  std::vector<std::string_view> hints;
  std::regex word;
  std::string instead;
  std::set<std::string> allowed;  ///< modules or their parts
};

void expect_no_banned_words(const std::vector<Ban>& bans, const std::vector<Source>& in) {
  for (const auto& source : in)
    for (std::size_t i = 0; i < source.lines.size(); ++i)
      for (const auto& ban : bans) {
        const std::string& line = source.lines[i];
        if (std::ranges::none_of(ban.hints, [&](std::string_view hint) { return line.find(hint) != line.npos; }))
          continue;
        if (ban.allowed.contains(source.module) || ban.allowed.contains(source.part)) continue;
        EXPECT_FALSE(std::regex_search(line, ban.word))
            << source.at(i) << ": banned here; use instead: " << ban.instead << "\n"
            << line;
      }
}

TEST(House, BannedWordsAreNotUsed) {
  const std::vector<Ban> bans{
      {{"TODO", "FIXME", "XXX", "HACK"}, std::regex(R"(\b(TODO|FIXME|XXX|HACK)\b)"), "fix it, or file an issue", {}},
      {{"using namespace"}, std::regex(R"(\busing namespace\b)"), "a using declaration for each name", {}},
      {{"Manager", "Helper", "Utils", "Impl"},
       std::regex(R"(\b(?!ModemManager\b)\w*(Manager|Helper|Utils|Impl)\b)"),
       "a specific noun",
       {}},
      {{"get_"},
       std::regex(R"((^|[^:.>\w])get_[a-z_]+\()"),
       "a noun: result(), not get_result()",
       {"bench"}},  // pagmo needs it
      {{"rand"}, std::regex(R"(\bstd::rand\b|\brand\(\))"), "a seeded engine", {}},
      {{"modbus_"}, std::regex(R"(\bmodbus_(set|get)_float)"), "drivers/chamber/register_item", {}},
      {{"system_clock"}, std::regex(R"(\bsystem_clock\b)"), "Clock", {"core"}},
  };
  expect_no_banned_words(bans, all_sources());
}

/// Bans words in the program that are allowed in tests.
TEST(House, WordsBannedFromProgramAreNotUsed) {
  const std::vector<Ban> bans{
      {{"sleep"},
       std::regex(R"(\bsleep_for\b|\busleep\b|\bnanosleep\b)"),
       "an injected Clock",
       {"apps", "sequencer/watchdog"}},
      {{"throw"}, std::regex(R"(\bthrow\b)"), "Result", {}},
      {{"istreambuf"}, std::regex(R"(\bistreambuf_iterator\b)"), "getline, which does not throw if a read fails", {}},
      {{"directory_iterator"},
       std::regex(R"(: (std::file|f)s(ystem)?::(recursive_)?directory_iterator)"),
       "list_folder",
       {}},
      {{"cout", "printf"}, std::regex(R"(\bstd::cout\b|\bprintf\()"), "the program's own output", {"apps"}},
      {{"fmt::print"}, std::regex(R"(\bfmt::print\()"), "write_to_stdout or write_to_stderr, which do not throw", {}},
  };
  expect_no_banned_words(bans, sources());
}

/// CMake's default flags define NDEBUG for every build type but Debug. The project sets its own flags for each build
/// type that a preset uses.
TEST(House, EachPresetCompilesWithAssertions) {
  const auto whole = [](const fs::path& path) {
    std::string text;
    for (const auto& line : read_lines(path)) text += line + "\n";
    return text;
  };
  const auto presets = whole(kRoot / "CMakePresets.json");
  const auto lists = whole(kRoot / "CMakeLists.txt");
  EXPECT_EQ(presets.find("NDEBUG"), std::string::npos);
  EXPECT_EQ(lists.find("NDEBUG"), std::string::npos);
  const std::regex type(R"re("CMAKE_BUILD_TYPE": "([^"]+)")re");
  std::size_t types = 0;
  for (std::sregex_iterator at(presets.begin(), presets.end(), type), end; at != end; ++at, ++types) {
    std::string name = (*at)[1];
    std::transform(name.begin(), name.end(), name.begin(),
                   [](unsigned char letter) { return static_cast<char>(std::toupper(letter)); });
    EXPECT_NE(lists.find("set(CMAKE_CXX_FLAGS_" + name + " \""), std::string::npos) << (*at)[1];
  }
  EXPECT_GT(types, 0u);
}

/// The documents show scripts as commands.
TEST(House, ScriptsAreExecutable) {
  int scripts = 0;
  for (const std::string folder : {"bench", "debian", "profiles", "tests"}) {
    for (const auto& entry : fs::recursive_directory_iterator(kRoot / folder)) {
      if (!entry.is_regular_file()) continue;
      std::string first;
      std::getline(std::ifstream(entry.path()), first);
      if (!first.starts_with("#!")) continue;
      EXPECT_NE(entry.status().permissions() & fs::perms::owner_exec, fs::perms::none) << entry.path() << ": chmod +x";
      ++scripts;
    }
  }
  EXPECT_GT(scripts, 20);
}

/// Returns the first group of each match of a pattern in a text.
std::set<std::string> find_matches(const std::string& text, const char* pattern) {
  std::set<std::string> found;
  const std::regex one(pattern);
  for (std::sregex_iterator match(text.begin(), text.end(), one), end; match != end; ++match)
    found.insert((*match)[1].str());
  return found;
}

std::string read_text(const fs::path& path) { return fmt::format("{}", fmt::join(read_lines(path), "\n")); }

/// Sources refer to sections of docs/errata.md, rows of docs/invariants.md and numbers of docs/decisions.
TEST(House, ReferencesToErrataInvariantsAndDecisionsResolve) {
  const auto sections = find_matches(read_text(kRoot / "docs/errata.md"), R"((?:^|\n)##+ (\d+(?:\.\d+)?)\.? )");
  const auto invariants = find_matches(read_text(kRoot / "docs/invariants.md"), R"(\n\| (I\d+) \|)");
  std::set<std::string> decisions;
  for (const auto& entry : fs::directory_iterator(kRoot / "docs/decisions"))
    decisions.insert(entry.path().filename().string().substr(0, 4));
  EXPECT_GT(sections.size(), 10u);
  EXPECT_EQ(invariants.size(), 29u);
  std::size_t references = 0;
  for (fs::recursive_directory_iterator entry(kRoot), end; entry != end; ++entry) {
    const auto path = fs::relative(entry->path(), kRoot).generic_string();
    const auto ending = entry->path().extension();
    if (path == "build" || path == "out" || path == ".git") entry.disable_recursion_pending();
    if (ending != ".cpp" && ending != ".hpp" && ending != ".py" && ending != ".md") continue;
    const auto text = read_text(entry->path());
    const auto expect_in = [&](const std::set<std::string>& known, const char* pattern) {
      for (const auto& reference : find_matches(text, pattern)) {
        EXPECT_TRUE(known.contains(reference)) << path << ": " << pattern << ": " << reference;
        ++references;
      }
    };
    expect_in(sections, R"(\berrata (\d+(?:\.\d+)?))");
    expect_in(decisions, R"(decisions?[ /](\d{4})\b)");
    if (path.starts_with("tests/sequencer") || path.starts_with("tests/mutants"))
      expect_in(invariants, R"(\b(I\d{1,2})\b)");
  }
  EXPECT_GT(references, 50u);
}

/// The last column of docs/glossary.md contains names that are not used.
TEST(House, NamesFollowGlossary) {
  std::set<std::string> banned_names;
  for (const auto& line : read_lines(kRoot / "docs/glossary.md"))
    if (line.starts_with("| "))
      banned_names.merge(find_matches(line.substr(line.rfind('|', line.size() - 2)), R"(`(\w+)`)"));
  EXPECT_GT(banned_names.size(), 20u);
  const std::regex banned_name(fmt::format("\\b(?:{})\\b", fmt::join(banned_names, "|")));
  for (const auto& source : all_sources())
    for (std::size_t i = 0; i < source.lines.size(); ++i)
      EXPECT_FALSE(std::regex_search(source.lines[i], banned_name)) << source.at(i) << ": see docs/glossary.md";
}

TEST(House, TopLevelContainsOnlyModules) {
  std::set<std::string> allowed{"ARCHITECTURE.md",
                                "CHANGELOG.md",
                                "CITATION.cff",
                                "CMakeLists.txt",
                                "CMakePresets.json",
                                "CONTRIBUTING.md",
                                "LICENSE",
                                "README.md",
                                "SECURITY.md",
                                "bench",
                                "cmake",
                                "debian",
                                "docs",
                                "profiles",
                                "python",
                                "tests"};
  allowed.insert(kModules.begin(), kModules.end());
  std::set<std::string> found;
  for (const auto& entry : fs::directory_iterator(kRoot)) {
    const auto name = entry.path().filename().string();
    if (name.starts_with('.') || name == "build" || name == "out") continue;
    found.insert(name);
  }
  EXPECT_EQ(found, allowed);
}

}  // namespace
