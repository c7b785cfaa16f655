// SPDX-License-Identifier: LGPL-2.1-or-later
// A small program that uses libspidar's public headers. It prints the layout of the public structs
// and the numbers that it reads from the library. Compiled for other processors than the library,
// it must print the same.
#include <cstdio>
#include <spidar/device.hpp>
#include <spidar/limited-device.hpp>
#include <spidar/pose-solver.hpp>
#include <spidar/simulator.hpp>
#include <spidar/tension-solver.hpp>

namespace {

template <class T>
void print_layout(const char *name) {
  std::printf("%s: %zu bytes, alignment %zu\n", name, sizeof(T), alignof(T));
}

void print_layouts() {
  print_layout<spidar::Vector3>("Vector3");
  print_layout<spidar::Matrix3>("Matrix3");
  print_layout<spidar::Tensions>("Tensions");
  print_layout<spidar::Pose>("Pose");
  print_layout<spidar::Wrench>("Wrench");
  print_layout<spidar::Geometry>("Geometry");
  print_layout<spidar::DeviceState>("DeviceState");
  print_layout<spidar::ForceLimits>("ForceLimits");
  print_layout<spidar::PoseSolver>("PoseSolver");
  print_layout<spidar::PoseSolver::Result>("PoseSolver::Result");
  print_layout<spidar::TensionSolver>("TensionSolver");
  print_layout<spidar::TensionSolver::Result>("TensionSolver::Result");
}

} // namespace

int main() {
  print_layouts();
  const spidar::Geometry geometry = spidar::load_geometry(spidar::kDefaultGeometry);
  const spidar::Wrench wrench{{0.3, 0.4, 0}, {0, 0, 0}};
  spidar::Device device(
      std::make_unique<spidar::Simulator>(geometry, spidar::parse_hand_script("hold:0.5,0.25,0")),
      geometry);
  for (std::int64_t tick = 1; tick <= 20; ++tick) {
    device.command(wrench);
    device.exchange(1000000 * tick);
  }
  const spidar::DeviceState &state = device.state();
  std::printf("position %.6f %.6f %.6f\n", state.pose.position.x(), state.pose.position.y(),
              state.pose.position.z());
  std::printf("lengths %.6f m\n", state.lengths.sum());
  std::printf("tensions %.6f N\n", state.tensions.sum());
  std::printf("realised %.6f N\n", state.realised.force.norm());
  std::printf("flags %d %d %d\n", state.feasible, state.valid, state.interrupted);

  spidar::TensionSolver solver(geometry);
  const spidar::TensionSolver::Result result = solver.solve(wrench, state.pose);
  std::printf("solved %.6f N, feasible %d\n", result.tensions.sum(), result.feasible);
  const spidar::StringLengths lengths = spidar::string_lengths(geometry, state.pose);
  std::printf("modelled lengths %.6f m\n", lengths.sum());
  const spidar::PoseSolver::Result pose = spidar::PoseSolver(geometry).solve(lengths, {});
  std::printf("pose %.6f %.6f %.6f\n", pose.pose.position.x(), pose.pose.position.y(),
              pose.pose.position.z());
}
