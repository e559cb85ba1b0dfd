// SPDX-License-Identifier: Apache-2.0
#include "apps/monitor/access_control.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "apps/monitor/http_message.hpp"
#include "core/json.hpp"
#include "sequencer/control/control_message.hpp"

namespace gyrotherm::monitor {
namespace {

// Limits per address or IPv6 network: a burst of 120 requests, as a page with many charts sends at its start, then 20
// per second; and ten logins, then one every 20 s. The limit of logins per user name, over all addresses, is much
// higher, so that guesses from a few addresses do not lock out the user at another address.
constexpr double kRequestBurst = 120, kRequestsPerSecond = 20, kLoginBurst = 10, kLoginsPerSecond = 0.05,
                 kLoginBurstPerName = 500, kLoginsPerNamePerSecond = 1;

/// Returns the name of the session cookie. It includes the port, because a browser sends a cookie to all ports of a
/// host: two monitors on one host would overwrite each other's cookie.
std::string cookie_name(const WebRequest& request) {
  const std::string name = "gyrotherm_session";
  const auto host = request.head.header("host");
  const auto colon = host.rfind(':');
  const auto port = colon == std::string::npos ? std::string() : host.substr(colon + 1);
  const bool is_number = !port.empty() && std::ranges::all_of(port, [](char c) { return c >= '0' && c <= '9'; });
  return is_number ? name + "_" + port : name;
}

std::string make_cookie(const std::string& secret, const WebRequest& request, std::int64_t seconds) {
  return fmt::format("{}={}; Path=/; HttpOnly; SameSite=Strict; Max-Age={}{}", cookie_name(request), secret, seconds,
                     request.secure ? "; Secure" : "");
}

/// Returns the secret in the request's cookie, or an empty text.
std::string session_secret(const WebRequest& request) {
  return find_cookie(request.head.header("cookie"), cookie_name(request));
}

/// Returns whether the browser marks the request as sent by another site. A link from another site to the page is
/// allowed.
bool is_cross_site(const WebRequest& request) {
  const auto& head = request.head;
  const auto site = head.header("sec-fetch-site");
  const bool opens_page = head.method == "GET" && head.path == "/";
  if (!site.empty() && site != "same-origin" && site != "none" && !opens_page) return true;
  const auto origin = head.header("origin");
  const auto own = fmt::format("{}://{}", request.secure ? "https" : "http", head.header("host"));
  return !origin.empty() && to_lower_case(origin) != to_lower_case(own);
}

/// Returns a refusal if the request does not state its origin. A browser states it in every POST.
std::optional<WebAnswer> origin_refusal(const WebRequest& request) {
  if (!request.head.header("origin").empty() || !request.head.header("sec-fetch-site").empty()) return std::nullopt;
  return refusal(403, "the request has no Origin or Sec-Fetch-Site header");
}

/// Returns a refusal if a request in a session does not come from the page: its origin or the second secret of the
/// session is missing. A script has no session, because a browser never sends its token by itself.
std::optional<WebAnswer> forgery_refusal(const std::optional<Sessions::Session>& session, const WebRequest& request) {
  if (!session) return std::nullopt;
  if (auto refused = origin_refusal(request)) return refused;
  if (equal_secrets(session->csrf, request.head.header("x-csrf-token"))) return std::nullopt;
  return refusal(403, "the request does not come from the page");
}

/// Returns the answer if the end of sessions could not be stored.
WebAnswer not_stored_answer(const Fault& fault) {
  return refusal(500, fmt::format("the sessions have ended, but they are valid again after a restart of the monitor, "
                                  "because the list of sessions cannot be stored: {}",
                                  fault.what));
}

}  // namespace

AccessControl::AccessControl(const AccessOptions& options, Users& users, Sessions& sessions, const Clock& clock)
    : options_(options),
      users_(users),
      sessions_(sessions),
      requests_per_address_(kRequestBurst, kRequestsPerSecond, clock),
      logins_per_address_(kLoginBurst, kLoginsPerSecond, clock),
      logins_per_name_(kLoginBurstPerName, kLoginsPerNamePerSecond, clock) {}

std::optional<WebAnswer> AccessControl::general_refusal(const WebRequest& request) {
  if (!requests_per_address_.try_acquire(client_network(request.peer)))
    return refusal(429, "too many requests from this address");
  if (is_cross_site(request)) return refusal(403, "the request comes from another site");
  return std::nullopt;
}

std::variant<Sender, WebAnswer> AccessControl::identify_sender(const WebRequest& request) {
  const auto& head = request.head;
  constexpr std::string_view kBearer = "Bearer ";
  if (const auto sent = head.header("authorization"); !sent.empty()) {
    const auto identity =
        sent.starts_with(kBearer) ? users_.find_by_token(std::string_view(sent).substr(kBearer.size())) : std::nullopt;
    if (!identity && !logins_per_address_.try_acquire("token " + client_network(request.peer)))
      return refusal(429, "too many invalid tokens from this address; wait a minute");
    if (!identity) return refusal(401, "unknown token");
    return Sender{.identity = identity};
  }
  const auto session = sessions_.find(session_secret(request));
  if (session)
    if (auto identity = session_user(*session)) return Sender{.identity = std::move(identity), .session = session};
  if (options_.allows_guests && !users_.has_any()) return Sender{};
  return refusal(401, "log in first");
}

std::optional<Identity> AccessControl::session_user(const Sessions::Session& session) {
  auto identity = users_.find_by_name(session.user);
  if (!identity || identity->password_id == session.password_id) return identity;
  // If the end cannot be stored, the session still has another password_id after a restart.
  (void)sessions_.close(session.id);
  return std::nullopt;
}

std::optional<WebAnswer> AccessControl::change_refusal(const Sender& sender, const WebRequest& request,
                                                       Role role) const {
  if (!options_.control) return refusal(403, "this monitor is read-only; it was started without --control");
  if (!sender.identity) return refusal(403, "controlling a run requires a user; add users first");
  if (!sender.has_role(role))
    return refusal(403, fmt::format("the role {} does not permit this action", name(sender.identity->role)));
  return forgery_refusal(sender.session, request);
}

WebAnswer AccessControl::log_in(const WebRequest& request) {
  const auto body = read_body(request, {"name", "password"});
  if (!body) return refusal(400, body.error().what);
  if (auto refused = origin_refusal(request)) return *refused;
  const auto& name = body->at("name");
  // The beginning of a longer name, which no user has, takes less memory.
  if (!logins_per_address_.try_acquire(client_network(request.peer)) ||
      !logins_per_name_.try_acquire(name.substr(0, control::kLongestUser)))
    return refusal(429, "too many login attempts; wait a minute");
  const auto identity = users_.find_by_password(name, body->at("password"));
  if (!identity) return refusal(401, "name or password is wrong");
  const auto secret = sessions_.open(identity->name, identity->password_id);
  const auto lifetime_s = std::chrono::duration_cast<std::chrono::seconds>(Sessions::kLifetime).count();
  WebAnswer answer{.body = "{}"};
  answer.headers.emplace_back("Set-Cookie", make_cookie(secret, request, lifetime_s));
  return answer;
}

WebAnswer AccessControl::log_out(const WebRequest& request) {
  const auto session = sessions_.find(session_secret(request));
  if (auto refused = forgery_refusal(session, request)) return *refused;
  // The session of a repeated logout has ended before; its end may not be stored yet.
  const auto ended = session ? sessions_.close(session->id) : sessions_.store_again();
  auto answer = ended ? WebAnswer{.body = "{}"} : not_stored_answer(ended.error());
  answer.headers.emplace_back("Set-Cookie", make_cookie("", request, 0));
  return answer;
}

WebAnswer AccessControl::answer_session(const WebRequest& request) {
  const auto found = identify_sender(request);
  const auto* sender = std::get_if<Sender>(&found);
  const bool known = sender != nullptr && sender->identity;
  return {.body = json_text(Json{{"name", known ? Json(sender->identity->name) : Json(nullptr)},
                                 {"role", known ? Json(name(sender->identity->role)) : Json(nullptr)},
                                 {"may_look", sender != nullptr},
                                 {"may_control", known && options_.control && sender->has_role(Role::conductor)},
                                 {"csrf", known && sender->session ? Json(sender->session->csrf) : Json(nullptr)}})};
}

WebAnswer AccessControl::answer_sessions(const WebRequest& request) {
  const auto found = identify_sender(request);
  if (const auto* refused = std::get_if<WebAnswer>(&found)) return *refused;
  const auto& sender = std::get<Sender>(found);
  if (!sender.has_role(Role::administrator)) return refusal(403, "only administrators may list sessions");
  if (request.head.method == "POST") {
    if (auto refused = forgery_refusal(sender.session, request)) return *refused;
    const auto body = read_body(request, {"user"});
    if (!body) return refusal(400, body.error().what);
    if (const auto ended = sessions_.close_all_for_user(body->at("user")); !ended)
      return not_stored_answer(ended.error());
  }
  Json list = Json::array();
  for (const auto& session : sessions_.all())
    if (session_user(session))
      list.push_back({{"user", session.user}, {"since_ms", session.begun.count() / 1'000'000}});
  return {.body = json_text(Json{{"sessions", std::move(list)}})};
}

}  // namespace gyrotherm::monitor
