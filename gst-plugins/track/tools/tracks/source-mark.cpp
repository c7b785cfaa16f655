// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tracks/source-mark.hpp"

#include "forms/klv.hpp"
#include "forms/text-line.hpp"
#include "part-file.hpp"
#include "track-error.hpp"

#include <algorithm>
#include <fstream>
#include <string_view>

namespace haptic {
namespace {

constexpr std::size_t kMarkSize = 16;
// A KLV set: its key, three bytes of length (docs/formats/klv.md), and the mark as its first value.
constexpr std::size_t kLengthAt = kMotionKey.size() + 1;
constexpr std::size_t kValuesAt = kLengthAt + 2;
constexpr char kKlvTag[] = {64, kMarkSize};
constexpr std::string_view kTextMark = "src=";
constexpr std::size_t kHeadSize = 16 << 20; // bytes; a copy has fields from the first frame on

const std::string_view kKey(reinterpret_cast<const char *>(kMotionKey.data()), kMotionKey.size());

bool is_mark(std::string_view text) {
  return text.size() == kMarkSize && text.find_first_not_of("0123456789abcdef") == text.npos;
}

} // namespace

void ContentHash::add(const void *bytes, std::size_t size) {
  g_checksum_update(sum_.get(), static_cast<const guchar *>(bytes), static_cast<gssize>(size));
}

std::string ContentHash::digits() const {
  return g_checksum_get_string(sum_.get());
}

std::string hash_of_file(const std::string &path) {
  std::ifstream file(path, std::ios::binary);
  if (!file)
    throw_error(messages::kFileIsForbidden, path.c_str());
  ContentHash hash;
  std::vector<char> bytes(1 << 20);
  while (file.read(bytes.data(), static_cast<std::streamsize>(bytes.size())), file.gcount() > 0)
    hash.add(bytes.data(), static_cast<std::size_t>(file.gcount()));
  return hash.digits();
}

std::string mark_of(const std::string &hash, const std::string &settings) {
  ContentHash both;
  both.add(hash.data(), hash.size());
  both.add(settings.data(), settings.size());
  return both.digits().substr(0, kMarkSize);
}

void insert_mark(std::vector<std::uint8_t> &field, const std::string &mark) {
  const bool is_text = field.size() >= kTextFieldStart.size() &&
                       std::equal(kTextFieldStart.begin(), kTextFieldStart.end(), field.begin());
  const std::string text =
      is_text ? std::string(kTextMark) + mark + " " : std::string(kKlvTag, sizeof kKlvTag) + mark;
  const std::size_t at = is_text ? kTextFieldStart.size() : kValuesAt;
  if (!is_text) {
    const std::size_t length = (field[kLengthAt] << 8 | field[kLengthAt + 1]) + text.size();
    field[kLengthAt] = static_cast<std::uint8_t>(length >> 8);
    field[kLengthAt + 1] = static_cast<std::uint8_t>(length);
  }
  field.insert(field.begin() + static_cast<std::ptrdiff_t>(at), text.begin(), text.end());
}

bool holds_track(const std::string &path) {
  const std::string head = read_start(path, kHeadSize);
  const auto has = [&](std::string_view start) { return head.find(start) != head.npos; };
  return has(kKey) || has(kTextFieldStart) || has(kTextReliefStart) || has(kTextPointStart);
}

std::optional<std::string> mark_in(const std::string &path) {
  const std::string head = read_start(path, kHeadSize);
  const std::string_view all(head);
  const auto mark_behind = [&](std::size_t at, std::string_view start) {
    const bool has = at <= all.size() && all.substr(at).starts_with(start);
    const std::string_view mark = has ? all.substr(at + start.size(), kMarkSize) : "";
    return std::string(is_mark(mark) ? mark : "");
  };
  if (const auto text = all.find(kTextFieldStart); text != all.npos)
    return mark_behind(text + kTextFieldStart.size(), kTextMark);
  if (const auto set = all.find(kKey); set != all.npos)
    return mark_behind(set + kValuesAt, std::string_view(kKlvTag, sizeof kKlvTag));
  return std::nullopt;
}

} // namespace haptic
