// SPDX-License-Identifier: LGPL-2.1-or-later
#include "author/author-manifest.hpp"

#include "json.hpp"
#include "part-file.hpp"
#include "track-error.hpp"

#include <fstream>
#include <iomanip>
#include <sstream>

namespace haptic {
namespace {

std::string table_of(const std::vector<ManifestRow> &rows) {
  const auto quoted = [](const std::string &text) { return std::quoted(text, '"', '"'); };
  std::ostringstream table;
  table
      << "video,video-sha256,copy,copy-sha256,bytes,seconds,frames,kbit/s,confidence,warnings\r\n";
  for (const ManifestRow &row : rows) {
    for (const std::string *text : {&row.video, &row.video_hash, &row.copy, &row.copy_hash})
      table << quoted(*text) << ',';
    table << format_text("%llu,%.3f,%llu,%.1f,%.3f,", static_cast<unsigned long long>(row.size),
                         row.duration, static_cast<unsigned long long>(row.frames), row.kilobits,
                         row.confidence);
    std::string warnings;
    for (const std::string &warning : row.warnings)
      warnings += (warnings.empty() ? "" : "; ") + warning;
    table << quoted(warnings) << "\r\n";
  }
  return table.str();
}

} // namespace

std::vector<ManifestRow> read_manifest(const std::string &path) {
  std::ifstream file(path, std::ios::binary);
  try {
    return Json::parse(file);
  } catch (const std::exception &) { // as if there were none
    return {};
  }
}

void write_manifest(const std::string &stem, const std::vector<ManifestRow> &rows) {
  write_bytes(stem + ".json", Json(rows).dump(1) + "\n");
  write_bytes(stem + ".csv", table_of(rows));
}

} // namespace haptic
