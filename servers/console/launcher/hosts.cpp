// SPDX-License-Identifier: BSD-3-Clause
#include "servers/console/launcher/hosts.h"

#include <arpa/inet.h>
#include <netdb.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <fstream>
#include <set>
#include <sstream>
#include <stdexcept>

#include "common/base/diagnostics.h"
#include "common/base/has.h"
#include "common/base/read_file.h"
#include "common/node/node.h"

namespace hrp {
namespace {

const std::vector<std::string> kMovable{"dynamics", "collision_checker", "controller", "vision"};
const std::vector<std::string> kKeys{"address", "user", "programs", "secure"};

[[noreturn]] void refuse(const std::string& file, int line, const std::string& message) {
  refuse_input({file, file.empty() ? "--on" : "", line}, message);
}

void check_role(const std::string& role, const std::string& file, int line) {
  if (!find_robot_of(role).empty() || has(kMovable, role)) return;
  if (role == "model_parser" || role == "scheduler" || role == "logger") {
    refuse(file, line,
           role +
               " stays on the launcher's machine, where scenario, robot and log are; dynamics, collision_checker, "
               "controller and vision can go to others");
  }
  const std::string nearest = find_nearest(role, kMovable);
  refuse(
      file, line,
      "there is no server '" + role + "' that can go to another machine" +
          (nearest.empty() ? ": dynamics, collision_checker, controller, vision" : "; did you mean " + nearest + "?"));
}

// A name that begins with '-' would be an option of ssh.
Host parse_host(const std::string& word, const std::string& file, int line) {
  Host host;
  const size_t at = word.find('@');
  if (at != std::string::npos) host.user = word.substr(0, at);
  host.name = at == std::string::npos ? word : word.substr(at + 1);
  if (host.name.empty() || word.front() == '-' || word.front() == '@')
    refuse(file, line, "'" + word + "' is no [USER@]HOST");
  return host;
}

void set_key(const std::string& word, const std::string& file, int line, Host* host) {
  const size_t equals = word.find('=');
  const std::string key = word.substr(0, equals);
  if (equals == std::string::npos || !has(kKeys, key)) {
    const std::string nearest = find_nearest(key, kKeys);
    refuse(file, line,
           "'" + word + "' is none of address=, user=, programs=, secure=" +
               (nearest.empty() ? "" : "; did you mean " + nearest + "=?"));
  }
  const std::string value = word.substr(equals + 1);
  if (value.empty()) refuse(file, line, "'" + word + "' has no value");
  if ((key == "programs" || key == "secure") && value.front() != '/')
    refuse(file, line, "'" + word + "': expected an absolute path on that machine");
  (key == "address"    ? host->address
   : key == "user"     ? host->user
   : key == "programs" ? host->programs
                       : host->secure) = value;
}

bool is_address(const std::string& text) {
  in_addr number{};
  return inet_pton(AF_INET, text.c_str(), &number) == 1;
}

}  // namespace

std::pair<std::string, Host> parse_on(const std::string& words) {
  const size_t equals = words.find('=');
  if (equals == std::string::npos || equals == 0 || equals + 1 == words.size())
    refuse("", 0, "'" + words + "' is not SERVER=[USER@]HOST");
  const std::string role = words.substr(0, equals);
  check_role(role, "", 0);
  return {role, parse_host(words.substr(equals + 1), "", 0)};
}

std::map<std::string, Host> read_hosts(const std::string& file) {
  std::map<std::string, Host> hosts;
  std::ifstream stream(file);
  if (!stream) refuse(file, 0, "cannot be read");
  int number = 0;
  for (std::string line; std::getline(stream, line);) {
    ++number;
    std::istringstream words(line.substr(0, line.find('#')));
    std::string role, host, word;
    if (!(words >> role)) continue;
    check_role(role, file, number);
    if (!(words >> host)) refuse(file, number, role + " has no host: expected SERVER HOST [KEY=VALUE ...]");
    if (hosts.count(role) > 0) refuse(file, number, role + " has a host already");
    hosts[role] = parse_host(host, file, number);
    while (words >> word) set_key(word, file, number, &hosts[role]);
  }
  check_end(stream, file);
  if (hosts.empty()) refuse(file, 0, "names no server: expected lines SERVER HOST [KEY=VALUE ...]");
  return hosts;
}

std::vector<std::string> make_ssh_command(std::vector<std::string> words) {
  if (words.size() != 1 || words[0].substr(words[0].find_last_of('/') + 1) != "ssh") return words;
  for (const char* option : {"BatchMode=yes", "ConnectTimeout=10", "ServerAliveInterval=2", "ServerAliveCountMax=5"}) {
    words.insert(words.end(), {"-o", option});
  }
  words.push_back("-T");
  return words;
}

std::string find_address(const Host& host) {
  std::string name = host.address.empty() ? host.name : host.address;
  if (is_address(name)) return name;
  addrinfo hints{};
  hints.ai_family = AF_INET;
  addrinfo* found = nullptr;
  const int error = getaddrinfo(name.c_str(), nullptr, &hints, &found);
  if (error != 0) {
    throw std::runtime_error(host.name + ": no IPv4 address of '" + name + "' (" + gai_strerror(error) +
                             "); give one with address= in a --hosts file");
  }
  char text[INET_ADDRSTRLEN] = "";
  inet_ntop(AF_INET, &reinterpret_cast<const sockaddr_in*>(found->ai_addr)->sin_addr, text, sizeof text);
  freeaddrinfo(found);
  return text;
}

std::string find_own_address(const std::string& address) {
  sockaddr_in there{}, here{};
  there.sin_family = AF_INET;
  there.sin_port = htons(7400);
  inet_pton(AF_INET, address.c_str(), &there.sin_addr);
  const int file = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  socklen_t size = sizeof here;
  // Connecting a datagram socket sends nothing; it asks the kernel for the route.
  const bool found = file >= 0 && connect(file, reinterpret_cast<const sockaddr*>(&there), sizeof there) == 0 &&
                     getsockname(file, reinterpret_cast<sockaddr*>(&here), &size) == 0;
  if (file >= 0) close(file);
  if (!found) throw std::runtime_error("this machine has no route to " + address);
  char text[INET_ADDRSTRLEN] = "";
  inet_ntop(AF_INET, &here.sin_addr, text, sizeof text);
  return text;
}

std::string find_network(const std::map<std::string, Host>& on) {
  std::string own;
  std::set<std::string> all;
  for (const auto& [role, host] : on) {
    const std::string address = find_address(host);
    const std::string from = find_own_address(address);
    if (!own.empty() && from != own) {
      throw std::runtime_error("the hosts are behind two interfaces of this machine, " + own + " and " + from +
                               "; they have to be behind one");
    }
    own = from;
    all.insert({address, own});
  }
  std::string network = own;
  for (const std::string& address : all) network += "," + address;
  return network;
}

std::string turn_network(const std::string& network, const std::string& address) {
  return address + network.substr(network.find(','));
}

}  // namespace hrp
