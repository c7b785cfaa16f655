// SPDX-License-Identifier: LGPL-2.1-or-later
#include "author/author-manifest.hpp"

#include "json.hpp"
#include "part-file.hpp"
#include "track-error.hpp"

#include <fstream>

namespace haptic {
namespace {

std::string csv_quoted(const std::string &text) {
  std::string field = "\"";
  for (const char c : text)
    field += c == '"' ? std::string("\"\"") : std::string(1, c);
  return field + '"';
}

std::string table_of(const std::vector<ManifestRow> &rows) {
  std::string table = "video,video-sha256,copy,copy-sha256,bytes,seconds,frames,kbit/s,confidence,"
                      "warnings\r\n";
  for (const ManifestRow &row : rows) {
    for (const std::string *text : {&row.video, &row.video_hash, &row.copy, &row.copy_hash})
      table += csv_quoted(*text) + ',';
    table += format_text("%llu,%.3f,%llu,%.1f,%.3f,", static_cast<unsigned long long>(row.size),
                         row.duration, static_cast<unsigned long long>(row.frames), row.kilobits,
                         row.confidence);
    std::string warnings;
    for (const std::string &warning : row.warnings)
      warnings += (warnings.empty() ? "" : "; ") + warning;
    table += csv_quoted(warnings) + "\r\n";
  }
  return table;
}

Json json_of(const ManifestRow &row) {
  return {{"video", row.video},
          {"video-sha256", row.video_hash},
          {"copy", row.copy},
          {"copy-sha256", row.copy_hash},
          {"bytes", row.size},
          {"seconds", rounded(row.duration, 1e3)},
          {"frames", row.frames},
          {"kbit/s", rounded(row.kilobits, 1e3)},
          {"confidence", rounded(row.confidence, 1e3)},
          {"warnings", row.warnings}};
}

ManifestRow row_of(const Json &json) {
  return {json.at("video"),      json.at("video-sha256"), json.at("copy"),   json.at("copy-sha256"),
          json.at("bytes"),      json.at("seconds"),      json.at("frames"), json.at("kbit/s"),
          json.at("confidence"), json.at("warnings")};
}

} // namespace

std::vector<ManifestRow> read_manifest(const std::string &path) {
  std::ifstream file(path, std::ios::binary);
  std::vector<ManifestRow> rows;
  try {
    for (const Json &row : Json::parse(file))
      rows.push_back(row_of(row));
  } catch (const Json::exception &) { // as if there were none
    rows.clear();
  }
  return rows;
}

void write_manifest(const std::string &stem, const std::vector<ManifestRow> &rows) {
  Json json = Json::array();
  for (const ManifestRow &row : rows)
    json.push_back(json_of(row));
  write_bytes(stem + ".json", json.dump(1) + "\n");
  write_bytes(stem + ".csv", table_of(rows));
}

} // namespace haptic
