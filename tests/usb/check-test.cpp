// SPDX-License-Identifier: LGPL-2.1-or-later
// What spidar-check finds out about controllers on USB, good ones and broken ones. Its own time is
// simulated, and there is no guardian: check-guardian-test.cpp.
#include "direct-fixture.hpp"
#include "promises.hpp"

#include <map>

namespace check_test {

using namespace test;
using namespace spidar_check;

/// Hands everything on but the guard.
class Unguarded final : public spidar::Controller {
public:
  Unguarded() : inner_(spidar::open_usb("")) {}
  bool exchange(const spidar::DacWords &words, spidar::Counts &counts) noexcept override {
    return inner_->exchange(words, counts);
  }
  bool connected() const noexcept override { return inner_->connected(); }
  std::string description() const override { return inner_->description(); }

private:
  std::unique_ptr<spidar::Controller> inner_;
};

class Check : public DirectlyOnBusOf {
protected:
  void SetUp() override {
    DirectlyOnBusOf::SetUp();
    if (!IsSkipped())
      plug(GetParam(), 5);
  }
  void TearDown() override {
    checked_.reset();
    DirectlyOnBusOf::TearDown();
  }

  void open() {
    checked_ = std::make_unique<Unit>(std::make_unique<Unguarded>(),
                                      spidar::load_geometry(spidar::kDefaultGeometry),
                                      std::make_shared<SimulatedTime>());
  }
  Report report() {
    return [this](const Finding &finding) { verdicts_[finding.promise] = finding.verdict; };
  }
  /// Opens a good unit, breaks it, and expects that it may not pull.
  template <class Break>
  void expect_refused(const char *promise, Break break_it) {
    allow_exchanges(2ms);
    open();
    unit_->faults(break_it);
    EXPECT_FALSE(check_answers(*checked_, report()));
    EXPECT_EQ(verdicts_[promise], Verdict::fail);
    unit_->faults([](Faults &faults) { faults = {}; });
  }

  std::unique_ptr<Unit> checked_;
  std::map<std::string, Verdict> verdicts_;
};
INSTANTIATE_TEST_SUITE_P(Both, Check, ::testing::Values(Model::simple, Model::sh4), name_of_model);

TEST_P(Check, FindsNothingWrongWithAGoodUnit) {
  open();
  EXPECT_TRUE(check_answers(*checked_, report()));
  check_force(*checked_, 0.2, report());
  const auto record = checked_->shared_record();
  checked_.reset();
  EXPECT_EQ(verdicts_.size(), 6U);
  for (const auto &[promise, verdict] : verdicts_)
    EXPECT_EQ(verdict, Verdict::pass) << promise;
  EXPECT_TRUE(record->last_answered);
}

TEST_P(Check, RefusesAUnitThatIsSilent) {
  expect_refused("the device answers", [](Faults &faults) { faults.silent = true; });
}

TEST_P(Check, RefusesAUnitThatIsLate) {
  expect_refused("the device answers", [](Faults &faults) { faults.late_by = 20ms; });
}

TEST_P(Check, RefusesAUnitThatTakesNothing) {
  expect_refused("the device answers", [](Faults &faults) { faults.refuse_out = true; });
}

TEST_P(Check, RefusesAUnitWhoseRepliesAreShort) {
  expect_refused("the device answers", [](Faults &faults) { faults.short_replies = 1000; });
}

TEST_P(Check, RefusesAUnitThatAnswersForAnother) {
  expect_refused("the device answers", [](Faults &faults) {
    faults.mangle = [](Bytes &reply) { reply[GetParam() == Model::sh4 ? 48 : 24] ^= 0x10; };
  });
}

TEST_P(Check, RefusesAUnitWhoseCountsFitNoPose) {
  expect_refused("the pose is known", [](Faults &faults) {
    faults.offset = {5000, -3000, 5000, -3000, 5000, -3000, 5000, -3000};
  });
}

TEST_P(Check, ForgivesTwoLostReplies) {
  allow_exchanges(250ms);
  open();
  unit_->faults([](Faults &faults) { faults.short_replies = 2; });
  EXPECT_TRUE(check_answers(*checked_, report()));
  EXPECT_EQ(verdicts_["the device answers"], Verdict::pass);
}

} // namespace check_test
