// SPDX-License-Identifier: Apache-2.0
#include "tests/apps/gyrotherm/program.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <pty.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <iterator>
#include <regex>
#include <thread>

namespace gyrotherm::app {
namespace {

std::string content(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

int exit_code_for(int status) { return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status); }

}  // namespace

Folder::Folder() {
  const auto* unit = ::testing::UnitTest::GetInstance();
  const auto* test = unit->current_test_info();  // null in suite setup
  std::string name = unit->current_test_suite()->name() + std::string(test == nullptr ? "" : "-") +
                     (test == nullptr ? "" : test->name());
  std::replace(name.begin(), name.end(), '/', '-');  // tests with parameters
  path_ = std::filesystem::temp_directory_path() / ("gyrotherm-" + name + "-" + std::to_string(::getpid()));
  std::filesystem::create_directories(path_);
}

Folder::~Folder() { std::filesystem::remove_all(path_); }

Ran shell(const std::string& command, const std::string& input) {
  char name[] = "/tmp/gyrotherm-shell-XXXXXX";
  const std::string base = ::mkdtemp(name);
  std::ofstream(base + "/in", std::ios::binary) << input;
  const auto function = "gyrotherm() { " GYROTHERM_PROGRAM " \"$@\"; }; cd " GYROTHERM_SOURCE_DIR " || exit 99; ";
  const auto whole =
      std::string(function) + "{ " + command + "\n} < " + base + "/in > " + base + "/out 2> " + base + "/err";
  const int status = std::system(whole.c_str());
  Ran ran{exit_code_for(status), content(base + "/out"), content(base + "/err")};
  std::filesystem::remove_all(base);
  return ran;
}

Ran gyrotherm_with(const std::string& arguments, const std::string& input) {
  return shell("gyrotherm " + arguments, input);
}

Ran run_on_terminal(const std::vector<std::string>& arguments, const std::string& input,
                    const std::string& interrupt_at) {
  int terminal = -1;
  const pid_t child = ::forkpty(&terminal, nullptr, nullptr, nullptr);
  if (child == 0) {
    if (::chdir(GYROTHERM_SOURCE_DIR) != 0) ::_exit(99);
    std::vector<char*> words{const_cast<char*>(GYROTHERM_PROGRAM)};
    for (const auto& argument : arguments) words.push_back(const_cast<char*>(argument.c_str()));
    words.push_back(nullptr);
    ::execv(GYROTHERM_PROGRAM, words.data());
    ::_exit(99);
  }
  Ran ran;
  if (child < 0) return ran;
  EXPECT_EQ(::write(terminal, input.data(), input.size()), static_cast<ssize_t>(input.size()));
  bool interrupts = !interrupt_at.empty();
  char bytes[4096];
  for (ssize_t got; (got = ::read(terminal, bytes, sizeof bytes)) > 0;) {
    ran.out.append(bytes, static_cast<std::size_t>(got));
    if (!interrupts || ran.out.find(interrupt_at) == std::string::npos) continue;
    interrupts = false;
    EXPECT_EQ(::write(terminal, "\x03", 1), 1);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  ::close(terminal);
  ran.exit_code = exit_code_for(status);
  return ran;
}

Background::Background(const std::vector<std::string>& arguments, const std::string& output_file)
    : output_file_(output_file) {
  std::vector<char*> argv{const_cast<char*>(GYROTHERM_PROGRAM)};
  for (const auto& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
  argv.push_back(nullptr);
  pid_ = ::fork();
  if (pid_ != 0) return;
  const int out = ::open(output_file.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
  ::dup2(out, STDOUT_FILENO);
  ::dup2(out, STDERR_FILENO);
  if (::chdir(GYROTHERM_SOURCE_DIR) == 0) ::execv(GYROTHERM_PROGRAM, argv.data());
  ::_exit(99);
}

Background::~Background() {
  if (pid_ <= 0) return;
  ::kill(pid_, SIGKILL);
  wait();
}

void Background::signal(int number) const { ::kill(pid_, number); }

int Background::wait() {
  int status = 0;
  ::waitpid(pid_, &status, 0);
  pid_ = -1;
  return exit_code_for(status);
}

bool Background::is_running() const {
  siginfo_t info{};
  return pid_ > 0 && ::waitid(P_PID, static_cast<id_t>(pid_), &info, WEXITED | WNOHANG | WNOWAIT) == 0 &&
         info.si_pid == 0;
}

std::chrono::nanoseconds Background::processor_time() const {
  clockid_t clock{};
  timespec time{};
  if (!is_running() || ::clock_getcpuclockid(pid_, &clock) != 0 || ::clock_gettime(clock, &time) != 0) return {};
  return std::chrono::seconds(time.tv_sec) + std::chrono::nanoseconds(time.tv_nsec);
}

std::string Background::output() const { return content(output_file_); }

bool Background::wait_for(const std::string& text, int seconds) const {
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(seconds);
  while (std::chrono::steady_clock::now() < end) {
    const bool has_ended = !is_running();
    if (output().find(text) != std::string::npos) return true;
    if (has_ended) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  return false;
}

std::int64_t last_acknowledged(const std::string& output) {
  const std::string key = "{\"acknowledged\": ";
  auto at = output.rfind(key);
  while (at != std::string::npos && output.find('}', at) == std::string::npos)
    at = at == 0 ? std::string::npos : output.rfind(key, at - 1);
  return at == std::string::npos ? -1 : std::stoll(output.substr(at + key.size()));
}

std::set<std::string> options_in(const std::string& text) {
  std::set<std::string> options;
  const std::regex option(R"((?:^|[^A-Za-z0-9_-])(--[a-z][a-z-]*[a-z]))");
  for (std::sregex_iterator at(text.begin(), text.end(), option), end; at != end; ++at) options.insert((*at)[1]);
  return options;
}

bool installed(const std::string& program) {
  return std::system(("command -v " + program + " > /dev/null 2>&1").c_str()) == 0;
}

std::string shared_folder() {
  const char* folder = std::getenv("GYROTHERM_SHARED");
  return folder ? folder : "";
}

}  // namespace gyrotherm::app
