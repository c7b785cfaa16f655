// SPDX-License-Identifier: LGPL-2.1-or-later
// A bad network: passes UDP packets on between ports of this machine, loses some, and delays each
// by another time, so that they overtake one another. The same ones for the same seed.
//
//   lossy-relay LOSS-PERCENT JITTER-MS SEED FROM:TO[:FIRST-LOST]...
//
// FIRST-LOST: how many packets at the beginning are lost besides.
#include <arpa/inet.h>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <poll.h>
#include <random>
#include <sys/socket.h>
#include <unistd.h>
#include <vector>

namespace {

using Clock = std::chrono::steady_clock;

struct Way {
  int socket = -1;
  sockaddr_in to{};
  int first_lost = 0;
};

struct Packet {
  std::size_t way;
  std::vector<char> bytes;
};

sockaddr_in local(int port) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  return address;
}

bool open_way(const char *text, Way &way) {
  int from = 0;
  int to = 0;
  if (std::sscanf(text, "%d:%d:%d", &from, &to, &way.first_lost) < 2)
    return false;
  way.socket = socket(AF_INET, SOCK_DGRAM, 0);
  way.to = local(to);
  const sockaddr_in here = local(from);
  return bind(way.socket, reinterpret_cast<const sockaddr *>(&here), sizeof here) == 0;
}

} // namespace

int main(int argc, char **argv) {
  if (argc < 5) {
    std::fputs("usage: lossy-relay LOSS-PERCENT JITTER-MS SEED FROM:TO[:FIRST-LOST]...\n", stderr);
    return EXIT_FAILURE;
  }
  const double loss = std::atof(argv[1]) / 100;
  const double jitter = std::atof(argv[2]);
  std::mt19937 random(static_cast<unsigned>(std::atoi(argv[3])));
  std::uniform_real_distribution<double> chance(0, 1);
  std::vector<Way> ways(static_cast<std::size_t>(argc - 4));
  std::vector<pollfd> polled;
  for (std::size_t i = 0; i < ways.size(); ++i) {
    if (!open_way(argv[4 + i], ways[i])) {
      std::perror(argv[4 + i]);
      return EXIT_FAILURE;
    }
    polled.push_back({ways[i].socket, POLLIN, 0});
  }
  std::multimap<Clock::time_point, Packet> waiting;
  std::vector<char> bytes(65536);
  for (;;) {
    while (!waiting.empty() && waiting.begin()->first <= Clock::now()) {
      const Packet &packet = waiting.begin()->second;
      const Way &way = ways[packet.way];
      sendto(way.socket, packet.bytes.data(), packet.bytes.size(), 0,
             reinterpret_cast<const sockaddr *>(&way.to), sizeof way.to);
      waiting.erase(waiting.begin());
    }
    if (poll(polled.data(), polled.size(), waiting.empty() ? 100 : 1) <= 0)
      continue;
    for (std::size_t i = 0; i < ways.size(); ++i) {
      if (!(polled[i].revents & POLLIN))
        continue;
      const auto size = recv(ways[i].socket, bytes.data(), bytes.size(), 0);
      if (size < 0 || chance(random) < loss)
        continue;
      if (ways[i].first_lost > 0) {
        --ways[i].first_lost;
        continue;
      }
      const auto delay = std::chrono::duration<double, std::milli>(jitter * chance(random));
      waiting.emplace(Clock::now() + std::chrono::duration_cast<Clock::duration>(delay),
                      Packet{i, {bytes.begin(), bytes.begin() + size}});
    }
  }
}
