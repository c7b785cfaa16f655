// SPDX-License-Identifier: LGPL-2.1-or-later
#include "forms/text-line.hpp"

#include "core/track-time.hpp"
#include "glue/gst-raii.hpp"
#include "samples/motion-field.hpp"

#include <algorithm>
#include <array>
#include <charconv>

namespace haptic {
namespace {

constexpr std::string_view kPoint = "point";
constexpr std::string_view kField = "field";
constexpr std::string_view kRelief = "relief";
constexpr std::size_t kLongestLine = 131072;
constexpr std::size_t kMostCode = 65'000; // bytes of a field, so that KLV can hold it

// By the bits of MotionFlags, the lowest first.
constexpr std::array<std::string_view, 6> kFlagNames = {"still",         "duplicate", "cut",
                                                        "discontinuity", "mixture",   "aperture"};
static_assert(kMotionStill == 1 << 0 && kMotionDuplicate == 1 << 1 && kMotionCut == 1 << 2 &&
              kMotionDiscontinuity == 1 << 3 && kMotionMixture == 1 << 4 &&
              kMotionAperture == 1 << 5);
constexpr std::array<MotionModel, 5> kModels = {MotionModel::none, MotionModel::still,
                                                MotionModel::translation, MotionModel::similarity,
                                                MotionModel::affine};

// ---- writing ------------------------------------------------------------------------------------

class LineWriter {
public:
  explicit LineWriter(std::string_view kind) : text_(kTextMagic) { word(kind); }
  void word(std::string_view word) { text_.append(" ").append(word); }
  void field(std::string_view name, std::string_view value) {
    text_.append(" ").append(name).append("=").append(value);
  }
  template <typename Number>
  void number(std::string_view name, Number value) {
    std::array<char, 32> digits;
    const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), value);
    field(name, std::string_view(digits.data(), end.ptr));
  }
  void pair(std::string_view name, std::uint32_t a, char between, std::uint32_t b) {
    field(name, std::to_string(a) + between + std::to_string(b));
  }
  // Seconds with all nine decimals.
  void time(std::string_view name, std::uint64_t nanoseconds) {
    const std::string decimals = std::to_string(nanoseconds % kSecond);
    field(name, std::to_string(nanoseconds / kSecond) + '.' +
                    std::string(9 - decimals.size(), '0') + decimals);
  }
  std::string finish() { return std::move(text_); }

private:
  std::string text_;
};

std::string flag_names(std::uint16_t flags) {
  std::string names;
  for (std::size_t i = 0; i < kFlagNames.size(); ++i)
    if (flags >> i & 1)
      names.append(names.empty() ? "" : ",").append(kFlagNames[i]);
  return names;
}

// ---- reading ------------------------------------------------------------------------------------

template <typename Number>
bool parse(std::string_view text, Number &value) {
  const auto end = std::from_chars(text.data(), text.data() + text.size(), value);
  return end.ec == std::errc() && end.ptr == text.data() + text.size();
}

bool parse_pair(std::string_view text, char between, std::uint32_t &a, std::uint32_t &b) {
  const auto at = text.find(between);
  return at != std::string_view::npos && parse(text.substr(0, at), a) &&
         parse(text.substr(at + 1), b);
}

bool parse_time(std::string_view text, std::uint64_t &nanoseconds) {
  const auto point = text.find('.');
  std::uint64_t seconds = 0;
  if (!parse(text.substr(0, point), seconds) || seconds > kNoTime / kSecond - 1)
    return false;
  std::uint64_t fraction = 0;
  if (point != std::string_view::npos) {
    const auto decimals = text.substr(point + 1);
    if (decimals.empty() || decimals.size() > 9 || !parse(decimals, fraction))
      return false;
    for (auto digits = decimals.size(); digits < 9; ++digits)
      fraction *= 10;
  }
  nanoseconds = seconds * kSecond + fraction;
  return true;
}

bool parse_flags(std::string_view text, std::uint16_t &flags) {
  while (!text.empty()) {
    const auto comma = std::min(text.find(','), text.size());
    const auto found = std::find(kFlagNames.begin(), kFlagNames.end(), text.substr(0, comma));
    if (found != kFlagNames.end()) // later versions may have more names
      flags = static_cast<std::uint16_t>(flags | 1U << (found - kFlagNames.begin()));
    text.remove_prefix(std::min(comma + 1, text.size()));
  }
  return true;
}

bool parse_model(std::string_view text, MotionModel &model) {
  for (const auto candidate : kModels)
    if (motion_model_name(candidate) == text) {
      model = candidate;
      return true;
    }
  return false;
}

bool parse_hold_state(std::string_view text, HoldState &state) {
  const std::optional<HoldState> named = hold_state_named(text);
  state = named.value_or(HoldState::none);
  return named.has_value();
}

constexpr std::array<std::string_view, 22> kNames = {
    "t",     "d",    "i",      "vx",     "vy",          "spin",     "div", "x",
    "y",     "w",    "h",      "conf",   "pic",         "par",      "n",   "model",
    "flags", "held", "hold-x", "hold-y", "hold-radius", "hold-time"};
constexpr unsigned kHeld = 1U << 17;
constexpr unsigned kBesidesHeld = 1U << 18 | 1U << 19 | 1U << 20 | 1U << 21;
constexpr unsigned kOptional = 1U << 0 | 1U << 1 | 1U << 16 | kHeld; // t, d, flags

bool parse_field(std::size_t which, std::string_view value, TrackSample &sample) {
  MotionSample &s = sample.motion;
  switch (which) {
  case 0:
    return parse_time(value, sample.time);
  case 1:
    return parse_time(value, sample.duration);
  case 2:
    return parse_time(value, s.interval);
  case 3:
    return parse(value, s.velocity_x);
  case 4:
    return parse(value, s.velocity_y);
  case 5:
    return parse(value, s.spin);
  case 6:
    return parse(value, s.divergence);
  case 7:
    return parse(value, s.pointer_x);
  case 8:
    return parse(value, s.pointer_y);
  case 9:
    return parse(value, s.region_width);
  case 10:
    return parse(value, s.region_height);
  case 11:
    return parse(value, s.confidence);
  case 12:
    return parse_pair(value, 'x', s.frame_width, s.frame_height);
  case 13:
    return parse_pair(value, ':', s.pixel_aspect_n, s.pixel_aspect_d);
  case 14:
    return parse(value, s.points);
  case 15:
    return parse_model(value, s.model);
  case 16:
    return parse_flags(value, s.flags);
  case 17:
    return parse_hold_state(value, s.held.state);
  case 18:
    return parse(value, s.held.x);
  case 19:
    return parse(value, s.held.y);
  case 20:
    return parse(value, s.held.radius);
  default:
    return parse_time(value, s.held.time);
  }
}

// Removes the next word from the line and returns it. It is empty at the end.
std::string_view next_word(std::string_view &line) {
  const auto begin = std::min(line.find_first_not_of(' '), line.size());
  const auto end = std::min(line.find(' ', begin), line.size());
  const auto word = line.substr(begin, end - begin);
  line.remove_prefix(end);
  return word;
}

TextLine wrong(std::string error) {
  return {std::nullopt, std::nullopt, std::move(error)};
}

// Returns nothing if it is not base64 from its beginning to its end.
std::optional<std::vector<std::uint8_t>> decode_base64(std::string_view text) {
  const auto digits = text.substr(0, text.find('='));
  const auto is_digit = [](char c) { return g_ascii_isalnum(c) || c == '+' || c == '/'; };
  if (text.empty() || text.size() % 4 != 0 || text.size() - digits.size() > 2 ||
      !std::ranges::all_of(digits, is_digit) ||
      !std::ranges::all_of(text.substr(digits.size()), [](char c) { return c == '='; }))
    return std::nullopt;
  gsize size = 0;
  guchar *bytes = g_base64_decode(std::string(text).c_str(), &size);
  std::vector<std::uint8_t> decoded(bytes, bytes + size);
  g_free(bytes);
  return decoded;
}

// Reads the line behind the word "field" or "relief".
TextLine read_field(std::string_view line, FieldKind kind) {
  CodedField field;
  field.kind = kind;
  for (auto word = next_word(line); !word.empty(); word = next_word(line)) {
    const auto equals = std::min(word.find('='), word.size());
    const auto name = word.substr(0, equals);
    const auto value = word.substr(std::min(equals + 1, word.size()));
    if ((name == "t" && field.time != kNoTime) || (name == "d" && field.duration != kNoTime))
      return wrong("the value " + std::string(name) + " is there twice");
    if ((name == "t" && !parse_time(value, field.time)) ||
        (name == "d" && !parse_time(value, field.duration)))
      return wrong("the value " + std::string(name) + " cannot be read");
    const bool is_code = name == "b";
    if (!is_code && (name != "things" || kind == FieldKind::relief))
      continue;
    auto &read = is_code ? field.bytes : field.things;
    auto bytes = decode_base64(value);
    if (!bytes || !read.empty() || (!is_code && !are_field_things(*bytes)))
      return wrong("the value " + std::string(name) + " cannot be read");
    read = std::move(*bytes);
  }
  if (field.bytes.empty())
    return wrong("the value b is missing");
  if (field.bytes.size() + field.things.size() > kMostCode)
    return wrong("the value b is too long");
  return {std::nullopt, std::move(field), {}};
}

} // namespace

bool begins_text_line(std::span<const std::uint8_t> bytes) noexcept {
  const std::string_view line(reinterpret_cast<const char *>(bytes.data()), bytes.size());
  const auto version = std::min(kTextName.size(), line.size());
  const auto end = line.find_first_not_of("0123456789", version);
  return line.starts_with(kTextName) && end > version && end != line.npos && line[end] == ' ';
}

std::string write_text_line(const TrackSample &sample) {
  const MotionSample &s = sample.motion;
  LineWriter out(kPoint);
  if (sample.time != kNoTime)
    out.time("t", sample.time);
  if (sample.duration != kNoTime)
    out.time("d", sample.duration);
  out.time("i", s.interval);
  out.number("vx", s.velocity_x);
  out.number("vy", s.velocity_y);
  out.number("spin", s.spin);
  out.number("div", s.divergence);
  out.number("x", s.pointer_x);
  out.number("y", s.pointer_y);
  out.number("w", s.region_width);
  out.number("h", s.region_height);
  out.number("conf", s.confidence);
  if (s.held.state != HoldState::none) {
    out.field("held", hold_state_name(s.held.state));
    out.number("hold-x", s.held.x);
    out.number("hold-y", s.held.y);
    out.number("hold-radius", s.held.radius);
    out.time("hold-time", s.held.time);
  }
  out.pair("pic", s.frame_width, 'x', s.frame_height);
  out.pair("par", s.pixel_aspect_n, ':', s.pixel_aspect_d);
  out.number("n", s.points);
  out.field("model", motion_model_name(s.model));
  if (const auto names = flag_names(s.flags); !names.empty())
    out.field("flags", names);
  return out.finish();
}

std::string write_text_line(const CodedField &field) {
  LineWriter out(field.kind == FieldKind::relief ? kRelief : kField);
  if (field.time != kNoTime)
    out.time("t", field.time);
  if (field.duration != kNoTime)
    out.time("d", field.duration);
  const auto add = [&](const char *name, const std::vector<std::uint8_t> &bytes) {
    const GCharPtr base64(g_base64_encode(bytes.data(), bytes.size()));
    out.field(name, base64.get());
  };
  add("b", field.bytes);
  if (!field.things.empty())
    add("things", field.things);
  return out.finish();
}

TextLine read_text_line(std::string_view line) {
  constexpr std::string_view kAround(" \t\r\n\0", 5);
  const auto begin = std::min(line.find_first_not_of(kAround), line.size());
  line = line.substr(begin, line.find_last_not_of(kAround) + 1 - begin);
  if (line.size() > kLongestLine)
    return wrong("the line is too long");
  const auto magic = next_word(line);
  if (magic != kTextMagic)
    return wrong(magic.starts_with(kTextName) ? "another version of the format"
                                              : "this is not a motion sample");
  const auto kind = next_word(line);
  if (kind == kField)
    return read_field(line, FieldKind::motion);
  if (kind == kRelief)
    return read_field(line, FieldKind::relief);
  if (kind != kPoint)
    return wrong("another kind of sample");
  TrackSample sample;
  unsigned seen = 0;
  for (auto word = next_word(line); !word.empty(); word = next_word(line)) {
    const auto equals = std::min(word.find('='), word.size());
    const auto name = word.substr(0, equals);
    const auto found = std::find(kNames.begin(), kNames.end(), name);
    if (found == kNames.end())
      continue; // a later version's
    const auto which = static_cast<std::size_t>(found - kNames.begin());
    if (seen >> which & 1)
      return wrong("the value " + std::string(name) + " is there twice");
    seen |= 1U << which;
    if (equals == word.size() || !parse_field(which, word.substr(equals + 1), sample))
      return wrong("the value " + std::string(name) + " cannot be read");
  }
  if (!(seen & kHeld)) {
    sample.motion.held = {};
    seen |= kBesidesHeld;
  }
  for (std::size_t i = 0; i < kNames.size(); ++i)
    if (!((seen | kOptional) >> i & 1))
      return wrong("the value " + std::string(kNames[i]) + " is missing");
  if (!is_valid(sample.motion))
    return wrong("a value is out of its range");
  return {sample, std::nullopt, {}};
}

} // namespace haptic
