// SPDX-License-Identifier: Apache-2.0
/// Tests without a server: site files, addresses, waits, the texts of rows, tables and JSON of answers.
#include "apps/site/site_file.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <limits>
#include <string>
#include <vector>

#include "apps/site/archive.hpp"
#include "apps/site/job/job.hpp"
#include "apps/site/publisher.hpp"
#include "apps/site/run_text.hpp"
#include "core/file.hpp"
#include "core/sha256.hpp"

namespace gyrotherm::site {
namespace {

namespace fs = std::filesystem;

constexpr const char* kWhole = R"(schema = "gyrotherm-site/1"
name = "hall 4"
rig = "chamber-3"
folders = ["runs", "/var/lib/gyrotherm"]
[store]
address = "host=db dbname=gyrotherm user=rig_3 sslmode=verify-full"
passfile = "pgpass"
longest_wait = "5 s"
[archive]
command = ["rclone", "copyto", "{file}", "remote:{sha256}.db"]
[notify]
rule = "of the live page"
)";

std::string without(std::string text, const std::string& what, const std::string& instead = "") {
  text.replace(text.find(what), what.size(), instead);
  return text;
}

std::string mistakes_of(const std::string& text, const std::string& credentials = "") {
  const auto parsed = parse_site(text, "site.toml", credentials);
  return parsed ? "" : parsed.error().where + ": " + parsed.error().what;
}

TEST(SiteFile, SaysRigFoldersStoreAndArchive) {
  const auto site = parse_site(kWhole, "/etc/gyrotherm/site.toml", "").value();
  EXPECT_EQ(site.rig, "chamber-3");
  EXPECT_EQ(site.folders, (std::vector<std::string>{"/etc/gyrotherm/runs", "/var/lib/gyrotherm"}));
  EXPECT_EQ(site.store.passfile, "/etc/gyrotherm/pgpass");
  EXPECT_EQ(site.longest_wait, Duration(std::chrono::seconds(5)));
  EXPECT_EQ(site.archive.command.size(), 4U);
}

TEST(SiteFile, TellsWhatIsWrong) {
  const std::string whole = kWhole;
  EXPECT_NE(mistakes_of(without(whole, "rig =", "rgi =")).find("did you mean \"rig\""), std::string::npos);
  EXPECT_NE(mistakes_of(without(whole, "longest_wait", "longest_wate")).find("longest_wait"), std::string::npos);
  EXPECT_NE(mistakes_of(without(whole, "user=rig_3", "password=secret")).find("use a passfile"), std::string::npos);
  EXPECT_NE(mistakes_of(without(whole, "user=rig_3", "uesr=rig_3")).find("uesr"), std::string::npos);
  EXPECT_NE(mistakes_of(without(whole, "{sha256}")).find("{sha256}"), std::string::npos);
  EXPECT_NE(mistakes_of(without(whole, "\"5 s\"", "\"5 ms\"")).find("100 ms"), std::string::npos);
  EXPECT_NE(mistakes_of(without(whole, "[\"runs\", \"/var/lib/gyrotherm\"]", "[]")).find("folders"), std::string::npos);
  EXPECT_NE(mistakes_of(without(whole, "\"chamber-3\"", "\"\"")).find("is not a name"), std::string::npos);
}

TEST(SiteFile, NamesPositionOfUnusableAddress) {
  const std::string whole = kWhole, address = "host=db dbname=gyrotherm user=rig_3 sslmode=verify-full";
  EXPECT_NE(mistakes_of(without(whole, address, "")).find("site.toml:6:11: \"address\" is empty"), std::string::npos);
  for (const char* port : {"abc", "0", "70000", "5432,x"})
    EXPECT_NE(mistakes_of(without(whole, address, "host=db port=" + std::string(port))).find("site.toml:6:11: port is"),
              std::string::npos)
        << port;
  for (const char* port : {"5432", "5432,5433", "''"})
    EXPECT_EQ(mistakes_of(without(whole, address, "host=db port=" + std::string(port))), "") << port;
}

/// A monitor or an analyst has no rig and no records.
TEST(SiteFile, NeedsOnlyStoreForQueries) {
  const std::string only =
      "schema = \"gyrotherm-site/1\"\n[store]\naddress = \"host=db user=ada\"\npassfile = \"pgpass\"\n";
  const auto store = parse_store(only, "/etc/gyrotherm/site.toml", "").value();
  EXPECT_EQ(store.conninfo, "host=db user=ada");
  EXPECT_EQ(store.passfile, "/etc/gyrotherm/pgpass");
  EXPECT_EQ(parse_store(kWhole, "site.toml", "").value().conninfo, parse_site(kWhole, "site.toml", "")->store.conninfo);
  EXPECT_FALSE(parse_site(only, "site.toml", "")) << "a publisher needs the name of its rig";
  const auto refusal_of = [](const std::string& text) {
    const auto parsed = parse_store(text, "site.toml", "");
    return parsed ? "" : parsed.error().what;
  };
  EXPECT_NE(refusal_of(without(only, "address =", "adress =")).find("did you mean \"address\""), std::string::npos);
  EXPECT_NE(refusal_of(without(only, "[store]", "[stoer]")).find("store"), std::string::npos);
  EXPECT_NE(refusal_of(without(only, "[store]", "rgi = \"a\"\n[store]")).find("rgi"), std::string::npos);
  EXPECT_NE(refusal_of(without(only, "user=ada", "password=secret")).find("use a passfile"), std::string::npos);
  EXPECT_NE(refusal_of(only + "longest_wait = \"5 ms\"\n").find("100 ms"), std::string::npos);
  EXPECT_NE(refusal_of(only + "[live]\nbroker = \"b\"\n").find("[live] is no longer used"), std::string::npos);
}

/// A rig of version 0.1.0 with a broker.
TEST(SiteFile, RefusesLiveTableWithRemedy) {
  const auto read = parse_site(std::string(kWhole) + "[live]\nbroker = \"mqtts://b\"\n", "site.toml", "");
  ASSERT_FALSE(read);
  EXPECT_EQ(read.error().kind, FaultKind::bad_file);
  EXPECT_EQ(read.error().what, "[live] is no longer used, because the store contains the live state; remove it");
}

TEST(SiteFile, TakesACredentialFromTheFolderOfSystemd) {
  const auto text = without(kWhole, "passfile = \"pgpass\"", "credential = \"store\"");
  EXPECT_NE(mistakes_of(text).find("LoadCredential"), std::string::npos);
  const auto store = parse_site(text, "site.toml", "/run/credentials/x").value().store;
  EXPECT_EQ(store.passfile, "/run/credentials/x/store");
  EXPECT_TRUE(store.is_credential);
  EXPECT_FALSE(parse_site(kWhole, "site.toml", "").value().store.is_credential);
}

/// systemd 254 and later give the credential to root, and to the service by an access control list: mode 0440.
TEST(StoreAddress, TakesCredentialThatItsGroupMayRead) {
  const auto path = (fs::temp_directory_path() / ("gyrotherm-credential-" + std::to_string(::getpid()))).string();
  std::ofstream(path) << "*:*:*:*:secret\n";
  const auto find_fault = [&](bool is_credential, const std::string& file) {
    const auto connected = Postgres::connect(
        {.conninfo = "host=/nowhere user=ada dbname=x", .passfile = file, .is_credential = is_credential}, {});
    return connected ? FaultKind::usage : connected.error().kind;
  };
  using enum fs::perms;
  for (const auto mode : {owner_read | group_read, owner_read | owner_write, owner_read}) {
    fs::permissions(path, mode);
    EXPECT_EQ(find_fault(true, path), FaultKind::disconnected) << static_cast<int>(mode);
    const bool is_private = (mode & group_read) == none;
    EXPECT_EQ(find_fault(false, path), is_private ? FaultKind::disconnected : FaultKind::bad_file);
  }
  EXPECT_EQ(find_fault(true, path + ".none"), FaultKind::bad_file);
  fs::remove(path);
}

TEST(Backoff, GrowsToItsLongestByChanceAndStartsAnew) {
  Backoff backoff(std::chrono::seconds(2), 7);
  Duration before{};
  for (const Duration whole : {Duration(std::chrono::milliseconds(250)), Duration(std::chrono::milliseconds(500)),
                               Duration(std::chrono::seconds(1)), Duration(std::chrono::seconds(2)),
                               Duration(std::chrono::seconds(2)), Duration(std::chrono::seconds(2))}) {
    const auto wait = backoff.next();
    EXPECT_GE(wait, whole / 2);
    EXPECT_LE(wait, whole);
    EXPECT_NE(wait, before);
    before = wait;
  }
  backoff.reset();
  EXPECT_LE(backoff.next(), Duration(std::chrono::milliseconds(250)));
}

/// Returns whether a process runs: it exists and is not a zombie.
bool runs(const std::string& pid) {
  const auto status = read_text_file("/proc/" + pid + "/status");
  return status && status->find("State:\tZ") == std::string::npos;
}

TEST(Archive, KillsCommandWithItsChildren) {
  const auto pids = (fs::temp_directory_path() / ("gyrotherm-archive-pids-" + std::to_string(::getpid()))).string();
  for (const std::string script :
       {"sleep 60 & echo $! >> $0; wait", "(sleep 60 & echo $! >> $0; wait) & echo $! >> $0; wait"}) {
    fs::remove(pids);
    const auto failed = archive({.command = {"sh", "-c", script, pids}, .within = std::chrono::milliseconds(500)},
                                {.path = "x", .name = "x", .sha256 = "0", .bytes = 0}, kNoDescriptor);
    ASSERT_FALSE(failed);
    EXPECT_EQ(failed.error().kind, FaultKind::timeout);
    std::ifstream children(pids);
    int seen = 0;
    for (std::string pid; std::getline(children, pid); ++seen) {
      for (int i = 0; i < 200 && runs(pid); ++i) ::usleep(10'000);
      EXPECT_FALSE(runs(pid)) << script;
    }
    EXPECT_GT(seen, 0);
  }
  fs::remove(pids);
}

TEST(LeaveOneOut, RefusesTimeThatContainsNoCluster) {
  const std::vector<std::string> records{"a.db", "b.db", "c.db", "d.db"};
  for (const double hours : {0.0, -1.0, 0.02, 1e9, std::numeric_limits<double>::quiet_NaN()}) {
    const auto job = plan_leave_one_out(records, hours, "out", {});
    ASSERT_FALSE(job) << hours;
    EXPECT_EQ(job.error().kind, FaultKind::usage);
    EXPECT_EQ(job.error().where, "--hours");
  }
  EXPECT_NE(plan_leave_one_out(records, 0.03, "out", {}).error().where, "--hours");
}

TEST(Archive, RunsACommandWithoutAShell) {
  const RunFileDigest file{.path = "/runs/$(reboot) {sha256}.db", .name = "x", .sha256 = "abc", .bytes = 1};
  EXPECT_EQ(expand_command({"rclone", "{file}", "to:{sha256}.db"}, file),
            (std::vector<std::string>{"rclone", "/runs/$(reboot) {sha256}.db", "to:abc.db"}));
}

class InAFolder : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("gyrotherm-archive-" + std::to_string(::getpid()));
    fs::create_directories(folder_ / "kept");
  }
  void TearDown() override { fs::remove_all(folder_); }
  std::string write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name) << text;
    return (folder_ / name).string();
  }
  fs::path folder_;
};

using ArchiveFolder = InAFolder;

TEST_F(ArchiveFolder, KeepsAFileUnderTheNameOfItsBytes) {
  const auto path = write("run.db", "bytes");
  const auto digest = compute_digest(path).value();
  EXPECT_EQ(digest.sha256, sha256("bytes"));
  const ArchiveSettings settings{.folder = (folder_ / "kept").string()};
  ASSERT_TRUE(archive(settings, digest, kNoDescriptor));
  ASSERT_TRUE(archive(settings, digest, kNoDescriptor)) << "again";
  EXPECT_EQ(read_text_file((folder_ / "kept" / (digest.sha256 + ".db")).string()).value(), "bytes");
  EXPECT_EQ(list_folder(folder_ / "kept").size(), 1U);
}

TEST_F(ArchiveFolder, TakesNoFileThatHasChanged) {
  const auto digest = compute_digest(write("run.db", "bytes")).value();
  write("run.db", "other");
  const auto kept = archive({.folder = (folder_ / "kept").string()}, digest, kNoDescriptor);
  ASSERT_FALSE(kept);
  EXPECT_EQ(kept.error().what, "changed while it was copied");
  EXPECT_TRUE(list_folder(folder_ / "kept").empty()) << "nothing half is left";
}

TEST_F(ArchiveFolder, KeepsNothingOfACopyWhoseProgramWasKilled) {
  const auto digest = compute_digest(write("run.db", "bytes")).value();
  const auto target = "kept/" + digest.sha256 + ".db";
  constexpr int kNobody = 2'000'000'000;  // not a process
  write(fmt::format("{}.{}.part", target, kNobody), "by");
  write(fmt::format("{}.{}.part", target, ::getppid()), "byt");
  write(fmt::format("{}.{}.part.old", target, kNobody), "b");
  ASSERT_TRUE(archive({.folder = (folder_ / "kept").string()}, digest, kNoDescriptor));
  EXPECT_EQ(read_text_file((folder_ / target).string()).value(), "bytes");
  EXPECT_EQ(list_folder(folder_ / "kept").size(), 3U) << "beside it what goes on, and what is none of ours";
  EXPECT_FALSE(fs::exists(folder_ / fmt::format("{}.{}.part", target, kNobody)));
}

using DocumentFile = InAFolder;

TEST_F(DocumentFile, IsKnownByItsSchema) {
  EXPECT_EQ(read_document(write("a.json", R"({"schema": "gyrotherm-model/1"})")).value()->kind, "model");
  for (const char* other : {R"({"schema": "gyrotherm-comparison/1"})", "{}", "[1]", "no json", "{\"schema\": 1}"})
    EXPECT_FALSE(read_document(write("b.json", other)).value()) << other;
  EXPECT_FALSE(read_document((folder_ / "none.json").string()));
}

TEST(RunText, HasANumberForEachColumnButSlotAndUtc) {
  record::RunInfo info;
  info.virtual_rig = true;
  info.thermometers = {{.name = "A", .instrument = "i", .offset = {}}};
  info.units = {{.axes = {{.kind = record::GyroKind::pulse_count, .scale = 1}}}};
  std::string names;
  for (const auto& channel : stored_channels(info)) names += channel.name + " ";
  EXPECT_EQ(names,
            "monotonic_ns set_point_c chamber_air_c chamber_set_point_c A pulses interval_ns segment cycle phase "
            "in_segment_ns soaked_ns state true_bias_deg_per_h ");
  info.virtual_rig = false;
  EXPECT_EQ(stored_channels(info).back().name, "state") << "what only a virtual gyro knows";
  EXPECT_EQ(stored_channels(info).back().keywords.size(), kRunStates.size());
}

TEST(RunText, MarksRunOnVirtualInstruments) {
  const auto is_marked = [](const record::RunInfo& info) {
    return run_as_json(info).find("\"simulated\":true") != std::string::npos;
  };
  record::RunInfo info;
  EXPECT_FALSE(is_marked(info));
  info.virtual_instruments = {"chamber"};
  EXPECT_TRUE(is_marked(info));
  info.virtual_instruments.clear();
  info.virtual_rig = true;
  EXPECT_TRUE(is_marked(info));
}

}  // namespace
}  // namespace gyrotherm::site
