// SPDX-License-Identifier: LGPL-2.1-or-later
#include "film/matroska-track.hpp"

#include "track-error.hpp"

#include <cerrno>
#include <cstring>
#include <fstream>
#include <string_view>

namespace haptic {
namespace {

// The ID of an element of Matroska (RFC 9559).
constexpr std::string_view kCluster = "\x1f\x43\xb6\x75";
constexpr std::string_view kHuffyuvCode = "HFYU"; // the codec's name in a BITMAPINFOHEADER
constexpr std::string_view kDnxhdCode = "AVdn";
constexpr std::size_t kHeaderSize = 1 << 16; // the tracks stand before the first cluster

// Reads what stands before the first cluster.
std::string read_header(std::fstream &file) {
  std::string header(kHeaderSize, '\0');
  file.read(header.data(), static_cast<std::streamsize>(header.size()));
  file.clear();
  return header.substr(0, header.find(kCluster));
}

} // namespace

void name_dnxhd(const std::string &path) {
  std::fstream file(path, std::ios::binary | std::ios::in | std::ios::out);
  if (const std::size_t at = read_header(file).find(kHuffyuvCode); at != std::string::npos) {
    file.seekp(static_cast<std::streamoff>(at));
    file << kDnxhdCode << std::flush;
  }
  if (!file)
    throw_error(messages::kOutputFails, path.c_str(), std::strerror(errno));
}

} // namespace haptic
