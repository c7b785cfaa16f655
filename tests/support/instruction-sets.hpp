// SPDX-License-Identifier: LGPL-2.1-or-later
// The vector code of the vision room on every instruction set of this processor.
#pragma once

#include <cstdint>
#include <hwy/targets.h>

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

/// Calls body(name) on each instruction set, the best first.
template <typename Body>
void for_instruction_sets(Body &&body) {
  for (const std::int64_t target : hwy::SupportedAndGeneratedTargets()) {
    const InstructionSet only(target);
    body(hwy::TargetName(target));
  }
}

} // namespace test
