// SPDX-License-Identifier: Apache-2.0
#include "apps/site/live/broker.hpp"

#include <fmt/format.h>
#include <mosquitto.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <condition_variable>
#include <mutex>
#include <system_error>
#include <utility>

#include "apps/site/live/passfile.hpp"
#include "core/deadline.hpp"
#include "core/file.hpp"
#include "core/process.hpp"
#include "core/toml_reader.hpp"

namespace gyrotherm::site {

namespace {

constexpr int kPlainPort = 1883, kTlsPort = 8883;
constexpr int kAtLeastOnce = 1;
constexpr int kKeepAliveS = 15;
constexpr int kLookMs = 100;
constexpr Duration kFirstWait = std::chrono::seconds(1), kLongestWait = std::chrono::minutes(1);
constexpr Duration kPatienceAtTheEnd = std::chrono::seconds(2);

/// Once for all connections of this process.
void begin_library() {
  static std::once_flag begun;
  std::call_once(begun, mosquitto_lib_init);
}

/// "mqtts://host:8883".
void read_url(const TomlTable& table, const std::string& url, BrokerAddress& address) {
  constexpr std::string_view kPlain = "mqtt://", kTls = "mqtts://";
  std::string_view rest = url;
  address.tls = rest.starts_with(kTls);
  const bool has_scheme = address.tls || rest.starts_with(kPlain);
  rest.remove_prefix(has_scheme ? (address.tls ? kTls : kPlain).size() : 0);
  const auto colon = rest.rfind(':');
  address.host = rest.substr(0, colon);
  address.port = address.tls ? kTlsPort : kPlainPort;
  bool good = has_scheme && !address.host.empty();
  if (colon != std::string_view::npos) {
    const auto port = rest.substr(colon + 1);
    const auto [end, error] = std::from_chars(port.data(), port.data() + port.size(), address.port);
    good = good && error == std::errc{} && end == port.data() + port.size() && address.port > 0 && address.port < 65536;
  }
  if (!good && !url.empty())
    table.mistake("broker", fmt::format("\"{}\" is no broker, expected mqtts://HOST or mqtt://HOST:PORT", url));
}

}  // namespace

void sleep_unless_stopped(const std::stop_token& stop, Duration time) {
  std::mutex mutex;
  std::unique_lock lock(mutex);
  std::condition_variable_any().wait_for(lock, stop, time, [] { return false; });
}

BrokerAddress broker_at(const TomlTable& table, const std::string& file, const std::string& credentials) {
  BrokerAddress address;
  read_url(table, table.text("broker"), address);
  if (table.has("authority")) address.authority = path_from(file, table.text("authority"));
  if (!address.authority.empty() && !address.tls) table.mistake("authority", "is for mqtts://");
  address.user = table.text("user", "");
  address.passfile = passfile_at(table, file, credentials);
  if (address.user.empty() && !address.passfile.empty()) table.mistake("user", "a password needs a user");
  return address;
}

std::string in_topic(std::string_view name) {
  std::string part(name);
  std::ranges::replace_if(
      part, [](unsigned char c) { return c == '/' || c == '+' || c == '#' || c < ' ' || c == 0x7F; }, '_');
  return part;
}

void Broker::Ended::operator()(mosquitto* client) const { mosquitto_destroy(client); }

Result<std::unique_ptr<Broker>> Broker::connect(const BrokerAddress& address, const Will& will, std::string subscribed,
                                                Listeners listeners) {
  begin_library();
  std::unique_ptr<Broker> broker(
      new Broker(std::move(listeners), fmt::format("{}:{}", address.host, address.port), std::move(subscribed)));
  if (auto set = broker->set_up(address, will); !set) return failure(set.error());
  broker->thread_ =
      std::jthread([broker = broker.get(), address](const std::stop_token& stop) { broker->speak(address, stop); });
  return broker;
}

Broker::~Broker() {
  thread_.request_stop();
  if (thread_.joinable()) thread_.join();
}

Result<void> Broker::set_up(const BrokerAddress& address, const Will& will) {
  client_.reset(mosquitto_new(nullptr, true, this));
  auto* client = client_.get();
  mosquitto_connect_callback_set(client,
                                 [](mosquitto*, void* broker, int code) { static_cast<Broker*>(broker)->came(code); });
  mosquitto_message_callback_set(client, [](mosquitto*, void* broker, const mosquitto_message* message) {
    const auto& took = static_cast<Broker*>(broker)->listeners_.took;
    if (took)
      took({message->topic,
            {static_cast<const char*>(message->payload), static_cast<std::size_t>(message->payloadlen)},
            message->retain});
  });
  if (!will.topic.empty())
    mosquitto_will_set(client, will.topic.c_str(), static_cast<int>(will.text.size()), will.text.data(), kAtLeastOnce,
                       true);
  if (!address.user.empty()) {
    const auto password = address.passfile.empty() ? Result<std::string>("") : read_text_file(address.passfile);
    if (!password) return failure(password.error());
    mosquitto_username_pw_set(client, address.user.c_str(),
                              password->substr(0, password->find_first_of("\r\n")).c_str());
  }
  if (address.tls) {
    const bool given = !address.authority.empty();
    const int code = mosquitto_tls_set(client, given ? address.authority.c_str() : nullptr,
                                       given ? nullptr : "/etc/ssl/certs", nullptr, nullptr, nullptr);
    if (code != MOSQ_ERR_SUCCESS) return failure(FaultKind::bad_file, address.authority, mosquitto_strerror(code));
  }
  mosquitto_threaded_set(client, true);
  return {};
}

void Broker::speak(const BrokerAddress& address, const std::stop_token& stop) {
  block_signals();
  auto* client = client_.get();
  auto wait = kFirstWait;
  while (!stop.stop_requested()) {
    int code = mosquitto_connect_async(client, address.host.c_str(), address.port, kKeepAliveS);
    while (code == MOSQ_ERR_SUCCESS && !stop.stop_requested()) {
      code = mosquitto_loop(client, kLookMs, 1);
      if (connected_) wait = kFirstWait;
    }
    if (stop.stop_requested()) break;
    connected_ = false;
    complain({FaultKind::disconnected, place_,
              code == MOSQ_ERR_ERRNO ? std::generic_category().message(errno) : mosquitto_strerror(code)});
    sleep_unless_stopped(stop, wait);
    wait = std::min(wait * 2, kLongestWait);
  }
  say_the_rest();
}

/// What was handed over last, and that this goes in order.
void Broker::say_the_rest() {
  if (!connected_) return;
  const Deadline patience(kPatienceAtTheEnd);
  while (mosquitto_want_write(client_.get()) && !patience.over())
    if (mosquitto_loop(client_.get(), kLookMs, 1) != MOSQ_ERR_SUCCESS) return;
  mosquitto_disconnect(client_.get());
  while (mosquitto_want_write(client_.get()) && !patience.over())
    if (mosquitto_loop(client_.get(), kLookMs, 1) != MOSQ_ERR_SUCCESS) return;
}

void Broker::complain(const Fault& fault) {
  if (!std::exchange(has_complained_, true)) listeners_.complain(fault);
}

void Broker::came(int code) {
  if (code != 0) return complain({FaultKind::refused, place_, mosquitto_connack_string(code)});
  connected_ = true;
  has_complained_ = false;
  if (!subscribed_.empty()) mosquitto_subscribe(client_.get(), nullptr, subscribed_.c_str(), kAtLeastOnce);
  if (listeners_.came) listeners_.came();
}

void Broker::say(const std::string& topic, const std::string& text, Kept kept) {
  if (!connected_) return;
  mosquitto_publish(client_.get(), nullptr, topic.c_str(), static_cast<int>(text.size()), text.data(), kAtLeastOnce,
                    kept == Kept::yes);
}

}  // namespace gyrotherm::site
