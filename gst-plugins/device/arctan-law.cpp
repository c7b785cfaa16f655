// The paper's nonlinear gain controller, equation 5: F = (2 F_max / pi) atan(alpha v).
#include "force-law.hpp"

#include <cmath>
#include <numbers>

namespace haptic {

std::unique_ptr<ForceLaw> make_arctan_law();
std::unique_ptr<ForceLaw> make_arctan_axis_law();

namespace {

/// Equation 5 divided by v, N·s/px: finite and smooth also at v = 0.
double gain(double v, const LawSettings &settings) {
  const double scale = 2 * settings.max_force / std::numbers::pi;
  const double x = settings.alpha * v;
  // Below 1e-4 the next term of the series is less than 1e-17.
  if (std::abs(x) < 1e-4)
    return scale * settings.alpha * (1 - x * x / 3);
  return scale * std::atan(x) / v;
}

// On the speed: the force keeps the direction of the motion and never exceeds max_force. Picture y
// points down, device y up.
class ArctanLaw final : public ForceLaw {
public:
  spidar::Vector3 force(const Motion &m, const Hand &, const LawSettings &s) noexcept override {
    const double k = gain(std::hypot(m.velocity_x, m.velocity_y), s);
    return {k * m.velocity_x, -k * m.velocity_y, 0};
  }
};

// As printed. It bends diagonal motions towards the diagonal, and its length reaches 1.41 max_force
// (the safety chain cuts that).
class ArctanAxisLaw final : public ForceLaw {
public:
  spidar::Vector3 force(const Motion &m, const Hand &, const LawSettings &s) noexcept override {
    return {gain(m.velocity_x, s) * m.velocity_x, -gain(m.velocity_y, s) * m.velocity_y, 0};
  }
};

} // namespace

std::unique_ptr<ForceLaw> make_arctan_law() {
  return std::make_unique<ArctanLaw>();
}

std::unique_ptr<ForceLaw> make_arctan_axis_law() {
  return std::make_unique<ArctanAxisLaw>();
}

} // namespace haptic
