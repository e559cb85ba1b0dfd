// SPDX-License-Identifier: Apache-2.0
/// The MQTT broker of a site, on which rigs say how they are while they are: state that may be missed, and never the
/// record.
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <stop_token>
#include <string>
#include <string_view>
#include <thread>

#include "core/quantity.hpp"
#include "core/result.hpp"

struct mosquitto;

namespace gyrotherm {
class TomlTable;
}

namespace gyrotherm::site {

/// `[live]` of a site file.
struct BrokerAddress {
  std::string host{};
  int port{};
  bool tls{};
  std::string authority{};  ///< the file of the certificates that the broker's is signed by; empty: the system's
  std::string user{};
  std::string passfile{};  ///< the file that has the password, and nothing else
};

/// Reads the table; mistakes are noted in it. Relative paths are those of the file's folder; a `credential` lies in the
/// folder `credentials`.
[[nodiscard]] BrokerAddress broker_at(const TomlTable& table, const std::string& file, const std::string& credentials);

/// A topic's part that stands for a name: what MQTT gives a meaning (/ + #), and controls, become "_".
[[nodiscard]] std::string in_topic(std::string_view name);

/// Waits so long, or until a stop is asked for.
void sleep_unless_stopped(const std::stop_token& stop, Duration time);

/// A connection that comes back by itself, with waits up to a minute. A thread of its own speaks to the broker; nothing
/// here waits for it.
class Broker {
 public:
  struct Will {
    std::string topic, text;
  };
  struct Message {
    std::string topic, text;
    bool kept{};  ///< sent before this subscribed
  };
  /// `came` is called when the connection is made again, `took` with each message of a subscribed topic, `complain`
  /// with the reason why there is no connection, once for each loss. All three run on the thread of the broker.
  struct Listeners {
    std::function<void()> came{};
    std::function<void(const Message& message)> took{};
    std::function<void(const Fault&)> complain{};
  };

  /// Begins to connect; the broker itself says `will`, which is kept, if this goes without a word. Messages of the
  /// topics `subscribed` are taken, if that is not empty. Fails with bad_file if a file of the address cannot be read.
  [[nodiscard]] static Result<std::unique_ptr<Broker>> connect(const BrokerAddress& address, const Will& will,
                                                               std::string subscribed, Listeners listeners);
  Broker(const Broker&) = delete;
  Broker& operator=(const Broker&) = delete;
  /// Ends the connection in order, so that no will is said.
  ~Broker();

  [[nodiscard]] bool is_connected() const { return connected_; }

  enum class Kept { no, yes };  ///< for those who come later
  /// Hands a message over; without a connection it is dropped. At least once.
  void say(const std::string& topic, const std::string& text, Kept kept);

 private:
  struct Ended {
    void operator()(mosquitto* client) const;
  };
  Broker(Listeners listeners, std::string place, std::string subscribed)
      : listeners_(std::move(listeners)), place_(std::move(place)), subscribed_(std::move(subscribed)) {}
  [[nodiscard]] Result<void> set_up(const BrokerAddress& address, const Will& will);
  void speak(const BrokerAddress& address, const std::stop_token& stop);
  void say_the_rest();
  void came(int code);
  void complain(const Fault& fault);

  Listeners listeners_;
  std::string place_;
  std::string subscribed_;
  std::unique_ptr<mosquitto, Ended> client_;
  std::atomic<bool> connected_{false};
  bool has_complained_ = false;
  std::jthread thread_;
};

}  // namespace gyrotherm::site
