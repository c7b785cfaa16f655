#include "device-choice.hpp"

#include <spidar/error.hpp>
#include <spidar/simulator.hpp>
#include <spidar/usb.hpp>

namespace haptic {
namespace {

std::unique_ptr<spidar::Controller> open_controller(const DeviceChoice &choice,
                                                    const spidar::Geometry &geometry,
                                                    bool &simulated_instead) {
  const std::string &device = choice.device;
  simulated_instead = device == "auto" && !spidar::usb_present();
  if (device == "sim" || simulated_instead)
    return std::make_unique<spidar::Simulator>(geometry, spidar::parse_hand_script(choice.sim_hand),
                                               1.0 / choice.rate);
  if (device == "auto" || device == "usb")
    return spidar::open_usb("");
  const std::string prefix = "usb:";
  if (device.starts_with(prefix) && device.size() > prefix.size())
    return spidar::open_usb(device.substr(prefix.size()));
  throw spidar::Error(spidar::Cause::argument,
                      "The device \"" + device +
                          "\" is not known. Use auto, sim, usb, usb:ID or none.");
}

} // namespace

OpenedDevice open_device(const DeviceChoice &choice) {
  OpenedDevice opened;
  if (choice.device == "none")
    return opened;
  const spidar::Geometry geometry = spidar::load_geometry(choice.geometry);
  auto controller = open_controller(choice, geometry, opened.simulated_instead);
  opened.device =
      std::make_unique<spidar::Device>(std::move(controller), geometry, 1.0 / choice.rate);
  return opened;
}

std::unique_ptr<spidar::Device> reopen_device(DeviceChoice choice) {
  if (choice.device == "auto")
    choice.device = "usb";
  return open_device(choice).device;
}

} // namespace haptic
