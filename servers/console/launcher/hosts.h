// SPDX-License-Identifier: BSD-3-Clause
// Which server runs on which other machine: --on and --hosts of hrp-simulate.
#pragma once

#include <map>
#include <string>
#include <utility>
#include <vector>

namespace hrp {

struct Host {
  std::string name;      // as ssh knows it
  std::string user;      // empty: as ssh thinks fit
  std::string address;   // IPv4; empty: that of the name
  std::string programs;  // folder of the installed programs there; empty: the same path as here
  std::string secure;    // folder of the identity there; empty: the same path as here
};

// "controller=robot@desk": the server and its host. Throws InputError; servers that read or write files of this machine
// stay on it.
std::pair<std::string, Host> parse_on(const std::string& words);

// A line "SERVER HOST [KEY=VALUE ...]" each, '#' begins a comment. Throws InputError with file and line.
std::map<std::string, Host> read_hosts(const std::string& file);

// ssh with options that end a dead connection within ten seconds and never ask for a password; any other command is
// left as it is.
std::vector<std::string> make_ssh_command(std::vector<std::string> words);

// The IPv4 address of a host. Throws std::runtime_error when its name leads to none.
std::string find_address(const Host& host);
// Which of this machine's addresses packets to `address` leave from.
std::string find_own_address(const std::string& address);

// "192.168.1.10,192.168.1.10,192.168.1.11": this machine's interface to the hosts, then all machines
// (network_choice.h). Throws std::runtime_error when they are not behind one interface.
std::string find_network(const std::map<std::string, Host>& on);
// The same, as the machine with `address` has to see it.
std::string turn_network(const std::string& network, const std::string& address);

}  // namespace hrp
