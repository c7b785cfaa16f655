// SPDX-License-Identifier: LGPL-2.1-or-later
// Reliefs in files and packets.
#include "depth-scene.hpp"
#include "track-pipeline.hpp"

#include <cmath>

namespace hapticconvert_relief_test {

using haptic::ReliefField;
using test::DepthScene;
using test::Packet;
using test::run;

constexpr int kCount = 45;
const std::string kReliefIn = "appsrc name=in format=time caps=haptics/x-field,kind=relief";
const std::string kOut =
    " ! hapticconvert ! haptics/x-field,kind=relief ! appsink name=out sync=false";

ReliefField relief_of(const Packet &packet) {
  ReliefField relief;
  EXPECT_TRUE(haptic::unpack_relief_field(packet.bytes, relief));
  return relief;
}

class HapticConvertRelief : public testing::Test {
protected:
  static void SetUpTestSuite() { gst_init(nullptr, nullptr); }

  HapticConvertRelief() {
    for (int i = 0; i < kCount; ++i) {
      const ReliefField relief = DepthScene::relief(i, 32);
      Packet packet{test::Bytes(haptic::packed_size(relief)), i * DepthScene::kInterval,
                    DepthScene::kInterval, 0};
      haptic::pack_relief_field(relief, packet.bytes);
      track.push_back(packet);
    }
  }

  void expect_alike(const std::vector<Packet> &got, double time_error = 0) const {
    ASSERT_EQ(got.size(), track.size());
    for (std::size_t i = 0; i < got.size(); ++i) {
      const ReliefField sent = relief_of(track[i]);
      const ReliefField back = relief_of(got[i]);
      ASSERT_EQ(back.cells.size(), sent.cells.size());
      EXPECT_NEAR(static_cast<double>(got[i].pts - got[0].pts),
                  static_cast<double>(track[i].pts - track[0].pts), time_error);
      for (std::size_t c = 0; c < sent.cells.size(); ++c)
        ASSERT_NEAR(back.cells[c].height, sent.cells[c].height, 0.02 * DepthScene::kRange)
            << i << " " << c;
    }
  }

  std::string file(const char *name) const { return folder.file(name); }

  test::ScratchFolder folder;
  std::vector<Packet> track;
};

TEST_F(HapticConvertRelief, ATransportStreamGivesBackEveryRelief) {
  if (!test::has_elements({"mpegtsmux", "tsdemux"}))
    GTEST_SKIP() << "gstreamer1.0-plugins-bad is not installed";
  const auto made = run(
      kReliefIn + " ! hapticconvert ! meta/x-klv ! mpegtsmux ! filesink location=" + file("r.ts"),
      track);
  ASSERT_EQ(made.error, "");
  const auto got = run("filesrc location=" + file("r.ts") + " ! tsdemux ! meta/x-klv" + kOut);
  EXPECT_EQ(got.error, "");
  expect_alike(got.packets, 0.02e6);
}

TEST_F(HapticConvertRelief, MatroskaTextGivesBackEveryRelief) {
  const auto made = run(kReliefIn +
                            " ! hapticconvert ! text/x-raw ! matroskamux ! "
                            "filesink location=" +
                            file("r.mkv"),
                        track);
  ASSERT_EQ(made.error, "");
  const auto got = run("filesrc location=" + file("r.mkv") + " ! matroskademux" + kOut);
  EXPECT_EQ(got.error, "");
  expect_alike(got.packets, 1e6);
}

TEST_F(HapticConvertRelief, RtpCarriesIt) {
  if (!test::has_elements({"rtpklvpay", "rtpklvdepay"}))
    GTEST_SKIP() << "gstreamer1.0-plugins-good is not installed";
  const auto got =
      run(kReliefIn + " ! hapticconvert ! meta/x-klv ! rtpklvpay ! rtpklvdepay" + kOut, track);
  EXPECT_EQ(got.error, "");
  expect_alike(got.packets, 0.02e6);
}

TEST_F(HapticConvertRelief, ARecordedReliefFindsItsCapsByItself) {
  const auto klv =
      run(kReliefIn + " ! hapticconvert ! meta/x-klv ! appsink name=out sync=false", track);
  const auto got = run("appsrc name=in format=time caps=meta/x-klv,parsed=true ! hapticconvert ! "
                       "appsink name=out sync=false",
                       klv.packets);
  EXPECT_EQ(got.error, "");
  expect_alike(got.packets);
}

TEST_F(HapticConvertRelief, AReliefIsNeverPassedOnAsMotion) {
  const auto klv =
      run(kReliefIn + " ! hapticconvert ! meta/x-klv ! appsink name=out sync=false", track);
  for (const char *motion : {"haptics/x-raw", "haptics/hmpg"}) {
    const auto got = run("appsrc name=in format=time caps=meta/x-klv,parsed=true ! hapticconvert "
                         "! " +
                             std::string(motion) + " ! appsink name=out sync=false",
                         klv.packets);
    EXPECT_NE(got.error, "") << motion;
    EXPECT_TRUE(got.packets.empty()) << motion;
  }
}

} // namespace hapticconvert_relief_test
