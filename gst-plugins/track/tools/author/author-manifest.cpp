// SPDX-License-Identifier: LGPL-2.1-or-later
#include "author/author-manifest.hpp"

#include "track-error.hpp"
#include "tracks/track-file.hpp"

#include <cerrno>
#include <cstring>
#include <fstream>
#include <iterator>
#include <rapidjson/document.h>
#include <rapidjson/prettywriter.h>
#include <rapidjson/stringbuffer.h>

namespace haptic {
namespace {

// The columns of the table, and the names in JSON.
constexpr const char *kTexts[] = {"video", "video-sha256", "copy", "copy-sha256"};
constexpr const char *kNumbers[] = {"bytes", "seconds", "frames", "kbit/s", "confidence"};
constexpr char kWarnings[] = "warnings";

std::string csv_quoted(const std::string &text) {
  std::string field = "\"";
  for (const char c : text)
    field += c == '"' ? std::string("\"\"") : std::string(1, c);
  return field + '"';
}

std::string table_of(const std::vector<ManifestRow> &rows) {
  std::string table;
  for (const char *name : kTexts)
    table += std::string(name) + ',';
  for (const char *name : kNumbers)
    table += std::string(name) + ',';
  table += std::string(kWarnings) + "\r\n";
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

std::string json_of(const std::vector<ManifestRow> &rows) {
  rapidjson::StringBuffer text;
  rapidjson::PrettyWriter json(text);
  json.SetIndent(' ', 1);
  json.SetMaxDecimalPlaces(3);
  json.StartArray();
  for (const ManifestRow &row : rows) {
    json.StartObject();
    const std::string *const texts[] = {&row.video, &row.video_hash, &row.copy, &row.copy_hash};
    for (std::size_t i = 0; i < std::size(texts); ++i) {
      json.Key(kTexts[i]);
      json.String(texts[i]->c_str());
    }
    json.Key(kNumbers[0]);
    json.Uint64(row.size);
    json.Key(kNumbers[1]);
    json.Double(row.duration);
    json.Key(kNumbers[2]);
    json.Uint64(row.frames);
    json.Key(kNumbers[3]);
    json.Double(row.kilobits);
    json.Key(kNumbers[4]);
    json.Double(row.confidence);
    json.Key(kWarnings);
    json.StartArray();
    for (const std::string &warning : row.warnings)
      json.String(warning.c_str());
    json.EndArray();
    json.EndObject();
  }
  json.EndArray();
  return std::string(text.GetString(), text.GetSize()) + "\n";
}

ManifestRow row_of(const rapidjson::Value &json) {
  ManifestRow row;
  const auto text = [&](std::size_t i, std::string &value) {
    const auto found = json.FindMember(kTexts[i]);
    if (found != json.MemberEnd() && found->value.IsString())
      value = found->value.GetString();
  };
  const auto count = [&](std::size_t i) {
    const auto found = json.FindMember(kNumbers[i]);
    return found != json.MemberEnd() && found->value.IsUint64() ? found->value.GetUint64() : 0;
  };
  const auto number = [&](std::size_t i) {
    const auto found = json.FindMember(kNumbers[i]);
    return found != json.MemberEnd() && found->value.IsNumber() ? found->value.GetDouble() : 0.0;
  };
  text(0, row.video);
  text(1, row.video_hash);
  text(2, row.copy);
  text(3, row.copy_hash);
  row.size = count(0);
  row.duration = number(1);
  row.frames = count(2);
  row.kilobits = number(3);
  row.confidence = number(4);
  if (const auto found = json.FindMember(kWarnings);
      found != json.MemberEnd() && found->value.IsArray())
    for (const auto &warning : found->value.GetArray())
      if (warning.IsString())
        row.warnings.emplace_back(warning.GetString());
  return row;
}

} // namespace

std::vector<ManifestRow> read_manifest(const std::string &path) {
  std::ifstream file(path, std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  rapidjson::Document document;
  document.Parse<rapidjson::kParseIterativeFlag>(text.c_str(), text.size());
  std::vector<ManifestRow> rows;
  if (!document.HasParseError() && document.IsArray())
    for (const auto &row : document.GetArray())
      if (row.IsObject())
        rows.push_back(row_of(row));
  return rows;
}

void write_manifest(const std::string &stem, const std::vector<ManifestRow> &rows) {
  write_bytes(stem + ".json", json_of(rows));
  write_bytes(stem + ".csv", table_of(rows));
}

} // namespace haptic
