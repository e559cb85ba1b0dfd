// SPDX-License-Identifier: Apache-2.0
#include "apps/monitor/secop_node.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "core/json.hpp"
#include "core/text.hpp"

namespace gyrotherm::monitor {
namespace {

constexpr std::size_t kLongestName = 63;

/// A line in its three parts: "change t1:target 12" is an action, a specifier and data.
struct Request {
  std::string action, specifier, data;
  [[nodiscard]] std::string module() const { return specifier.substr(0, specifier.find(':')); }
  /// Empty where there is none. A further colon begins what later versions may say.
  [[nodiscard]] std::string accessible() const {
    const auto colon = specifier.find(':');
    if (colon == std::string::npos) return {};
    return specifier.substr(colon + 1, specifier.find(':', colon + 1) - colon - 1);
  }
};

/// What is not text is shown as text, so that no answer has bytes that steer a terminal.
Request split(std::string_view line) {
  const auto part = [&] {
    const auto blank = line.find(' ');
    const auto found = line.substr(0, blank);
    line = blank == std::string_view::npos ? std::string_view() : line.substr(blank + 1);
    return plain(found);
  };
  Request request{.action = part(), .specifier = part(), .data = {}};
  request.data = line;
  return request;
}

std::string failed(const Request& request, const char* kind, const std::string& why) {
  return fmt::format("error_{} {} {}\n", request.action, request.specifier,
                     ascii_of(Json::array({kind, why, Json::object()})));
}

/// "[295.13,{"t":1505396348.188}]", or the error report that stands in its place.
std::string report_of(const SecopParameter& parameter) {
  const auto time = fmt::format("{{\"t\":{:.3f}}}", parameter.t);
  if (parameter.trouble.empty()) return fmt::format("[{},{}]", parameter.value, time);
  return fmt::format("[{},{},{}]", ascii_of(parameter.value), ascii_of(parameter.trouble), time);
}

std::string update_of(const SecopModule& module, const SecopParameter& parameter) {
  return fmt::format("{} {}:{} {}\n", parameter.trouble.empty() ? "update" : "error_update", module.name,
                     parameter.name, report_of(parameter));
}

const SecopParameter* find_in(const SecopModule& module, std::string_view name) {
  const auto found = std::ranges::find(module.parameters, name, &SecopParameter::name);
  return found == module.parameters.end() ? nullptr : &*found;
}

std::string no_such_module(const Request& request) {
  return failed(request, "NoSuchModule", request.module() + " is no module of this node");
}

std::string activate(const SecopState& state, SecopSession& session, const Request& request) {
  const auto wanted = request.module();
  if (!wanted.empty() && state.node.find(wanted) == nullptr) return no_such_module(request);
  if (wanted.empty())
    session = {.everything = true};
  else if (!session.everything)
    session.modules.insert(wanted);
  std::string text;
  for (const auto& module : state.node.modules)
    if (wanted.empty() || module.name == wanted)
      for (const auto& parameter : module.parameters) text += update_of(module, parameter);
  return text + (wanted.empty() ? "active\n" : fmt::format("active {}\n", wanted));
}

std::string deactivate(const SecopState& state, SecopSession& session, const Request& request) {
  const auto wanted = request.module();
  if (wanted.empty()) {
    session = {};
    return "inactive\n";
  }
  if (state.node.find(wanted) == nullptr) return no_such_module(request);
  if (session.everything) {
    session.everything = false;
    for (const auto& module : state.node.modules) session.modules.insert(module.name);
  }
  session.modules.erase(wanted);
  return fmt::format("inactive {}\n", wanted);
}

/// `use` answers for the parameter; null where the module has none of that name.
template <class Use>
std::string at_place(const SecopState& state, const Request& request, Use use) {
  const auto* module = state.node.find(request.module());
  if (request.accessible().empty())
    return failed(request, "ProtocolError", "expected MODULE:NAME behind " + request.action);
  if (module == nullptr) return no_such_module(request);
  return use(find_in(*module, request.accessible()));
}

std::string no_such_parameter(const Request& request) {
  return failed(request, "NoSuchParameter",
                fmt::format("{} has no parameter {}", request.module(), request.accessible()));
}

std::string read(const SecopState& state, const Request& request) {
  return at_place(state, request, [&](const SecopParameter* parameter) {
    if (parameter == nullptr) return no_such_parameter(request);
    return fmt::format("{} {} {}\n", parameter->trouble.empty() ? "reply" : "error_read", request.specifier,
                       report_of(*parameter));
  });
}

/// Whether the data are JSON, or not there at all.
bool is_json(const Request& request) { return request.data.empty() || Json::accept(request.data); }

std::string change(const SecopState& state, const Request& request) {
  return at_place(state, request, [&](const SecopParameter* parameter) {
    if (parameter == nullptr) return no_such_parameter(request);
    if (!is_json(request)) return failed(request, "BadJSON", "the value is not JSON");
    return failed(request, "ReadOnly", "this node can be read, and changes nothing");
  });
}

std::string execute(const SecopState& state, const Request& request) {
  return at_place(state, request, [&](const SecopParameter*) {
    if (!is_json(request)) return failed(request, "BadJSON", "the argument is not JSON");
    return failed(request, "NoSuchCommand",
                  fmt::format("{} has no command {}", request.module(), request.accessible()));
  });
}

std::string pong(const Request& request, double utc_s) {
  return fmt::format("pong {} [null,{{\"t\":{:.3f}}}]\n", request.specifier, utc_s);
}

Json structure_of(const SecopModule& module) {
  Json accessibles = Json::object();
  for (const auto& parameter : module.parameters)
    accessibles[parameter.name] = {
        {"description", parameter.description}, {"datainfo", Json::parse(parameter.datainfo)}, {"readonly", true}};
  Json json{{"description", module.description}, {"interface_classes", {"Readable"}}};
  if (!module.group.empty()) json["group"] = module.group;
  json["accessibles"] = std::move(accessibles);
  return json;
}

}  // namespace

const SecopModule* SecopNode::find(std::string_view module) const {
  const auto found = std::ranges::find(modules, module, &SecopModule::name);
  return found == modules.end() ? nullptr : &*found;
}

std::string secop_name(std::string_view name, std::set<std::string>& taken) {
  const auto is_letter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); };
  const auto is_digit = [](char c) { return c >= '0' && c <= '9'; };
  constexpr std::size_t kRoomForNumber = 8;
  std::string made;
  for (const char c : name.substr(0, kLongestName - kRoomForNumber)) made += is_letter(c) || is_digit(c) ? c : '_';
  if (made.empty() || !is_letter(made.front())) made.insert(0, "n");  // "_…" is for what is nobody's standard
  const auto small = [](std::string text) {
    std::ranges::transform(text, text.begin(), [](char c) { return c >= 'A' && c <= 'Z' ? char(c - 'A' + 'a') : c; });
    return text;
  };
  auto unique = made;
  for (int i = 2; !taken.insert(small(unique)).second; ++i) unique = fmt::format("{}_{}", made, i);
  return unique;
}

std::string structure_of(const SecopNode& node) {
  Json modules = Json::object();
  for (const auto& module : node.modules) modules[module.name] = structure_of(module);
  return ascii_of({{"equipment_id", node.equipment_id},
                   {"description", node.description},
                   {"firmware", node.firmware},
                   {"modules", std::move(modules)}});
}

std::string answer_secop(const SecopState& state, SecopSession& session, std::string_view line, double utc_s) {
  const auto request = split(line);
  if (request.action == "*IDN?") {
    session = {};
    return fmt::format("{}\n", kSecopIdentity);
  }
  if (request.action == "describe") return fmt::format("describing . {}\n", state.structure);
  if (request.action == "activate") return activate(state, session, request);
  if (request.action == "deactivate") return deactivate(state, session, request);
  if (request.action == "ping") return pong(request, utc_s);
  if (request.action == "read") return read(state, request);
  if (request.action == "change") return change(state, request);
  if (request.action == "do") return execute(state, request);
  return failed(request, "ProtocolError", "unknown action");
}

std::string refuse_long_secop_line() {
  return failed({}, "ProtocolError", fmt::format("a line has more than {} bytes", kLongestSecopLine));
}

std::string secop_news(const SecopNode& before, const SecopNode& now, const SecopSession& session) {
  std::string text;
  for (std::size_t m = 0; m < now.modules.size(); ++m) {
    const auto& module = now.modules[m];
    if (!session.hears(module.name)) continue;
    for (std::size_t p = 0; p < module.parameters.size(); ++p) {
      const auto &old = before.modules[m].parameters[p], &parameter = module.parameters[p];
      if (old.value != parameter.value || old.trouble != parameter.trouble ||
          (parameter.measured && old.t != parameter.t))
        text += update_of(module, parameter);
    }
  }
  return text;
}

}  // namespace gyrotherm::monitor
