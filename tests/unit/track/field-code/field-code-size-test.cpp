// SPDX-License-Identifier: LGPL-2.1-or-later
// Why the field code has models of its own: the simple alternative is larger.
#include "field-code/field-codec.hpp"
#include "leaf-fields.hpp"

#include <gio/gio.h>

#include <gtest/gtest.h>

namespace field_code_size_test {

using Bytes = std::vector<std::uint8_t>;
using Cells = std::vector<haptic::CodedCell>;

std::size_t deflated_size(const Bytes &bytes) {
  GConverter *const deflate = G_CONVERTER(g_zlib_compressor_new(G_ZLIB_COMPRESSOR_FORMAT_RAW, 9));
  Bytes out(2 * bytes.size() + 64);
  gsize read = 0;
  gsize written = 0;
  EXPECT_EQ(g_converter_convert(deflate, bytes.data(), bytes.size(), out.data(), out.size(),
                                G_CONVERTER_INPUT_AT_END, &read, &written, nullptr),
            G_CONVERTER_FINISHED);
  g_object_unref(deflate);
  return written;
}

/// x, then y, then the confidence of all cells as differences from `from`, small ones as small
/// numbers.
Bytes differences(const Cells &cells, const Cells &from) {
  Bytes bytes;
  const auto add = [&](auto number) {
    for (std::size_t i = 0; i < cells.size(); ++i) {
      const int difference = number(cells[i]) - number(from[i]);
      bytes.push_back(
          static_cast<std::uint8_t>(difference < 0 ? -2 * difference - 1 : 2 * difference));
    }
  };
  add([](const haptic::CodedCell &cell) { return int{cell.x}; });
  add([](const haptic::CodedCell &cell) { return int{cell.y}; });
  add([](const haptic::CodedCell &cell) { return int{cell.confidence}; });
  return bytes;
}

// The same numbers, differences from the better one of the same two key fields, without a head.
TEST(FieldCodeSize, DeflateOfTheSameDifferencesIsMoreThanHalfAsLargeAgain) {
  for (const double share : {0.1, 0.25, 0.5, 1.0}) {
    test::LeafFields leaves(2, share);
    haptic::FieldEncoder encoder;
    haptic::FieldDecoder decoder;
    std::array<Cells, 2> keys;
    std::size_t coded = 0;
    std::size_t deflated = 0;
    for (int i = 0; i < 300; ++i) {
      const auto bytes = encoder.push(leaves.next());
      ASSERT_TRUE(bytes && decoder.push(*bytes) == haptic::FieldDecoder::Result::field);
      const Cells &cells = decoder.state().cells;
      coded += bytes->size();
      if (haptic::is_key_field(*bytes)) {
        deflated += deflated_size(differences(cells, Cells(cells.size())));
        keys = {keys[1].empty() ? cells : keys[1], cells};
      } else {
        deflated += std::min(deflated_size(differences(cells, keys[0])),
                             deflated_size(differences(cells, keys[1])));
      }
    }
    const double ratio = static_cast<double>(deflated) / static_cast<double>(coded);
    std::printf("leaves on %.0f %%: deflate is %.2f times as large\n", 100 * share, ratio);
    EXPECT_GT(ratio, 1.5);
  }
}

} // namespace field_code_size_test
