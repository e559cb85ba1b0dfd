// SPDX-License-Identifier: Apache-2.0
#include "report/other_program.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <string>
#include <thread>
#include <tuple>
#include <vector>

#include "core/file.hpp"
#include "report/dcc.hpp"
#include "report/signature.hpp"
#include "tests/report/signing_keys.hpp"
#include "tests/support/folder.hpp"
#include "tests/support/sample_calibration.hpp"

namespace gyrotherm::report {
namespace {

/// Replaces a program by a script that makes the file "reached" and waits, if its arguments contain a text.
class HangingProgram {
 public:
  HangingProgram(const tests::TestFolder& folder, const std::string& program, const std::string& arguments)
      : path_(std::getenv("PATH")) {
    const std::string script = folder / program;
    (void)replace_text_file(script, fmt::format("#!/bin/sh\ncase \"$*\" in *'{}'*) : > '{}'; exec sleep 60;; esac\n"
                                                "PATH='{}' exec {} \"$@\"\n",
                                                arguments, folder / "reached", path_, program));
    std::filesystem::permissions(script, std::filesystem::perms::owner_all);
    ::setenv("PATH", (std::filesystem::path(script).parent_path().string() + ":" + path_).c_str(), 1);
  }
  ~HangingProgram() { ::setenv("PATH", path_.c_str(), 1); }
  HangingProgram(const HangingProgram&) = delete;
  HangingProgram& operator=(const HangingProgram&) = delete;

 private:
  std::string path_;
};

/// Sends a signal to a process that signs, as soon as the file `reached` exists. Returns the signal that ended it; 0 if
/// it ended by itself.
int signal_signing_process(const std::function<void()>& sign, const std::string& reached, int signal) {
  const pid_t child = ::fork();
  if (child == 0) {
    sign();
    ::_exit(0);
  }
  int status = 0;
  while (!std::filesystem::exists(reached) && ::waitpid(child, &status, WNOHANG) == 0)
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  EXPECT_TRUE(std::filesystem::exists(reached)) << "it did not wait";
  if (!std::filesystem::exists(reached)) return 0;
  ::kill(child, signal);
  ::waitpid(child, &status, 0);
  return WIFSIGNALED(status) ? WTERMSIG(status) : 0;
}

/// Fails the test if a file below a folder contains a private key in clear, or a key store opens without a password.
void expect_no_key(const std::string& folder) {
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    if (entry.is_regular_file())
      EXPECT_EQ(read_text_file(entry.path(), kLargestTable).value_or("").find("PRIVATE KEY"), std::string::npos)
          << entry.path();
    if (entry.path().filename() != "key4.db") continue;
    const auto keys =
        run_program("certutil", {"-K", "-d", "sql:" + entry.path().parent_path().string(), "-f", "/dev/null"});
    ASSERT_TRUE(keys) << text(keys.error());
    EXPECT_NE(keys->exit_code, 0) << keys->out;
  }
}

/// SIGKILL leaves the folder, but no key in it.
TEST(Signing, LeavesNoKeyWhenEndedBySignal) {
  const Keys keys;
  const tests::TestFolder files;
  SigningKey key = keys.key("lab");
  key.key_file = keys / "locked.key";
  key.password_file = keys / "password";
  const std::string pdf = files / "report.pdf", out = files / "signed.pdf";
  ASSERT_TRUE(replace_text_file(pdf, pdf_of("Bias 0.0021 deg/h", "page 2")));
  const std::function<void()> pdf_signing = [&] { (void)sign_pdf(pdf, out, key, "a test"); };
  const std::function<void()> bytes_signing = [&] { (void)sign_bytes("a protocol", key); };
  const std::function<void()> dcc_signing = [&] {
    (void)sign_dcc(make_dcc(sample_calibration(), {.files = {}}).value(), key);
  };
  const std::array<std::tuple<const char*, const char*, const std::function<void()>*>, 6> moments{
      {{"openssl", "-pubout", &bytes_signing},
       {"openssl", "cms -sign", &bytes_signing},
       {"openssl", "pkcs12", &pdf_signing},
       {"pk12util", "-i", &pdf_signing},
       {"pdfsig", "-nssdir", &pdf_signing},
       {"xmlsec1", "--sign", &dcc_signing}}};
  for (const auto& [program, arguments, sign] : moments)
    for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGKILL}) {
      SCOPED_TRACE(fmt::format("{} {}, signal {}", program, arguments, signal));
      const tests::TestFolder programs, temporary;
      const std::string folder = std::filesystem::path(temporary / "x").parent_path();
      ::setenv("XDG_RUNTIME_DIR", folder.c_str(), 1);
      const HangingProgram hanging(programs, program, arguments);
      EXPECT_EQ(signal_signing_process(*sign, programs / "reached", signal), signal);
      ::unsetenv("XDG_RUNTIME_DIR");
      EXPECT_EQ(list_folder(folder).empty(), signal != SIGKILL);
      expect_no_key(folder);
    }
}

int counted_signals = 0;
void count_signal(int) { ++counted_signals; }

/// Sets the action of a signal and restores the previous one at the end.
class SignalAction {
 public:
  SignalAction(int signal, void (*action)(int)) : signal_(signal), before_(std::signal(signal, action)) {}
  ~SignalAction() { std::signal(signal_, before_); }
  SignalAction(const SignalAction&) = delete;
  SignalAction& operator=(const SignalAction&) = delete;

 private:
  int signal_;
  void (*before_)(int);
};

TEST(OtherProgram, IsEndedBySignalBeforeFoldersAreRemoved) {
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    const SignalAction counting(signal, count_signal);
    counted_signals = 0;
    {
      const auto outer = PrivateFolder::make();
      ASSERT_TRUE(outer);
      {
        const auto inner = PrivateFolder::make();
        ASSERT_TRUE(inner);
        std::raise(signal);
        const auto run = run_program("sleep", {"60"});
        ASSERT_FALSE(run);
        EXPECT_EQ(run.error().kind, FaultKind::interrupted);
      }
      EXPECT_EQ(counted_signals, 0) << "a folder is left";
    }
    EXPECT_EQ(counted_signals, 1);
    EXPECT_TRUE(run_program("true", {}));
  }
}

TEST(OtherProgram, IgnoresIgnoredHangup) {
  const SignalAction ignoring(SIGHUP, SIG_IGN);
  const auto folder = PrivateFolder::make();
  ASSERT_TRUE(folder);
  std::raise(SIGHUP);
  EXPECT_TRUE(run_program("true", {}));
}

TEST(OtherProgram, HasSignalMaskOfCaller) {
  const std::vector<std::string> arguments{"SigBlk", "/proc/self/status"};
  const auto before = run_program("grep", arguments);
  const auto folder = PrivateFolder::make();
  const auto during = run_program("grep", arguments);
  ASSERT_TRUE(before && during);
  EXPECT_NE(before->out, "");
  EXPECT_EQ(during->out, before->out);
}

TEST(OtherProgram, OutputHidesPrivatePaths) {
  const auto folder = PrivateFolder::make();
  const auto file = MemoryFile::make("a secret");
  ASSERT_TRUE(folder && file);
  const auto run = run_program("echo", {*folder / "in.xml", file->path(), "sql:" + (*folder / "store")});
  ASSERT_TRUE(run);
  EXPECT_EQ(run->out, "in.xml memory sql:store\n");
  EXPECT_EQ(run_program("cat", {file->path()}).value_or(ProgramRun{}).out, "a secret");
}

TEST(OtherProgram, IsKilledAfterTimeout) {
  const auto run = run_program("sleep", {"60"}, std::chrono::milliseconds(50));
  ASSERT_FALSE(run);
  EXPECT_EQ(run.error().kind, FaultKind::timeout);
}

}  // namespace
}  // namespace gyrotherm::report
