// SPDX-License-Identifier: BSD-3-Clause
// Which interface a bus uses, and whom it asks for its peers.
#pragma once

#include <sstream>
#include <string>
#include <vector>

namespace hrp {

// "192.168.1.10": peers are found by multicast. "192.168.1.10,192.168.1.11,...": there is no multicast; all ports that
// a participant may have are asked on the machines that are named, and on this one.
struct NetworkChoice {
  std::string address;             // IPv4, of this machine
  std::vector<std::string> peers;  // IPv4, the own one included; empty: multicast
};

inline NetworkChoice split_network(const std::string& text) {
  NetworkChoice choice;
  std::istringstream words(text);
  for (std::string word; std::getline(words, word, ',');) choice.peers.push_back(word);
  if (!choice.peers.empty()) choice.address = choice.peers.front();
  if (choice.peers.size() == 1) choice.peers.clear();
  return choice;
}

}  // namespace hrp
