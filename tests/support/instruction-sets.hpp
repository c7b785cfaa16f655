// SPDX-License-Identifier: LGPL-2.1-or-later
// The vector code of the vision room on every instruction set of this processor.
#pragma once

#include <cstdint>
#include <gtest/gtest.h>
#include <hwy/targets.h>
#include <vector>

namespace test {

/// Restricts dynamic dispatch to one instruction set while it exists.
class InstructionSet {
public:
  explicit InstructionSet(std::int64_t target) {
    hwy::SetSupportedTargetsForTest(target);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
  }
  ~InstructionSet() {
    hwy::SetSupportedTargetsForTest(0);
    hwy::GetChosenTarget().DeInit();
  }
  InstructionSet(const InstructionSet &) = delete;
  InstructionSet &operator=(const InstructionSet &) = delete;
};

/// Calls body(name) on each instruction set, the best first. Skips the test where there is none:
/// Highway 1.0 wants AES on arm64, which a Raspberry Pi 4 does not have.
template <typename Body>
void for_instruction_sets(Body &&body) {
  const std::vector<std::int64_t> targets = hwy::SupportedAndGeneratedTargets();
  if (targets.empty())
    GTEST_SKIP() << "Highway has no code for this processor";
  for (const std::int64_t target : targets) {
    const InstructionSet only(target);
    body(hwy::TargetName(target));
  }
}

} // namespace test
