// SPDX-License-Identifier: LGPL-2.1-or-later
// Writes a track of reliefs (KLV) of the scene of depth-scene.hpp.
// Usage: make-reliefs FILE FRAMES [scale=FACTOR] [noise=MM] [delay=FRAMES] [surface=none]
#include "depth-scene.hpp"
#include "field-code/field-codec.hpp"
#include "forms/klv.hpp"

#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <random>
#include <string>
#include <string_view>

namespace {

struct Changes {
  float scale = 1; // of the heights
  float noise = 0; // mm, standard deviation
  int delay = 0;   // frames
  bool has_surface = true;
};

Changes read_changes(int count, char **words) {
  Changes changes;
  for (int i = 0; i < count; ++i) {
    const std::string_view word = words[i];
    const char *value = words[i] + word.find('=') + 1;
    if (word.starts_with("scale="))
      changes.scale = std::strtof(value, nullptr);
    else if (word.starts_with("noise="))
      changes.noise = std::strtof(value, nullptr);
    else if (word.starts_with("delay="))
      changes.delay = std::atoi(value);
    else
      changes.has_surface = false;
  }
  return changes;
}

haptic::ReliefField relief_at(int frame, const Changes &changes, std::mt19937 &random) {
  std::normal_distribution<float> noise;
  haptic::ReliefField relief = test::DepthScene::relief(frame - changes.delay, 32);
  for (haptic::ReliefCell &cell : relief.cells) {
    cell.height = changes.scale * cell.height + 1e-3F * changes.noise * noise(random);
    if (!changes.has_surface)
      cell = {};
  }
  return relief;
}

} // namespace

int main(int argc, char **argv) {
  if (argc < 3) {
    std::fputs("make-reliefs needs a file and a number of frames\n", stderr);
    return EXIT_FAILURE;
  }
  const Changes changes = read_changes(argc - 3, argv + 3);
  std::ofstream file(argv[1], std::ios::binary);
  std::mt19937 random(1);
  haptic::ReliefEncoder encoder;
  for (int i = 0; i < std::atoi(argv[2]); ++i)
    if (auto bytes = encoder.push(relief_at(i, changes, random))) {
      const auto set = haptic::write_klv(haptic::CodedField{
          std::move(*bytes), static_cast<std::uint64_t>(i) * test::DepthScene::kInterval,
          test::DepthScene::kInterval, haptic::FieldKind::relief});
      file.write(reinterpret_cast<const char *>(set.data()),
                 static_cast<std::streamsize>(set.size()));
    }
  return file.flush() ? EXIT_SUCCESS : EXIT_FAILURE;
}
