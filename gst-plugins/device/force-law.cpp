#include "force-law.hpp"

#include <array>

namespace haptic {

// A new law is a file of its own with its maker, and a line in this table.
std::unique_ptr<ForceLaw> make_arctan_law();
std::unique_ptr<ForceLaw> make_arctan_axis_law();

namespace {
constexpr std::array kLaws = {
    ForceLawInfo{"arctan", "Equation 5 on the speed, along the motion", make_arctan_law},
    ForceLawInfo{"arctan-axis", "Equation 5 on each axis, as printed", make_arctan_axis_law},
};
}

std::span<const ForceLawInfo> force_laws() noexcept {
  return kLaws;
}

} // namespace haptic
