// SPDX-License-Identifier: Apache-2.0
#include "apps/monitor/deliver.hpp"

#include <curl/curl.h>
#include <fcntl.h>
#include <fmt/chrono.h>
#include <fmt/format.h>
#include <poll.h>
#include <spawn.h>
#include <sys/wait.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <ctime>
#include <memory>

#include "core/deadline.hpp"
#include "core/file.hpp"

namespace gyrotherm::monitor {
namespace {

struct Pipe {
  Descriptor read, write;
};

Result<Pipe> make_pipe() {
  int ends[2]{};
  if (::pipe2(ends, O_CLOEXEC) != 0) return failure(FaultKind::usage, "pipe", std::strerror(errno));
  return Pipe{Descriptor(ends[0]), Descriptor(ends[1])};
}

/// Starts a program in its own process group, with no blocked signals and with `input` as stdin. Discards its stdout.
Result<pid_t> start_program(const std::vector<std::string>& command, int input) {
  std::vector<char*> words;
  for (const auto& word : command) words.push_back(const_cast<char*>(word.c_str()));
  words.push_back(nullptr);
  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  posix_spawn_file_actions_adddup2(&files, input, STDIN_FILENO);
  posix_spawn_file_actions_addopen(&files, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  sigset_t none;
  sigemptyset(&none);
  posix_spawnattr_setsigmask(&attributes, &none);
  posix_spawnattr_setpgroup(&attributes, 0);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETPGROUP);
  pid_t child{};
  const int error = ::posix_spawnp(&child, words.front(), &files, &attributes, words.data(), environ);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&files);
  if (error != 0) return failure(FaultKind::usage, command.front(), std::strerror(error));
  return child;
}

/// Waits for the end of a process. Returns its exit code, or nothing if it did not end in time and was killed.
std::optional<int> wait_for(pid_t child, const Deadline& deadline) {
  constexpr int kPollIntervalMs = 20;
  int status = 0;
  while (::waitpid(child, &status, WNOHANG) == 0) {
    if (deadline.has_passed()) {
      ::kill(-child, SIGKILL);
      ::waitpid(child, &status, 0);
      return std::nullopt;
    }
    ::poll(nullptr, 0, kPollIntervalMs);
  }
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128;
}

/// Writes the input to the pipe and closes it. Stops early if the reader closes the pipe or the time is over.
void write_input(Descriptor pipe, std::string_view input, const Deadline& deadline) {
  ::fcntl(pipe.number(), F_SETFL, O_NONBLOCK);
  while (!input.empty() && wait_until_ready(pipe.number(), POLLOUT, deadline)) {
    const auto size = ::write(pipe.number(), input.data(), input.size());
    if (size < 0 && !would_block()) return;
    if (size > 0) input.remove_prefix(static_cast<std::size_t>(size));
  }
}

/// Replaces control characters by blanks. A line break in a header would begin another header.
std::string to_one_line(const std::string& text) {
  std::string line;
  for (const char c : text) line += static_cast<unsigned char>(c) < ' ' ? ' ' : c;
  return line;
}

/// Encodes a header's text if it contains non-ASCII characters (RFC 2047). An encoded word does not split a character.
/// Lines have at most 76 characters, including "Subject: " in the first line.
std::string encode_header(const std::string& text) {
  if (std::ranges::all_of(text, [](unsigned char c) { return c >= ' ' && c < 0x7F; })) return text;
  constexpr std::size_t kMaxWordBytes = 55;
  std::string all, word;
  const auto close = [&] {
    if (!word.empty()) all += (all.empty() ? "" : "\r\n ") + fmt::format("=?utf-8?Q?{}?=", word);
    word.clear();
  };
  for (std::size_t i = 0; i < text.size();) {
    auto end = i + 1;
    while (end < text.size() && (static_cast<unsigned char>(text[end]) & 0xC0) == 0x80) ++end;
    std::string character;
    for (; i < end; ++i) {
      const auto byte = static_cast<unsigned char>(text[i]);
      const bool plain = (byte >= '0' && byte <= '9') || (byte >= 'a' && byte <= 'z') || (byte >= 'A' && byte <= 'Z');
      character += byte == ' ' ? "_" : plain ? std::string(1, text[i]) : fmt::format("={:02X}", byte);
    }
    if (word.size() + character.size() > kMaxWordBytes) close();
    word += character;
  }
  close();
  return all;
}

std::string mail_date(Duration utc) {
  const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(utc).count();
  return fmt::format("{:%a, %d %b %Y %H:%M:%S} +0000", fmt::gmtime(static_cast<std::time_t>(seconds)));
}

struct FreeCurl {
  void operator()(CURL* curl) const { curl_easy_cleanup(curl); }
};
struct FreeList {
  void operator()(curl_slist* list) const { curl_slist_free_all(list); }
};
using Curl = std::unique_ptr<CURL, FreeCurl>;

Curl make_curl(const std::string& url, Duration timeout) {
  static const auto ready = curl_global_init(CURL_GLOBAL_DEFAULT);
  Curl curl(ready == CURLE_OK ? curl_easy_init() : nullptr);
  if (!curl) return curl;
  const long ms = std::chrono::duration_cast<std::chrono::milliseconds>(timeout).count();
  curl_easy_setopt(curl.get(), CURLOPT_URL, url.c_str());
  curl_easy_setopt(curl.get(), CURLOPT_NOSIGNAL, 1L);
  curl_easy_setopt(curl.get(), CURLOPT_TIMEOUT_MS, ms);
  curl_easy_setopt(curl.get(), CURLOPT_CONNECTTIMEOUT_MS, ms / 2);
  return curl;
}

std::size_t discard_output(char* /*bytes*/, std::size_t size, std::size_t count, void* /*nothing*/) {
  return size * count;
}

}  // namespace

Result<void> run_program(const std::vector<std::string>& command, const std::string& input, Duration timeout) {
  const Deadline deadline(timeout);
  auto pipe = make_pipe();
  if (!pipe) return failure(pipe.error());
  const auto child = start_program(command, pipe->read.number());
  if (!child) return failure(child.error());
  pipe->read.close();
  write_input(std::move(pipe->write), input, deadline);
  const auto code = wait_for(*child, deadline);
  if (!code)
    return failure(FaultKind::timeout, command.front(), fmt::format("did not end within {}", format_duration(timeout)));
  if (*code != 0) return failure(FaultKind::refused, command.front(), fmt::format("ended with exit code {}", *code));
  return {};
}

std::string mail_text(const MailServer& server, const MailAddress& to, const NotificationText& notification,
                      Duration utc) {
  std::string body;
  for (const char c : notification.text)
    body += c == '\n'                             ? std::string("\r\n")
            : static_cast<unsigned char>(c) < ' ' ? std::string(" ")
                                                  : std::string(1, c);
  return fmt::format(
      "Date: {}\r\nFrom: {}\r\nTo: {}\r\nSubject: {}\r\nAuto-Submitted: auto-generated\r\nMIME-Version: 1.0\r\n"
      "Content-Type: text/plain; charset=utf-8\r\nContent-Transfer-Encoding: 8bit\r\n\r\n{}\r\n",
      mail_date(utc), to_one_line(server.from), to_one_line(fmt::format("{}", fmt::join(to.to, ", "))),
      encode_header(to_one_line(notification.subject)), body);
}

Result<void> send_mail(const MailServer& server, const MailAddress& to, const NotificationText& notification,
                       Duration utc) {
  const auto curl = make_curl(server.url, kDeliveryTimeout);
  if (!curl) return failure(FaultKind::disconnected, server.url, "libcurl cannot be initialised");
  struct Upload {
    std::string text;
    std::size_t sent{};
  } upload{.text = mail_text(server, to, notification, utc)};
  const auto read_upload = [](char* into, std::size_t size, std::size_t count, void* data) -> std::size_t {
    auto& left = *static_cast<Upload*>(data);
    const auto piece = std::min(size * count, left.text.size() - left.sent);
    std::copy_n(left.text.data() + left.sent, piece, into);
    left.sent += piece;
    return piece;
  };
  std::unique_ptr<curl_slist, FreeList> receivers;
  for (const auto& receiver : to.to) receivers.reset(curl_slist_append(receivers.release(), receiver.c_str()));
  curl_easy_setopt(curl.get(), CURLOPT_PROTOCOLS_STR, "smtp,smtps");
  curl_easy_setopt(curl.get(), CURLOPT_MAIL_FROM, server.from.c_str());
  curl_easy_setopt(curl.get(), CURLOPT_MAIL_RCPT, receivers.get());
  curl_easy_setopt(curl.get(), CURLOPT_USE_SSL, server.requires_tls ? long{CURLUSESSL_ALL} : long{CURLUSESSL_NONE});
  if (!server.user.empty()) {
    curl_easy_setopt(curl.get(), CURLOPT_USERNAME, server.user.c_str());
    curl_easy_setopt(curl.get(), CURLOPT_PASSWORD, server.password.c_str());
  }
  curl_easy_setopt(curl.get(), CURLOPT_READFUNCTION, +read_upload);
  curl_easy_setopt(curl.get(), CURLOPT_READDATA, &upload);
  curl_easy_setopt(curl.get(), CURLOPT_UPLOAD, 1L);
  curl_easy_setopt(curl.get(), CURLOPT_WRITEFUNCTION, discard_output);
  const auto done = curl_easy_perform(curl.get());
  if (done == CURLE_OK) return {};
  return failure(done == CURLE_COULDNT_CONNECT ? FaultKind::disconnected : FaultKind::refused, server.url,
                 curl_easy_strerror(done));
}

Result<void> deliver(const Site& site, const NotifyAddress& address, const NotificationText& notification,
                     Duration utc) {
  if (const auto* command = std::get_if<CommandAddress>(&address.method)) {
    auto words = command->command;
    words.push_back(to_one_line(notification.subject));
    return run_program(words, notification.text + "\n", kDeliveryTimeout);
  }
  if (const auto* mail = std::get_if<MailAddress>(&address.method))
    return send_mail(*site.mail, *mail, notification, utc);
  const auto& url = std::get<AppriseAddress>(address.method).url;
  return run_program({"apprise", "-t", to_one_line(notification.subject), url}, notification.text + "\n",
                     kDeliveryTimeout);
}

/// Accepts only status 200: a proxy in front of a monitor that has failed responds with another status.
bool is_monitor_responding(const std::string& url, Duration timeout) {
  const auto curl = make_curl(url + (url.ends_with('/') ? "" : "/") + "api/v1/session", timeout);
  if (!curl) return false;
  curl_easy_setopt(curl.get(), CURLOPT_PROTOCOLS_STR, "http,https");
  curl_easy_setopt(curl.get(), CURLOPT_WRITEFUNCTION, discard_output);
  long status = 0;
  if (curl_easy_perform(curl.get()) != CURLE_OK) return false;
  curl_easy_getinfo(curl.get(), CURLINFO_RESPONSE_CODE, &status);
  return status == 200;
}

}  // namespace gyrotherm::monitor
