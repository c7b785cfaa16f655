// SPDX-License-Identifier: LGPL-2.1-or-later
// As OnBus, with direct-ioctl.cpp.
#pragma once

#include "bus-fixture.hpp"

namespace test {

extern std::atomic<MockBus *> direct_bus;

class DirectlyOnBusOf : public OnBusOf {
protected:
  void SetUp() override {
    OnBusOf::SetUp();
    direct_bus = bus_.get();
  }
  void TearDown() override {
    direct_bus = nullptr;
    OnBusOf::TearDown();
  }
};

} // namespace test
